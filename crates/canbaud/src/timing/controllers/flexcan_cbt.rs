//! NXP FlexCAN with CBT (BTF = 1), classic.
//!
//! SJW is held to 16 as in the Linux driver although ERJW has 5 bits.
//!
//! Source: Linux 6.12 drivers/net/can/flexcan.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 96), Span::new(2, 32), 16, Prescalers::range(1, 1024))
        .with_segments(Span::new(1, 64), Span::new(1, 32));

/// The register CBT.
pub const CBT: Register = Register::new(
    "CBT",
    Some(0x50),
    32,
    &[
        Field::timing("epseg2", (0, 5), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("epseg1", (5, 5), (Phase::Nominal, Part::PhaseSeg1), Encoding::MinusOne),
        Field::timing("epropseg", (10, 6), (Phase::Nominal, Part::PropSeg), Encoding::MinusOne),
        Field::timing("erjw", (16, 5), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("epresdiv", (21, 10), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
        Field::other("btf", (31, 1), Content::Constant(1)),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    description: "NXP FlexCAN with CBT (BTF = 1), classic",
    clock: "CAN protocol engine clock",
    registers: &[CBT],
    source: "Linux 6.12 drivers/net/can/flexcan",
    ..Controller::classic("flexcan_cbt", NOMINAL)
};
