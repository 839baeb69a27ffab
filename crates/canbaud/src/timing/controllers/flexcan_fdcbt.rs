//! NXP FlexCAN with CAN FD: CBT, FDCBT and FDCTRL.
//!
//! FPROPSEG is stored as it is, unlike every other field. The message buffer sizes in FDCTRL must be kept.
//!
//! Source: Linux 6.12 drivers/net/can/flexcan; NXP MCXA PERI_CAN.h.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits = super::flexcan_cbt::NOMINAL;

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(2, 39), Span::new(2, 8), 4, Prescalers::range(1, 1024))
        .with_segments(Span::new(0, 31), Span::new(1, 8));

pub use super::flexcan_cbt::CBT;

/// The register FDCBT.
pub const FDCBT: Register = Register::new(
    "FDCBT",
    Some(0xC04),
    32,
    &[
        Field::timing("fpseg2", (0, 3), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("fpseg1", (5, 3), (Phase::Data, Part::PhaseSeg1), Encoding::MinusOne),
        Field::timing("fpropseg", (10, 5), (Phase::Data, Part::PropSeg), Encoding::Raw),
        Field::timing("frjw", (16, 3), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::timing("fpresdiv", (20, 10), (Phase::Data, Part::Prescaler), Encoding::MinusOne),
    ],
);

/// The register FDCTRL.
pub const FDCTRL: Register = Register::new(
    "FDCTRL",
    Some(0xC00),
    32,
    &[
        Field::other("tdcval", (0, 6), Content::Other),
        Field::other("tdcoff", (8, 5), Content::TdcOffset(Phase::Data)),
        Field::other("tdcfail", (14, 1), Content::Other),
        Field::other("tdcen", (15, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
        Field::other("mbdsr", (16, 11), Content::Other),
        Field::other("fdrate", (31, 1), Content::Enable(Phase::Data)),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["flexcan_fd", "imx8"],
    description: "NXP FlexCAN with CAN FD: CBT, FDCBT and FDCTRL",
    clock: "CAN protocol engine clock",
    data: Some(DATA),
    tdc_offset_max: 31,
    registers: &[CBT, FDCBT, FDCTRL],
    source: "Linux 6.12 drivers/net/can/flexcan; NXP MCXA PERI_CAN.h",
    ..Controller::classic("flexcan_fdcbt", NOMINAL)
};
