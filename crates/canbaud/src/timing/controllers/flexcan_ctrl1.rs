//! NXP FlexCAN, CTRL1.
//!
//! CTRL1 holds mode bits too, which must be kept; those of bits 8 to 15 are not decoded.
//!
//! Source: Linux 6.12 drivers/net/can/flexcan.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(4, 16), Span::new(2, 8), 4, Prescalers::range(1, 256))
        .with_segments(Span::new(1, 8), Span::new(1, 8));

/// The register CTRL1.
pub const CTRL1: Register = Register::new(
    "CTRL1",
    Some(0x04),
    32,
    &[
        Field::timing("propseg", (0, 3), (Phase::Nominal, Part::PropSeg), Encoding::MinusOne),
        Field::other("lom", (3, 1), Content::Other),
        Field::other("lbuf", (4, 1), Content::Other),
        Field::other("tsyn", (5, 1), Content::Other),
        Field::other("boffrec", (6, 1), Content::Other),
        Field::other("smp", (7, 1), Content::Other),
        Field::timing("pseg2", (16, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("pseg1", (19, 3), (Phase::Nominal, Part::PhaseSeg1), Encoding::MinusOne),
        Field::timing("rjw", (22, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("presdiv", (24, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["flexcan", "kinetis"],
    description: "NXP FlexCAN, CTRL1",
    clock: "CAN protocol engine clock",
    registers: &[CTRL1],
    source: "Linux 6.12 drivers/net/can/flexcan",
    ..Controller::classic("flexcan_ctrl1", NOMINAL)
};
