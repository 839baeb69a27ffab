//! Renesas M16C and M32C 16-slot CAN.
//!
//! PBS1 >= PBS2 >= SJW must hold.
//!
//! Source: M30956 data sheet pages 299 and 300.
//!
//! Unconfirmed: only the prescaler register is known: the segments go into CiCONR, whose layout is not.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(3, 16), Span::new(2, 8), 4, Prescalers::range(2, 256))
        .with_segments(Span::new(1, 8), Span::new(2, 8))
        .with_bit_quanta(Span::new(8, 25))
        .with_tseg1_excess(1);

/// The register CiBRP.
pub const CIBRP: Register = Register::new(
    "CiBRP",
    Some(0x217),
    8,
    &[Field::timing("brp", (0, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["m32c"],
    description: "Renesas M16C and M32C 16-slot CAN",
    clock: "f_CAN",
    registers: &[CIBRP],
    source: "M30956 data sheet pages 299 and 300",
    unconfirmed: Some(
        "only the prescaler register is known: the segments go into CiCONR, whose layout is not",
    ),
    ..Controller::classic("m16c_can", NOMINAL)
};
