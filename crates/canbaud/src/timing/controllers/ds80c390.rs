//! Dallas DS80C390: C0BT0, C0BT1 and the prescaler bits in COR.
//!
//! CCD, the CAN clock divide that follows the clock mode in PMR, is the fixed divider:
//! [`Controller::with_clock_divider`](super::Controller::with_clock_divider)`(ccd)`.
//! Triple sampling (SMP = 1) is allowed only above BRPV 3; the bus timing loads when SWINT goes from 1 to 0.
//! The words are for CAN 0; CAN 1 has its prescaler bits in `c1_brp_hi`. The other bits of COR must be kept.
//!
//! Source: DS80C390 supplement pages 152 and 155; SDCC mcs51reg.h.
//!
//! Unconfirmed: the table of CCD against clock mode (guide pages 153 and 154) and the MOVX addresses.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 16), Span::new(2, 8), 4, Prescalers::range(1, 256))
        .with_clock_divider(2)
        .with_tseg1_excess(0);

/// The register C0BT0.
pub const C0BT0: Register = Register::new(
    "C0BT0",
    None,
    8,
    &[
        Field::timing("brp_lo", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)
            .part_of(8, 0),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register C0BT1.
pub const C0BT1: Register = Register::new(
    "C0BT1",
    None,
    8,
    &[
        Field::timing("tseg1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("smp", (7, 1), Content::Other),
    ],
);

/// The register COR.
pub const COR: Register = Register::new(
    "COR",
    Some(0xCE),
    8,
    &[
        Field::other("clkoe", (0, 1), Content::Other),
        Field::other("cod", (1, 2), Content::Other),
        Field::timing("c0_brp_hi", (3, 2), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)
            .part_of(8, 6),
        Field::other("c1_brp_hi", (5, 2), Content::Other),
        Field::other("irdack", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["ds80c400"],
    description: "Dallas DS80C390: C0BT0, C0BT1 and the prescaler bits in COR",
    clock: "F_OSC (divided by CCD, 2 unless told otherwise)",
    registers: &[C0BT0, C0BT1, COR],
    source: "DS80C390 supplement pages 152 and 155; SDCC mcs51reg.h",
    unconfirmed: Some(
        "the table of CCD against clock mode (guide pages 153 and 154) and the MOVX addresses",
    ),
    ..Controller::classic("ds80c390", NOMINAL)
};
