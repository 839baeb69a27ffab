//! Atmel AT90CAN32/64/128, ATmega16M1/32M1/64M1.
//!
//! Source: avr-libc iocanxx.h; ATmega32M1 data sheet page 255.
//!
//! Unconfirmed: the minimum of 2 for PHASE_SEG2.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 16), Span::new(2, 8), 4, Prescalers::range(1, 64))
        .with_segments(Span::new(1, 8), Span::new(1, 8));

/// The register CANBT1.
pub const CANBT1: Register = Register::new(
    "CANBT1",
    Some(0xE2),
    8,
    &[Field::timing("brp", (1, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)],
);

/// The register CANBT2.
pub const CANBT2: Register = Register::new(
    "CANBT2",
    Some(0xE3),
    8,
    &[
        Field::timing("prs", (1, 3), (Phase::Nominal, Part::PropSeg), Encoding::MinusOne),
        Field::timing("sjw", (5, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register CANBT3.
pub const CANBT3: Register = Register::new(
    "CANBT3",
    Some(0xE4),
    8,
    &[
        Field::other("smp", (0, 1), Content::Other),
        Field::timing("phs1", (1, 3), (Phase::Nominal, Part::PhaseSeg1), Encoding::MinusOne),
        Field::timing("phs2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["atmega32m1", "at90can128"],
    description: "Atmel AT90CAN32/64/128, ATmega16M1/32M1/64M1",
    clock: "clkIO",
    registers: &[CANBT1, CANBT2, CANBT3],
    source: "avr-libc iocanxx.h; ATmega32M1 data sheet page 255",
    unconfirmed: Some("the minimum of 2 for PHASE_SEG2"),
    ..Controller::classic("at90can", NOMINAL)
};
