//! Freescale MSCAN.
//!
//! Source: Linux 6.12 drivers/net/can/mscan; MC9S12C data sheet.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(4, 16), Span::new(2, 8), 4, Prescalers::range(1, 64));

/// The register CANBTR0.
pub const CANBTR0: Register = Register::new(
    "CANBTR0",
    Some(0x02),
    8,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register CANBTR1.
pub const CANBTR1: Register = Register::new(
    "CANBTR1",
    Some(0x03),
    8,
    &[
        Field::timing("tseg1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("sam", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["mpc5xxx", "s12"],
    description: "Freescale MSCAN",
    clock: "bus or oscillator clock",
    registers: &[CANBTR0, CANBTR1],
    source: "Linux 6.12 drivers/net/can/mscan; MC9S12C data sheet",
    ..Controller::classic("mscan", NOMINAL)
};
