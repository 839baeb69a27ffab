//! Espressif TWAI of ESP32-S2, S3, C3, C6 and H2.
//!
//! Source: ESP-IDF twai_ll.h; esp-hal.
//!
//! Unconfirmed: the position of SJW (bits 15:14).

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::multiples(2, 32_768, 2));

/// The register BUS_TIMING_0.
pub const BUS_TIMING_0: Register = Register::new(
    "BUS_TIMING_0",
    Some(0x18),
    32,
    &[
        Field::timing("brp", (0, 14), (Phase::Nominal, Part::Prescaler), Encoding::HalfMinusOne),
        Field::timing("sjw", (14, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

pub use super::esp32_twai::BUS_TIMING_1;

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["esp32s2", "esp32s3", "esp32c3", "esp32c6", "esp32h2"],
    description: "Espressif TWAI of ESP32-S2, S3, C3, C6 and H2",
    clock: "APB clock (80 MHz; C6: 40 MHz, H2: 32 MHz crystal)",
    registers: &[BUS_TIMING_0, BUS_TIMING_1],
    source: "ESP-IDF twai_ll.h; esp-hal",
    unconfirmed: Some("the position of SJW (bits 15:14)"),
    ..Controller::classic("esp32s3_twai", NOMINAL)
};
