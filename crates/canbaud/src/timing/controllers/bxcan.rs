//! ST bxCAN (STM32 F0 to F4, F7, L4).
//!
//! Source: Linux 6.12 drivers/net/can/bxcan.c; RM0432.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 1024));

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x1C),
    32,
    &[
        Field::timing("brp", (0, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("ts1", (16, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ts2", (20, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("sjw", (24, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::other("lbkm", (30, 1), Content::Other),
        Field::other("silm", (31, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["stm32f4", "stm32f1", "stm32f0", "stm32l4"],
    description: "ST bxCAN (STM32 F0 to F4, F7, L4)",
    clock: "APB clock (PCLK)",
    registers: &[BTR],
    source: "Linux 6.12 drivers/net/can/bxcan.c; RM0432",
    ..Controller::classic("bxcan", NOMINAL)
};
