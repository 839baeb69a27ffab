//! Intel AN82527 and Bosch CC770.
//!
//! Source: Linux 6.12 drivers/net/can/cc770 (offsets counted from its structure).

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 64));

/// The register BTR0.
pub const BTR0: Register = Register::new(
    "BTR0",
    Some(0x3F),
    8,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BTR1.
pub const BTR1: Register = Register::new(
    "BTR1",
    Some(0x4F),
    8,
    &[
        Field::timing("tseg1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("sam", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["cc770", "82527"],
    description: "Intel AN82527 and Bosch CC770",
    clock: "SCLK (the crystal, or half of it: CPU interface register DSC)",
    registers: &[BTR0, BTR1],
    source: "Linux 6.12 drivers/net/can/cc770 (offsets counted from its structure)",
    ..Controller::classic("an82527", NOMINAL)
};
