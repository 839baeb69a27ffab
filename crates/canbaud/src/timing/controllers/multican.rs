//! Infineon MultiCAN (XC2000, XE166, TC17xx, XMC1, XMC4).
//!
//! Source: XMC device headers; XMCLib (TSEG1 >= 3, TSEG2 >= 2, at least 8 TQ).

use super::register::{Encoding, Field, Part, Register, Scale};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(3, 16), Span::new(2, 8), 4, Prescalers::range(1, 64).and(8, 512, 8))
        .with_bit_quanta(Span::new(8, 25));

/// The register NBTR.
pub const NBTR: Register = Register::new(
    "NBTR",
    None,
    32,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (8, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (12, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("div8", (15, 1), (Phase::Nominal, Part::PrescalerScale), Encoding::Raw),
    ],
)
.with_scale(Scale { factors: &[1, 8], base_max: 64 });

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["xmc4", "xmc1", "xc2000", "xe166"],
    description: "Infineon MultiCAN (XC2000, XE166, TC17xx, XMC1, XMC4)",
    clock: "f_CAN (a further 8 when DIV8 is set)",
    registers: &[NBTR],
    source: "XMC device headers; XMCLib (TSEG1 >= 3, TSEG2 >= 2, at least 8 TQ)",
    ..Controller::classic("multican", NOMINAL)
};
