//! Renesas RS-CANFD, generation 3 (RZ/G2L, R-Car 3), FD mode.
//!
//! Source: Linux 6.12 rcar_canfd.c.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 128), Span::new(2, 32), 32, Prescalers::range(1, 1024));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(2, 16), Span::new(2, 8), 8, Prescalers::range(1, 256));

/// The register CmNCFG.
pub const NCFG: Register = Register::new(
    "CmNCFG",
    None,
    32,
    &[
        Field::timing("nbrp", (0, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("nsjw", (11, 5), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("ntseg1", (16, 7), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ntseg2", (24, 5), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The register CmDCFG.
pub const DCFG: Register = Register::new(
    "CmDCFG",
    Some(0x500),
    32,
    &[
        Field::timing("dbrp", (0, 8), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
        Field::timing("dtseg1", (16, 4), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("dtseg2", (20, 3), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("dsjw", (24, 3), (Phase::Data, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register CmFDCFG.
pub const FDCFG: Register = Register::new(
    "CmFDCFG",
    Some(0x504),
    32,
    &[
        Field::other("tdcoc", (8, 1), Content::Other),
        Field::other("tdce", (9, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
        Field::other("tdco", (16, 7), Content::TdcOffset(Phase::Data)),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["rcar_canfd", "rzg2l"],
    description: "Renesas RS-CANFD, generation 3 (RZ/G2L, R-Car 3), FD mode",
    clock: "DLL clock",
    data: Some(DATA),
    tdc_offset_max: 127,
    registers: &[NCFG, DCFG, FDCFG],
    source: "Linux 6.12 rcar_canfd.c",
    ..Controller::classic("rscanfd_gen3", NOMINAL)
};
