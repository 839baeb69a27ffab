//! TI HECC and eCAN.
//!
//! Source: Linux 6.12 ti_hecc.c.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 256));

/// The register CANBTC.
pub const CANBTC: Register = Register::new(
    "CANBTC",
    Some(0x2C),
    32,
    &[
        Field::timing("tseg2", (0, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("tseg1", (3, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::other("sam", (7, 1), Content::Other),
        Field::timing("sjw", (8, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("brp", (16, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["hecc", "ecan_ti"],
    description: "TI HECC and eCAN",
    clock: "module clock",
    registers: &[CANBTC],
    source: "Linux 6.12 ti_hecc.c",
    ..Controller::classic("ti_hecc", NOMINAL)
};
