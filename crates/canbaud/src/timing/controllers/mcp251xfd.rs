//! Microchip MCP2517FD, MCP2518FD; CAN FD of dsPIC33 and PIC18-Q.
//!
//! TDCO is absolute although the data sheet calls it relative (measured by the author of the Linux driver).
//!
//! Source: Linux 6.12 mcp251xfd; Microchip onlinedocs CxNBTCFG.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 256), Span::new(1, 128), 128, Prescalers::range(1, 256))
        .with_bit_quanta(Span::new(4, 385));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 32), Span::new(1, 16), 16, Prescalers::range(1, 256));

/// The register NBTCFG.
pub const NBTCFG: Register = Register::new(
    "NBTCFG",
    Some(0x04),
    32,
    &[
        Field::timing("sjw", (0, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg2", (8, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("tseg1", (16, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("brp", (24, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The register DBTCFG.
pub const DBTCFG: Register = Register::new(
    "DBTCFG",
    Some(0x08),
    32,
    &[
        Field::timing("sjw", (0, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg2", (8, 4), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("tseg1", (16, 5), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("brp", (24, 8), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The register TDC.
pub const TDC: Register = Register::new(
    "TDC",
    Some(0x0C),
    32,
    &[
        Field::other("tdcv", (0, 6), Content::Other),
        Field::other("tdco", (8, 7), Content::TdcOffset(Phase::Data)).encoded(Encoding::Signed),
        Field::other("tdcmod", (16, 2), Content::TdcMode { phase: Phase::Data, on: 2, off: 0 }),
        Field::other("sid11en", (24, 1), Content::Other),
        Field::other("edgflten", (25, 1), Content::Other),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["mcp2517fd", "mcp2518fd", "mcp251863", "dspic33"],
    description: "Microchip MCP2517FD, MCP2518FD; CAN FD of dsPIC33 and PIC18-Q",
    clock: "SYSCLK (40 MHz at most, 80 MHz on dsPIC33)",
    data: Some(DATA),
    tdc_offset_max: 63,
    registers: &[NBTCFG, DBTCFG, TDC],
    source: "Linux 6.12 mcp251xfd; Microchip onlinedocs CxNBTCFG",
    ..Controller::classic("mcp251xfd", NOMINAL)
};
