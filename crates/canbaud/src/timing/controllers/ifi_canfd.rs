//! IFI CAN FD.
//!
//! The Linux driver leaves SYNC_SEG out of the TDC offset.
//!
//! Source: Linux 6.12 ifi_canfd.c.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 256), Span::new(2, 256), 128, Prescalers::range(2, 512));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 256), Span::new(2, 256), 128, Prescalers::range(2, 512));

/// The register TIME.
pub const TIME: Register = Register::new(
    "TIME",
    Some(0x14),
    32,
    &[
        Field::timing("timeb", (0, 8), (Phase::Nominal, Part::Tseg2), Encoding::MinusTwo),
        Field::timing("timea", (8, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("prescale", (16, 9), (Phase::Nominal, Part::Prescaler), Encoding::MinusTwo),
        Field::timing("sjw", (25, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register FTIME.
pub const FTIME: Register = Register::new(
    "FTIME",
    Some(0x18),
    32,
    &[
        Field::timing("timeb", (0, 8), (Phase::Data, Part::Tseg2), Encoding::MinusTwo),
        Field::timing("timea", (8, 8), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("prescale", (16, 9), (Phase::Data, Part::Prescaler), Encoding::MinusTwo),
        Field::timing("sjw", (25, 7), (Phase::Data, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register TDELAY.
pub const TDELAY: Register = Register::new(
    "TDELAY",
    Some(0x1C),
    32,
    &[
        Field::other("tdc", (0, 14), Content::TdcOffset(Phase::Data)),
        Field::other("abs", (14, 1), Content::Other),
        Field::other("en", (15, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    description: "IFI CAN FD",
    clock: "core clock",
    data: Some(DATA),
    tdc_offset_max: 16383,
    registers: &[TIME, FTIME, TDELAY],
    source: "Linux 6.12 ifi_canfd.c",
    ..Controller::classic("ifi_canfd", NOMINAL)
};
