//! Bosch X_CAN protocol unit (CAN XL).
//!
//! Of MODE only the bits that follow from the phases are known here; the others must be kept.
//!
//! Source: public X_CAN register decoder.

use super::register::{Content, Encoding, Field, Part, PwmPart, Register};
use super::{Controller, Phase, PrescalerSharing};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 512), Span::new(2, 128), 128, Prescalers::range(1, 32));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 256), Span::new(2, 128), 128, Prescalers::range(1, 32));

/// Limits of the CAN XL data phase.
pub const XL: Limits =
    Limits::new(Span::new(1, 256), Span::new(2, 128), 128, Prescalers::range(1, 32));

/// The register MODE.
pub const MODE: Register = Register::new(
    "MODE",
    Some(0x60),
    32,
    &[
        Field::other("fdoe", (0, 1), Content::Enable(Phase::Data)),
        Field::other("xloe", (1, 1), Content::Enable(Phase::Xl)),
        Field::other("tdce", (2, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
        Field::other("xltr", (9, 1), Content::Other),
        Field::other("efdi", (10, 1), Content::Other),
    ],
);

/// The register NBTP.
pub const NBTP: Register = Register::new(
    "NBTP",
    Some(0x64),
    32,
    &[
        Field::timing("nsjw", (0, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("ntseg2", (8, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("ntseg1", (16, 9), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("brp", (25, 5), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The register DBTP.
pub const DBTP: Register = Register::new(
    "DBTP",
    Some(0x68),
    32,
    &[
        Field::timing("dsjw", (0, 7), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::timing("dtseg2", (8, 7), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("dtseg1", (16, 8), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::other("dtdco", (24, 8), Content::TdcOffset(Phase::Data)),
    ],
);

/// The register XBTP.
pub const XBTP: Register = Register::new(
    "XBTP",
    Some(0x6C),
    32,
    &[
        Field::timing("xsjw", (0, 7), (Phase::Xl, Part::Sjw), Encoding::MinusOne),
        Field::timing("xtseg2", (8, 7), (Phase::Xl, Part::Tseg2), Encoding::MinusOne),
        Field::timing("xtseg1", (16, 8), (Phase::Xl, Part::Tseg1), Encoding::MinusOne),
        Field::other("xtdco", (24, 8), Content::TdcOffset(Phase::Xl)),
    ],
);

/// The register PCFG.
pub const PCFG: Register = Register::new(
    "PCFG",
    Some(0x70),
    32,
    &[
        Field::other("pwms", (0, 6), Content::Pwm(PwmPart::Short)).encoded(Encoding::MinusOne),
        Field::other("pwml", (8, 6), Content::Pwm(PwmPart::Long)).encoded(Encoding::MinusOne),
        Field::other("pwmo", (16, 6), Content::Pwm(PwmPart::Offset)).encoded(Encoding::Raw),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["x_can"],
    description: "Bosch X_CAN protocol unit (CAN XL)",
    clock: "CAN clock (80 or 160 MHz for CAN XL)",
    data: Some(DATA),
    xl: Some(XL),
    prescalers: PrescalerSharing::Shared,
    tdc_offset_max: 255,
    registers: &[MODE, NBTP, DBTP, XBTP, PCFG],
    source: "public X_CAN register decoder",
    ..Controller::classic("x_can_prt", NOMINAL)
};
