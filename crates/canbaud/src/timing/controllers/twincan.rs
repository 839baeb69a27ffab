//! Infineon TwinCAN (XC16x, C161CS, XC164): ABTRL, BBTRL.
//!
//! Source: XC161 user manual (TSEG1 >= 3, TSEG2 >= 2, at least 8 TQ, DIV8X).

use super::register::{Encoding, Field, Part, Register, Scale};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(3, 16), Span::new(2, 8), 4, Prescalers::range(1, 64).and(8, 512, 8))
        .with_bit_quanta(Span::new(8, 25));

/// The register ABTRL.
pub const ABTRL: Register = Register::new(
    "ABTRL",
    Some(0x20_020C),
    16,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (8, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (12, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("div8x", (15, 1), (Phase::Nominal, Part::PrescalerScale), Encoding::Raw),
    ],
)
.with_scale(Scale { factors: &[1, 8], base_max: 64 });

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["xc161", "xc164", "c161cs"],
    description: "Infineon TwinCAN (XC16x, C161CS, XC164): ABTRL, BBTRL",
    clock: "f_CAN (a further 8 when DIV8X is set)",
    registers: &[ABTRL],
    source: "XC161 user manual (TSEG1 >= 3, TSEG2 >= 2, at least 8 TQ, DIV8X)",
    ..Controller::classic("twincan", NOMINAL)
};
