//! Renesas R-Car CAN, RX and RA CAN: BCR.
//!
//! Source: Linux 6.12 rcar_can.c; RA6M3 device description.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(4, 16), Span::new(2, 8), 4, Prescalers::range(1, 1024));

/// The register BCR.
pub const BCR: Register = Register::new(
    "BCR",
    None,
    32,
    &[
        Field::other("cclks", (0, 1), Content::Other),
        Field::timing("tseg2", (8, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("sjw", (12, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("brp", (16, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("tseg1", (28, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["rcar_can", "ra6m3"],
    description: "Renesas R-Car CAN, RX and RA CAN: BCR",
    clock: "PCLK or CANMCLK (bit CCLKS)",
    registers: &[BCR],
    source: "Linux 6.12 rcar_can.c; RA6M3 device description",
    ..Controller::classic("rcan", NOMINAL)
};
