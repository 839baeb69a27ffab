//! Atmel AT91 and SAMA5D3 CAN.
//!
//! Source: Linux 6.12 at91_can.c.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(4, 16), Span::new(2, 8), 4, Prescalers::range(2, 128))
        .with_segments(Span::new(1, 8), Span::new(1, 8));

/// The register CAN_BR.
pub const CAN_BR: Register = Register::new(
    "CAN_BR",
    Some(0x14),
    32,
    &[
        Field::timing("phase2", (0, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("phase1", (4, 3), (Phase::Nominal, Part::PhaseSeg1), Encoding::MinusOne),
        Field::timing("propag", (8, 3), (Phase::Nominal, Part::PropSeg), Encoding::MinusOne),
        Field::timing("sjw", (12, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("brp", (16, 7), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::other("smp", (24, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["sama5", "at91sam9263"],
    description: "Atmel AT91 and SAMA5D3 CAN",
    clock: "MCK",
    registers: &[CAN_BR],
    source: "Linux 6.12 at91_can.c",
    ..Controller::classic("at91", NOMINAL)
};
