//! Bosch C_CAN and D_CAN (LPC11C, LPC43, TM4C, AM335x, TMS320F28x, Cyclone V).
//!
//! Offsets are those of the 16 bit C_CAN. D_CAN has BTR at 0x0C and the BRPE bits in 19:16 of the same word.
//!
//! Unconfirmed: the divider CANCLKDIV that the LPC11C has in front of the module.
//!
//! Source: Linux 6.12 drivers/net/can/c_can; can-utils; Intel Cyclone V CBT page; TI SPRUIN7.

use super::register::{Encoding, Field, Part, Register};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits =
    Limits::new(Span::new(2, 16), Span::new(1, 8), 4, Prescalers::range(1, 1024))
        .with_bit_quanta(Span::new(4, 25));

/// The register BTR.
pub const BTR: Register = Register::new(
    "BTR",
    Some(0x06),
    16,
    &[
        Field::timing("brp_lo", (0, 6), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)
            .part_of(10, 0),
        Field::timing("sjw", (6, 2), (Phase::Nominal, Part::Sjw), Encoding::MinusOne),
        Field::timing("tseg1", (8, 4), (Phase::Nominal, Part::Tseg1), Encoding::MinusOne),
        Field::timing("tseg2", (12, 3), (Phase::Nominal, Part::Tseg2), Encoding::MinusOne),
    ],
);

/// The register BRPE.
pub const BRPE: Register = Register::new(
    "BRPE",
    Some(0x0C),
    16,
    &[Field::timing("brp_hi", (0, 4), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne)
        .part_of(10, 6)],
);

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["d_can", "lpc11c", "tm4c", "am335x"],
    description: "Bosch C_CAN and D_CAN (LPC11C, LPC43, TM4C, AM335x, TMS320F28x, Cyclone V)",
    clock: "module clock",
    registers: &[BTR, BRPE],
    source: "Linux 6.12 drivers/net/can/c_can; can-utils; Intel Cyclone V CBT page; TI SPRUIN7",
    unconfirmed: Some("the divider CANCLKDIV in front of the module in the LPC11C"),
    ..Controller::classic("c_can", NOMINAL)
};
