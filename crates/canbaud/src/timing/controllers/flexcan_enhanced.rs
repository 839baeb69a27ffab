//! NXP FlexCAN with enhanced bit timing (CTRL2.BTE = 1).
//!
//! Source: NXP MCXA PERI_CAN.h; fsl_flexcan.
//!
//! Unconfirmed: the offsets 0xBF0 to 0xBFC.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 256), Span::new(2, 128), 128, Prescalers::range(1, 1024));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(2, 32), Span::new(2, 16), 16, Prescalers::range(1, 1024));

/// The register EPRS.
pub const EPRS: Register = Register::new(
    "EPRS",
    Some(0xBF0),
    32,
    &[
        Field::timing("enpresdiv", (0, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("edpresdiv", (16, 10), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The register ENCBT.
pub const ENCBT: Register = Register::new(
    "ENCBT",
    Some(0xBF4),
    32,
    &[
        Field::timing("ntseg1", (0, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ntseg2", (12, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("nrjw", (22, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register EDCBT.
pub const EDCBT: Register = Register::new(
    "EDCBT",
    Some(0xBF8),
    32,
    &[
        Field::timing("dtseg1", (0, 5), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("dtseg2", (12, 4), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("drjw", (22, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register ETDC.
pub const ETDC: Register = Register::new(
    "ETDC",
    Some(0xBFC),
    32,
    &[
        Field::other("etdcval", (0, 8), Content::Other),
        Field::other("etdcfail", (15, 1), Content::Other),
        Field::other("etdcoff", (16, 7), Content::TdcOffset(Phase::Data)),
        Field::other("tdmdis", (30, 1), Content::Other),
        Field::other("etdcen", (31, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["mcxa", "imxrt1170"],
    description: "NXP FlexCAN with enhanced bit timing (CTRL2.BTE = 1)",
    clock: "CAN protocol engine clock",
    data: Some(DATA),
    tdc_offset_max: 127,
    registers: &[EPRS, ENCBT, EDCBT, ETDC],
    source: "NXP MCXA PERI_CAN.h; fsl_flexcan",
    unconfirmed: Some("the offsets 0xBF0 to 0xBFC"),
    ..Controller::classic("flexcan_enhanced", NOMINAL)
};
