//! Renesas RS-CANFD, generation 3, classic mode.
//!
//! Source: Linux 6.12 rcar_canfd.c.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(4, 16), Span::new(2, 8), 4, Prescalers::range(1, 1024));

/// The register CmCFG.
pub const CFG: Register = Register::new(
    "CmCFG",
    None,
    32,
    &[
        Field::timing("brp", (0, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("tseg1", (16, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (20, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("sjw", (24, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    description: "Renesas RS-CANFD, generation 3, classic mode",
    clock: "DLL clock",
    registers: &[CFG],
    source: "Linux 6.12 rcar_canfd.c",
    ..Controller::classic("rscanfd_gen3_classic", NOMINAL)
};
