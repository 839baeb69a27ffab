//! Infineon C167, C164 and ST10; C505CA and C515C hold the same two bytes.
//!
//! CPS = 1 takes f_CPU itself: [`Controller::with_clock_divider`](super::Controller::with_clock_divider)`(1)`.
//!
//! Source: AP2925 1.2.3; Beckhoff EL6751.
//!
//! Unconfirmed: the minima TSEG1 >= 3 and TSEG2 >= 2 and the offset of BTR.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(3, 16), Span::new(2, 8), 4, Prescalers::range(1, 64))
        .with_clock_divider(2);

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x04),
    16,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (8, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (12, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["c164", "st10", "c505ca", "c515c", "c166"],
    description: "Infineon C167, C164 and ST10; C505CA and C515C hold the same two bytes",
    clock: "f_CPU (divided by 2 while CPS = 0)",
    registers: &[BTR],
    source: "AP2925 1.2.3; Beckhoff EL6751",
    unconfirmed: Some("the minima TSEG1 >= 3 and TSEG2 >= 2 and the offset of BTR"),
    ..Controller::classic("c167", NOMINAL)
};
