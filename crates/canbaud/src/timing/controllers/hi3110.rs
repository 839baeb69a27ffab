//! Holt HI-3110.
//!
//! Written by the SPI commands 0x18 and 0x1A.
//!
//! Source: Linux 6.12 hi311x.c.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 16), Span::new(2, 8), 4, Prescalers::range(1, 64));

/// The register BTR0.
pub const BTR0: Register = Register::new(
    "BTR0",
    None,
    8,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BTR1.
pub const BTR1: Register = Register::new(
    "BTR1",
    None,
    8,
    &[
        Field::timing("tseg1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("sam", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["hi311x"],
    description: "Holt HI-3110",
    clock: "oscillator",
    registers: &[BTR0, BTR1],
    source: "Linux 6.12 hi311x.c",
    ..Controller::classic("hi3110", NOMINAL)
};
