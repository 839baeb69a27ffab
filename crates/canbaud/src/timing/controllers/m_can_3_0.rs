//! Bosch M_CAN 3.0 (SAM V71 revision A, SAMA5D2): BTP and FBTP.
//!
//! Source: Linux 6.12 m_can.c (ranges); Microchip SAM V71 device header (layout).
//!
//! Unconfirmed: the minus-one encoding of BTP and FBTP is that of the later M_CAN.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 64), Span::new(1, 16), 16, Prescalers::range(1, 1024));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(2, 16), Span::new(1, 8), 4, Prescalers::range(1, 32));

/// The register BTP.
pub const BTP: Register = Register::new(
    "BTP",
    Some(0x1C),
    32,
    &[
        Field::timing("sjw", (0, 4), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg2", (4, 4), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("tseg1", (8, 6), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("brp", (16, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The register FBTP.
pub const FBTP: Register = Register::new(
    "FBTP",
    Some(0x0C),
    32,
    &[
        Field::timing("fsjw", (0, 2), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::timing("ftseg2", (4, 3), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("ftseg1", (8, 4), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("fbrp", (16, 5), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
        Field::other("tdc", (23, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
        Field::other("tdco", (24, 5), Content::TdcOffset(Phase::Data)),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["samv71a"],
    description: "Bosch M_CAN 3.0 (SAM V71 revision A, SAMA5D2): BTP and FBTP",
    clock: "CAN kernel clock",
    data: Some(DATA),
    tdc_offset_max: 31,
    registers: &[BTP, FBTP],
    source: "Linux 6.12 m_can.c (ranges); Microchip SAM V71 device header (layout)",
    unconfirmed: Some("the minus-one encoding of BTP and FBTP is that of the later M_CAN"),
    ..Controller::classic("m_can_3.0", NOMINAL)
};
