//! Xilinx AXI CAN, Zynq-7000, ZynqMP.
//!
//! Source: Linux 6.12 xilinx_can.c; UG585.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 256));

/// The register BRPR.
pub const BRPR: Register = Register::new(
    "BRPR",
    Some(0x08),
    32,
    &[Field::timing("brp", (0, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)],
);

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x0C),
    32,
    &[
        Field::timing("ts1", (0, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("ts2", (4, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("sjw", (7, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["xilinx_can", "zynq"],
    description: "Xilinx AXI CAN, Zynq-7000, ZynqMP",
    clock: "CAN reference clock",
    registers: &[BRPR, BTR],
    source: "Linux 6.12 xilinx_can.c; UG585",
    ..Controller::classic("xcan", NOMINAL)
};
