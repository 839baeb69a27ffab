//! NXP S32Z2 CANXL_SIC.
//!
//! Source: Zephyr hal_nxp S32Z2_CANXL_SIC.h (field positions).
//!
//! Unconfirmed: every encoding: minus one is inferred from ENCBT, PWM from X_CAN.

use super::register::{Content, Encoding, Field, Part, PwmPart, Register};
use super::{Controller, Phase, PrescalerSharing};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 512), Span::new(1, 128), 128, Prescalers::range(1, 256));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 256), Span::new(1, 128), 128, Prescalers::range(1, 256));

/// Limits of the CAN XL data phase.
pub const XL: Limits =
    Limits::new(Span::new(1, 256), Span::new(1, 128), 128, Prescalers::range(1, 256));

/// The register BBPRS.
pub const BBPRS: Register = Register::new(
    "BBPRS",
    Some(0x8C),
    32,
    &[Field::timing("presdiv", (0, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)],
);

/// The register BNCBT.
pub const BNCBT: Register = Register::new(
    "BNCBT",
    Some(0x90),
    32,
    &[
        Field::timing("ntseg1", (0, 9), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ntseg2", (12, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("nrjw", (22, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BFDCBT.
pub const BFDCBT: Register = Register::new(
    "BFDCBT",
    Some(0x94),
    32,
    &[
        Field::timing("dtseg1", (0, 8), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("dtseg2", (12, 7), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("drjw", (22, 7), (Phase::Data, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BXDCBT.
pub const BXDCBT: Register = Register::new(
    "BXDCBT",
    Some(0x98),
    32,
    &[
        Field::timing("xtseg1", (0, 8), (Phase::Xl, Part::Tseg1), Encoding::MinusOne),
        Field::timing("xtseg2", (12, 7), (Phase::Xl, Part::Tseg2), Encoding::MinusOne),
        Field::timing("xrjw", (22, 7), (Phase::Xl, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BTDCC.
pub const BTDCC: Register = Register::new(
    "BTDCC",
    Some(0x9C),
    32,
    &[
        Field::other("ftdcoff", (0, 7), Content::TdcOffset(Phase::Data)),
        Field::other("ftdmdis", (14, 1), Content::Other),
        Field::other("ftdcen", (15, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
        Field::other("xtdcoff", (16, 8), Content::TdcOffset(Phase::Xl)),
        Field::other("xtdmdis", (30, 1), Content::Other),
        Field::other("xtdcen", (31, 1), Content::TdcMode { phase: Phase::Xl, on: 1, off: 0 }),
    ],
);

/// The register BMICI.
pub const BMICI: Register = Register::new(
    "BMICI",
    Some(0xA0),
    32,
    &[
        Field::other("pwmo", (0, 6), Content::Pwm(PwmPart::Offset)).encoded(Encoding::Raw),
        Field::other("pwml", (8, 6), Content::Pwm(PwmPart::Long)).encoded(Encoding::MinusOne),
        Field::other("pwms", (16, 6), Content::Pwm(PwmPart::Short)).encoded(Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["s32z2"],
    description: "NXP S32Z2 CANXL_SIC",
    clock: "CAN protocol engine clock",
    data: Some(DATA),
    xl: Some(XL),
    prescalers: PrescalerSharing::Shared,
    tdc_offset_max: 127,
    registers: &[BBPRS, BNCBT, BFDCBT, BXDCBT, BTDCC, BMICI],
    source: "Zephyr hal_nxp S32Z2_CANXL_SIC.h (field positions)",
    unconfirmed: Some("every encoding: minus one is inferred from ENCBT, PWM from X_CAN"),
    ..Controller::classic("nxp_canxl", NOMINAL)
};
