//! CTU CAN FD (also ESP32-C5 TWAI-FD).
//!
//! Every field is stored as it is. Linux holds the prescaler to 8 (nominal) and 2 (data) although its field has 8 bits.
//!
//! Source: Linux 6.12 drivers/net/can/ctucanfd.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 190), Span::new(1, 63), 31, Prescalers::range(1, 255))
        .with_segments(Span::new(0, 127), Span::new(0, 63));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(2, 94), Span::new(1, 31), 31, Prescalers::range(1, 255))
        .with_segments(Span::new(0, 63), Span::new(0, 31));

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x24),
    32,
    &[
        Field::timing("prop", (0, 7), (Phase::Nominal, Part::PropSeg), Encoding::Raw),
        Field::timing("ph1", (7, 6), (Phase::Nominal, Part::PhaseSeg1), Encoding::Raw),
        Field::timing("ph2", (13, 6), (Phase::Nominal, Part::Tseg2), Encoding::Raw),
        Field::timing("brp", (19, 8), (Phase::Nominal, Part::Prescaler), Encoding::Raw),
        Field::timing("sjw", (27, 5), (Phase::Nominal, Part::Sjw), Encoding::Raw),
    ],
);

/// The register BTR_FD.
pub const BTR_FD: Register = Register::new(
    "BTR_FD",
    Some(0x28),
    32,
    &[
        Field::timing("prop_fd", (0, 6), (Phase::Data, Part::PropSeg), Encoding::Raw),
        Field::timing("ph1_fd", (7, 5), (Phase::Data, Part::PhaseSeg1), Encoding::Raw),
        Field::timing("ph2_fd", (13, 5), (Phase::Data, Part::Tseg2), Encoding::Raw),
        Field::timing("brp_fd", (19, 8), (Phase::Data, Part::Prescaler), Encoding::Raw),
        Field::timing("sjw_fd", (27, 5), (Phase::Data, Part::Sjw), Encoding::Raw),
    ],
);

/// The register TRV_DELAY/SSP_CFG.
pub const SSP_CFG: Register = Register::new(
    "TRV_DELAY/SSP_CFG",
    Some(0x80),
    32,
    &[
        Field::other("trv_delay", (0, 7), Content::Other),
        Field::other("ssp_offset", (16, 8), Content::TdcOffset(Phase::Data)),
        Field::other("ssp_src", (24, 2), Content::TdcMode { phase: Phase::Data, on: 0, off: 1 }),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["ctucanfd", "esp32c5"],
    description: "CTU CAN FD (also ESP32-C5 TWAI-FD)",
    clock: "core clock",
    data: Some(DATA),
    tdc_offset_max: 255,
    registers: &[BTR, BTR_FD, SSP_CFG],
    source: "Linux 6.12 drivers/net/can/ctucanfd",
    ..Controller::classic("ctu_can_fd", NOMINAL)
};
