//! Xilinx and AMD CAN FD 2.0 (Versal).
//!
//! can-utils has 2 as the lowest prescaler, Linux 6.12 has 1.
//!
//! Source: Linux 6.12 xilinx_can.c; AM012.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 256), Span::new(1, 128), 128, Prescalers::range(1, 256));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 32), Span::new(1, 16), 16, Prescalers::range(1, 256));

/// The register BRPR.
pub const BRPR: Register = Register::new(
    "BRPR",
    Some(0x08),
    32,
    &[Field::timing("brp", (0, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)],
);

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x0C),
    32,
    &[
        Field::timing("ts1", (0, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ts2", (8, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("sjw", (16, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register F_BRPR.
pub const F_BRPR: Register = Register::new(
    "F_BRPR",
    Some(0x88),
    32,
    &[
        Field::timing("brp", (0, 8), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
        Field::other("tdco", (8, 6), Content::TdcOffset(Phase::Data)),
        Field::other("tdce", (16, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
    ],
);

/// The register F_BTR.
pub const F_BTR: Register = Register::new(
    "F_BTR",
    Some(0x8C),
    32,
    &[
        Field::timing("ts1", (0, 5), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ts2", (8, 4), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("sjw", (16, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["xilinx_can_fd2", "versal"],
    description: "Xilinx and AMD CAN FD 2.0 (Versal)",
    clock: "CAN clock",
    data: Some(DATA),
    tdc_offset_max: 63,
    registers: &[BRPR, BTR, F_BRPR, F_BTR],
    source: "Linux 6.12 xilinx_can.c; AM012",
    ..Controller::classic("xcanfd2", NOMINAL)
};
