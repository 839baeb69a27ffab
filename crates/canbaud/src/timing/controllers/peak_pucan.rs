//! PEAK uCAN (PCAN-USB FD, PCIe FD).
//!
//! Has no registers: the host sends byte fields, each minus one, in a command.
//!
//! Source: Linux 6.12 peak_canfd.h.

use super::Controller;
use crate::timing::{Limits, Prescalers, Span};

/// Limits of the nominal phase.
pub const NOMINAL: Limits =
    Limits::new(Span::new(1, 256), Span::new(1, 128), 128, Prescalers::range(1, 1024));

/// Limits of the CAN FD data phase.
pub const DATA: Limits =
    Limits::new(Span::new(1, 32), Span::new(1, 16), 16, Prescalers::range(1, 1024));

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["pcan"],
    description: "PEAK uCAN (PCAN-USB FD, PCIe FD)",
    clock: "20, 24, 30, 40, 60 or 80 MHz, chosen with the timing",
    data: Some(DATA),
    source: "Linux 6.12 peak_canfd.h",
    ..Controller::classic("peak_pucan", NOMINAL)
};
