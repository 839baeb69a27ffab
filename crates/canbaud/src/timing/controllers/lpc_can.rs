//! NXP LPC17xx, LPC21xx, LPC23xx, LPC40xx; Allwinner sun4i.
//!
//! The sun4i driver of Linux holds the prescaler to 64 although it masks 10 bits.
//!
//! Source: Linux 6.12 sun4i_can.c; LPC21xx code.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 1024));

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x14),
    32,
    &[
        Field::timing("brp", (0, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (14, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (16, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (20, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("sam", (23, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["lpc17xx", "sun4i", "lpc21xx"],
    description: "NXP LPC17xx, LPC21xx, LPC23xx, LPC40xx; Allwinner sun4i",
    clock: "PCLK",
    registers: &[BTR],
    source: "Linux 6.12 sun4i_can.c; LPC21xx code",
    ..Controller::classic("lpc_can", NOMINAL)
};
