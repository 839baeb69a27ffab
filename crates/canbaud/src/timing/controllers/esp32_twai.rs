//! Espressif TWAI of the ESP32.
//!
//! Source: ESP-IDF twai_ll.h; esp-hal.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::multiples(2, 128, 2));

/// The register BUS_TIMING_0.
pub const BUS_TIMING_0: Register = Register::new(
    "BUS_TIMING_0",
    Some(0x18),
    32,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::HalfMinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register BUS_TIMING_1.
pub const BUS_TIMING_1: Register = Register::new(
    "BUS_TIMING_1",
    Some(0x1C),
    32,
    &[
        Field::timing("tseg1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("sam", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["twai", "esp32"],
    description: "Espressif TWAI of the ESP32",
    clock: "APB clock (80 MHz)",
    registers: &[BUS_TIMING_0, BUS_TIMING_1],
    source: "ESP-IDF twai_ll.h; esp-hal",
    ..Controller::classic("esp32_twai", NOMINAL)
};
