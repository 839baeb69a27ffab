//! Whose firmware answers, and what its commands mean; no I/O, no allocation.

use canbaud::detect::scan::Evidence;
use canbaud::units::{Bitrate, Hertz};

/// What an adapter said of itself; an answer that did not come is empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Answers<'a> {
    /// To `C`: whether there was CR or BEL.
    pub confirms: bool,
    /// To `V`.
    pub version: &'a [u8],
    /// To `v`.
    pub detail: &'a [u8],
    /// To `N`.
    pub serial: &'a [u8],
    /// To `i`.
    pub controller: &'a [u8],
}

/// A firmware, as far as its commands differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Firmware {
    /// CAN232, CANUSB and what says the same of itself: a SJA1000 with 16 MHz.
    Lawicel,
    /// USBtin: a MCP2515 with 24 MHz.
    Usbtin,
    /// Nakakiyo092/canable2-fw: a FDCAN of ST, whose clock it tells.
    Canable2 {
        /// The clock of the controller.
        clock: Option<Hertz>,
    },
    /// The firmwares that CANable 1.x and 2.0 come with: they answer nothing but `V`, and have no
    /// `L`.
    CanableStock,
    /// One that answers, unknown otherwise.
    Other,
}

impl Firmware {
    /// Whose answers these are; `None` if nothing answered at all.
    #[must_use]
    pub fn identify(answers: &Answers<'_>) -> Option<Self> {
        let Answers { version, detail, serial, controller, .. } = *answers;
        let anywhere = |text: &[u8]| {
            [version, detail].iter().any(|said| said.windows(text.len()).any(|part| part == text))
        };
        if !answers.confirms {
            let stock = anywhere(b"canable") || anywhere(b"CANable") || anywhere(b"cantact");
            return match (stock, version.is_empty()) {
                (true, _) => Some(Self::CanableStock),
                (false, true) => None,
                (false, false) => Some(Self::Other),
            };
        }
        if version.starts_with(b"VL2K") || anywhere(b"Nakakiyo092/canable2-fw") {
            return Some(Self::Canable2 { clock: clock_of(controller) });
        }
        // Both say V and four digits.
        let plain = |text: &[u8], letter, digits: usize| {
            text.split_first().is_some_and(|(first, rest)| {
                *first == letter && rest.len() == digits && rest.iter().all(u8::is_ascii_hexdigit)
            })
        };
        if version.starts_with(b"V01") && plain(detail, b'v', 4) && plain(serial, b'N', 4) {
            return Some(Self::Usbtin);
        }
        // V1013 with serial number N and four letters or digits [CAN232 and CANUSB manuals].
        let numbered = serial.first() == Some(&b'N') && serial.len() == 5;
        if version.starts_with(b"V1") && plain(version, b'V', 4) && numbered {
            return Some(Self::Lawicel);
        }
        Some(Self::Other)
    }

    /// What people call it.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Lawicel => "Lawicel CAN232 or CANUSB",
            Self::Usbtin => "USBtin",
            Self::Canable2 { .. } => "CANable 2.0 with Nakakiyo092 firmware",
            Self::CanableStock => "CANable with the maker's slcan firmware",
            Self::Other => "unknown slcan firmware",
        }
    }

    /// What it tells of a wrong rate.
    #[must_use]
    pub const fn evidence(self) -> Evidence {
        match self {
            Self::Lawicel => Evidence::Counter,
            // Its flag tells that a counter rose, and a counter that is full rises no more.
            Self::Canable2 { .. } | Self::Usbtin | Self::CanableStock | Self::Other => {
                Evidence::FramesOnly
            }
        }
    }

    /// The bit of the answer to `F` that an error on the bus sets; `None` where `F` means
    /// something else, or nobody knows what.
    #[must_use]
    pub const fn error_flag(self) -> Option<u8> {
        match self {
            // "Bus error" there, "an error counter rose" here.
            Self::Lawicel | Self::Canable2 { .. } => Some(0x80),
            Self::Usbtin | Self::CanableStock | Self::Other => None,
        }
    }

    /// The bits of the answer to `F` that a lost frame sets.
    #[must_use]
    pub const fn lost_flags(self) -> u8 {
        match self {
            Self::Lawicel => 0x08 | 0x01,
            Self::Canable2 { .. } => 0x08 | 0x02,
            Self::Usbtin | Self::CanableStock | Self::Other => 0,
        }
    }

    /// The rates that `S` and a digit set, where that is sure.
    #[must_use]
    pub const fn digits(self) -> &'static [Digit] {
        match self {
            Self::Lawicel | Self::Usbtin | Self::Canable2 { .. } => WITH_800K,
            // 750 kbit/s on some, 800 on others.
            Self::Other | Self::CanableStock => WITHOUT_S7,
        }
    }
}

/// A digit behind `S` and its rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digit(pub u8, pub Bitrate);

const fn digit(digit: u8, bitrate: u32) -> Digit {
    Digit(digit, Bitrate::new(bitrate).unwrap())
}

const WITH_800K: &[Digit] = &[
    digit(b'0', 10_000),
    digit(b'1', 20_000),
    digit(b'2', 50_000),
    digit(b'3', 100_000),
    digit(b'4', 125_000),
    digit(b'5', 250_000),
    digit(b'6', 500_000),
    digit(b'7', 800_000),
    digit(b'8', 1_000_000),
];

const WITHOUT_S7: &[Digit] = &[
    digit(b'0', 10_000),
    digit(b'1', 20_000),
    digit(b'2', 50_000),
    digit(b'3', 100_000),
    digit(b'4', 125_000),
    digit(b'5', 250_000),
    digit(b'6', 500_000),
    digit(b'8', 1_000_000),
];

/// `clock_mhz=160` in the answer to `i`.
fn clock_of(text: &[u8]) -> Option<Hertz> {
    const KEY: &[u8] = b"clock_mhz=";
    let at = text.windows(KEY.len()).position(|part| part == KEY)?;
    let digits = text.get(at + KEY.len()..)?;
    let mut mhz = 0_u64;
    for byte in digits.iter().take(4).take_while(|byte| byte.is_ascii_digit()) {
        mhz = mhz * 10 + u64::from(byte - b'0');
    }
    Hertz::new(mhz * 1_000_000)
}
