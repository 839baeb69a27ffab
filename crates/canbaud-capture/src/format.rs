//! The formats by name.

use core::fmt;
use core::str::FromStr;

/// The width of one sample in a Saleae Logic 1 binary export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WordSize {
    /// 8 bits: channels 0 to 7.
    Bits8,
    /// 16 bits.
    Bits16,
    /// 32 bits.
    Bits32,
    /// 64 bits.
    Bits64,
}

impl WordSize {
    /// Every width.
    pub const ALL: [Self; 4] = [Self::Bits8, Self::Bits16, Self::Bits32, Self::Bits64];

    /// The width in bytes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::Bits8 => 1,
            Self::Bits16 => 2,
            Self::Bits32 => 4,
            Self::Bits64 => 8,
        }
    }
}

/// A capture file format.
///
/// Reads and prints the names that an option takes.
///
/// ```
/// use canbaud_capture::{Format, WordSize};
/// assert_eq!("vcd".parse(), Ok(Format::Vcd));
/// assert_eq!("logic1-changes-16".parse(), Ok(Format::Logic1Changes(WordSize::Bits16)));
/// assert_eq!(Format::SigrokSr.to_string(), "sr");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// sigrok session, `.sr`, versions 1 and 2.
    SigrokSr,
    /// Value change dump, `.vcd`.
    Vcd,
    /// sigrok CSV output, which PulseView writes too.
    SigrokCsv,
    /// Saleae Logic 2 CSV export.
    SaleaeCsv,
    /// Saleae Logic 2 binary export, versions 0 and 1.
    SaleaeBinary,
    /// Saleae Logic 1 binary export, a word per sample.
    Logic1Samples(WordSize),
    /// Saleae Logic 1 binary export, a sample number and a word per change.
    Logic1Changes(WordSize),
    /// Saleae Logic 1 `.logicdata`, version 5.
    LogicData,
    /// DSView session, `.dsl` or `.demo`, version 3.
    DsView,
    /// Oscilloscope CSV of any maker.
    ScopeCsv,
    /// Tektronix `.isf`.
    TekIsf,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 17] = [
        Self::SigrokSr,
        Self::Vcd,
        Self::SigrokCsv,
        Self::SaleaeCsv,
        Self::SaleaeBinary,
        Self::Logic1Samples(WordSize::Bits8),
        Self::Logic1Samples(WordSize::Bits16),
        Self::Logic1Samples(WordSize::Bits32),
        Self::Logic1Samples(WordSize::Bits64),
        Self::Logic1Changes(WordSize::Bits8),
        Self::Logic1Changes(WordSize::Bits16),
        Self::Logic1Changes(WordSize::Bits32),
        Self::Logic1Changes(WordSize::Bits64),
        Self::LogicData,
        Self::DsView,
        Self::ScopeCsv,
        Self::TekIsf,
    ];

    /// The name that an option takes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SigrokSr => "sr",
            Self::Vcd => "vcd",
            Self::SigrokCsv => "sigrok-csv",
            Self::SaleaeCsv => "saleae-csv",
            Self::SaleaeBinary => "saleae-bin",
            Self::Logic1Samples(WordSize::Bits8) => "logic1-8",
            Self::Logic1Samples(WordSize::Bits16) => "logic1-16",
            Self::Logic1Samples(WordSize::Bits32) => "logic1-32",
            Self::Logic1Samples(WordSize::Bits64) => "logic1-64",
            Self::Logic1Changes(WordSize::Bits8) => "logic1-changes-8",
            Self::Logic1Changes(WordSize::Bits16) => "logic1-changes-16",
            Self::Logic1Changes(WordSize::Bits32) => "logic1-changes-32",
            Self::Logic1Changes(WordSize::Bits64) => "logic1-changes-64",
            Self::LogicData => "logicdata",
            Self::DsView => "dsl",
            Self::ScopeCsv => "scope-csv",
            Self::TekIsf => "isf",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A format name that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown capture format {0:?} (known: {known})", known = Format::ALL.map(Format::name).join(", "))]
pub struct UnknownFormat(String);

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|format| format.name().eq_ignore_ascii_case(text))
            .ok_or_else(|| UnknownFormat(text.to_owned()))
    }
}
