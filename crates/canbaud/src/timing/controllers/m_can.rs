//! Bosch M_CAN from 3.1: STM32 FDCAN, TI MCAN and TCAN4550, SAM MCAN, Infineon MCMCAN.
//!
//! Source: Linux 6.12 drivers/net/can/m_can; SAM C21/E5x and TCAN4550 data sheets.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 256), Span::new(2, 128), 128, Prescalers::range(1, 512))
        .with_bit_quanta(Span::new(4, 385));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 32), Span::new(1, 16), 16, Prescalers::range(1, 32))
        .with_bit_quanta(Span::new(4, 49));

/// The register NBTP.
pub const NBTP: Register = Register::new(
    "NBTP",
    Some(0x1C),
    32,
    &[
        Field::timing("ntseg2", (0, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("ntseg1", (8, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("nbrp", (16, 9), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("nsjw", (25, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register DBTP.
pub const DBTP: Register = Register::new(
    "DBTP",
    Some(0x0C),
    32,
    &[
        Field::timing("dsjw", (0, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::timing("dtseg2", (4, 4), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("dtseg1", (8, 5), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("dbrp", (16, 5), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
        Field::other("tdc", (23, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
    ],
);

/// The register TDCR.
pub const TDCR: Register = Register::new(
    "TDCR",
    Some(0x48),
    32,
    &[
        Field::other("tdcf", (0, 7), Content::Other),
        Field::other("tdco", (8, 7), Content::TdcOffset(Phase::Data)),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["mcan", "fdcan", "tcan4550", "mcmcan", "tcan4x5x"],
    description: "Bosch M_CAN from 3.1: STM32 FDCAN, TI MCAN and TCAN4550, SAM MCAN, Infineon MCMCAN",
    clock: "CAN kernel clock",
    data: Some(DATA),
    tdc_offset_max: 127,
    registers: &[NBTP, DBTP, TDCR],
    source: "Linux 6.12 drivers/net/can/m_can; SAM C21/E5x and TCAN4550 data sheets",
    ..Controller::classic("m_can", NOMINAL)
};
