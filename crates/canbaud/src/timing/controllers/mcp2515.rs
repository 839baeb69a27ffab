//! Microchip MCP2510, MCP2515, MCP25625; PIC18 ECAN BRGCON1 to 3.
//!
//! BTLMODE is always 1: PHASE_SEG2 comes from CNF3, not from PHASE_SEG1.
//!
//! Source: Linux 6.12 drivers/net/can/spi/mcp251x.c; can-utils.
//!
//! Unconfirmed: the rules PROP_SEG + PHASE_SEG1 >= PHASE_SEG2 and PHASE_SEG2 > SJW.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(3, 16), Span::new(2, 8), 4, Prescalers::range(1, 64))
        .with_segments(Span::new(1, 8), Span::new(1, 8))
        .with_clock_divider(2)
        .with_tseg1_excess(0)
        .with_sjw_gap(1);

/// The register CNF1.
pub const CNF1: Register = Register::new(
    "CNF1",
    Some(0x2A),
    8,
    &[
        Field::timing("brp", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The register CNF2.
pub const CNF2: Register = Register::new(
    "CNF2",
    Some(0x29),
    8,
    &[
        Field::timing("prseg", (0, 3), (Phase::Nominal, Part::PropSeg), Encoding::MinusOne),
        Field::timing("phseg1", (3, 3), (Phase::Nominal, Part::PhaseSeg1), Encoding::MinusOne),
        Field::other("sam", (6, 1), Content::Other),
        Field::other("btlmode", (7, 1), Content::Constant(1)),
    ],
);

/// The register CNF3.
pub const CNF3: Register = Register::new(
    "CNF3",
    Some(0x28),
    8,
    &[
        Field::timing("phseg2", (0, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::other("wakfil", (6, 1), Content::Other),
        Field::other("sof", (7, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["mcp2510", "mcp25625", "mcp251x", "ecan"],
    description: "Microchip MCP2510, MCP2515, MCP25625; PIC18 ECAN BRGCON1 to 3",
    clock: "crystal (F_OSC, divided by 2)",
    registers: &[CNF1, CNF2, CNF3],
    source: "Linux 6.12 drivers/net/can/spi/mcp251x.c; can-utils",
    unconfirmed: Some("the rules PROP_SEG + PHASE_SEG1 >= PHASE_SEG2 and PHASE_SEG2 > SJW"),
    ..Controller::classic("mcp2515", NOMINAL)
};
