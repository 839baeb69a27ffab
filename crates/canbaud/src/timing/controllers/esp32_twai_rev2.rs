//! Espressif TWAI of the ESP32 from chip revision 2, with BRP_DIV.
//!
//! BRP_DIV is bit 4 of the interrupt enable register: the other bits of that register must be kept.
//!
//! Source: ESP-IDF twai_ll.h; esp-idf issues on BRP_DIV.

use super::register::{Content, Encoding, Field, Part, Register, Scale};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits = Limits::new(
    Span::new(1, 16),
    Span::new(1, 8),
    4,
    Prescalers::multiples(2, 128, 2).and(132, 256, 4),
);

/// The register BUS_TIMING_0.
pub const BUS_TIMING_0: Register = Register::new(
    "BUS_TIMING_0",
    Some(0x18),
    32,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::HalfMinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
)
.with_scale(Scale { factors: &[1, 2], base_max: 128 });

pub use super::esp32_twai::BUS_TIMING_1;

/// The register INT_ENA.
pub const INT_ENA: Register = Register::new(
    "INT_ENA",
    None,
    32,
    &[
        Field::other("interrupts_low", (0, 4), Content::Other),
        Field::timing("brp_div", (4, 1), (Phase::Nominal, Part::PrescalerScale), Encoding::Raw),
        Field::other("interrupts_high", (5, 3), Content::Other),
    ],
)
.with_scale(Scale { factors: &[1, 2], base_max: 128 });

/// The controller.
pub const CONTROLLER: Controller = Controller {
    description: "Espressif TWAI of the ESP32 from chip revision 2, with BRP_DIV",
    clock: "APB clock (80 MHz)",
    registers: &[BUS_TIMING_0, BUS_TIMING_1, INT_ENA],
    source: "ESP-IDF twai_ll.h; esp-idf issues on BRP_DIV",
    ..Controller::classic("esp32_twai_rev2", NOMINAL)
};
