//! Rockchip RK3568 CAN FD.
//!
//! Source: Linux 6.12 rockchip_canfd.
//!
//! Unconfirmed: the offset of TDC; can-utils has 256 as the highest prescaler.

use super::register::{Content, Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 256), Span::new(1, 128), 128, Prescalers::multiples(2, 512, 2));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 32), Span::new(1, 16), 16, Prescalers::multiples(2, 512, 2));

/// The register FD_NOMINAL_BITTIMING.
pub const NOMINAL_BITTIMING: Register = Register::new(
    "FD_NOMINAL_BITTIMING",
    Some(0x100),
    32,
    &[
        Field::timing("tseg1", (0, 8), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (8, 7), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
        Field::timing("brp", (16, 8), (Phase::Nominal, Part::Prescaler), Encoding::HalfMinusOne),
        Field::timing("sjw", (24, 7), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::other("sam", (31, 1), Content::Other),
    ],
);

/// The register FD_DATA_BITTIMING.
pub const DATA_BITTIMING: Register = Register::new(
    "FD_DATA_BITTIMING",
    Some(0x104),
    32,
    &[
        Field::timing("tseg1", (0, 5), (Phase::Data, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (5, 4), (Phase::Data, Part::Tseg2), Encoding::MinusOne),
        Field::timing("brp", (9, 8), (Phase::Data, Part::Prescaler), Encoding::HalfMinusOne),
        Field::timing("sjw", (17, 4), (Phase::Data, Part::Sjw), Encoding::MinusOne),
        Field::other("sam", (21, 1), Content::Other),
    ],
);

/// The register TDC.
pub const TDC: Register = Register::new(
    "TDC",
    Some(0x108),
    32,
    &[
        Field::other("en", (0, 1), Content::TdcMode { phase: Phase::Data, on: 1, off: 0 }),
        Field::other("tdco", (1, 6), Content::TdcOffset(Phase::Data)),
    ],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["rk3568"],
    description: "Rockchip RK3568 CAN FD",
    clock: "CAN clock (300 MHz; the prescaler counts in twos)",
    data: Some(DATA),
    tdc_offset_max: 63,
    registers: &[NOMINAL_BITTIMING, DATA_BITTIMING, TDC],
    source: "Linux 6.12 rockchip_canfd",
    unconfirmed: Some("the offset of TDC; can-utils has 256 as the highest prescaler"),
    ..Controller::classic("rockchip_canfd", NOMINAL)
};
