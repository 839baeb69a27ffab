//! Renesas RS-CANFD, generation 4 (R-Car 4).
//!
//! Source: Linux 6.12 rcar_canfd.c (masks).
//!
//! Unconfirmed: the ranges are those of the field widths (the Linux 6.12 driver still has the generation 3 ranges); the TDC register is not known.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 256), Span::new(2, 128), 128, Prescalers::range(1, 1024));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(2, 32), Span::new(2, 16), 16, Prescalers::range(1, 256));

/// The register CmNCFG.
pub const NCFG: Register = Register::new(
    "CmNCFG",
    None,
    32,
    &[
        Field::timing("nbrp", (0, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("nsjw", (10, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("ntseg1", (17, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ntseg2", (25, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The register CmDCFG.
pub const DCFG: Register = Register::new(
    "CmDCFG",
    Some(0x1400),
    32,
    &[
        Field::timing("dbrp", (0, 8), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
        Field::timing("dtseg1", (8, 5), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("dtseg2", (16, 4), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("dsjw", (24, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["rcar4_canfd"],
    description: "Renesas RS-CANFD, generation 4 (R-Car 4)",
    clock: "DLL clock",
    data: Some(DATA),
    registers: &[NCFG, DCFG],
    source: "Linux 6.12 rcar_canfd.c (masks)",
    unconfirmed: Some(
        "the ranges are those of the field widths (the Linux 6.12 driver still has the generation 3 ranges); the TDC register is not known",
    ),
    ..Controller::classic("rscanfd_gen4", NOMINAL)
};
