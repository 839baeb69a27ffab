//! NXP SJA1000 and 82C200.
//!
//! Source: Linux 6.12 drivers/net/can/sja1000; can-utils; Beckhoff EL6751 CANopen table.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 64))
        .with_clock_divider(2);

/// The register BTR0.
pub const BTR0: Register = Register::new(
    "BTR0",
    Some(0x06),
    8,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BTR1.
pub const BTR1: Register = Register::new(
    "BTR1",
    Some(0x07),
    8,
    &[
        Field::timing("tseg1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("sam", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["82c200"],
    description: "NXP SJA1000 and 82C200",
    clock: "crystal (f_XTAL, divided by 2)",
    registers: &[BTR0, BTR1],
    source: "Linux 6.12 drivers/net/can/sja1000; can-utils; Beckhoff EL6751 CANopen table",
    ..Controller::classic("sja1000", NOMINAL)
};
