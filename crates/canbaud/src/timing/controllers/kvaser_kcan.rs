//! Kvaser KCAN (PCIEcan).
//!
//! Source: Linux 6.12 kvaser_pciefd.c.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 512), Span::new(1, 32), 16, Prescalers::range(1, 8192));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 512), Span::new(1, 32), 16, Prescalers::range(1, 8192));

/// The register BTRN.
pub const BTRN: Register = Register::new(
    "BTRN",
    Some(0x420),
    32,
    &[
        Field::timing("brp", (0, 13), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (13, 4), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (17, 9), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (26, 5), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The register BTRD.
pub const BTRD: Register = Register::new(
    "BTRD",
    Some(0x428),
    32,
    &[
        Field::timing("brp", (0, 13), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
        Field::timing("sjw", (13, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (17, 9), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (26, 5), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["kvaser_pciefd"],
    description: "Kvaser KCAN (PCIEcan)",
    clock: "80 MHz",
    data: Some(DATA),
    registers: &[BTRN, BTRD],
    source: "Linux 6.12 kvaser_pciefd.c",
    ..Controller::classic("kvaser_kcan", NOMINAL)
};
