//! The flags that `F` tells: the same letter, another meaning in each firmware.

use super::firmware::{ErrorReports, Firmware};
use crate::event::FaultState;
use crate::node::FaultConfinement;

/// Something that a flag may tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trouble {
    /// A frame did not reach the host.
    ReceiveOverrun,
    /// A frame to send found no place.
    TransmitOverrun,
    /// Any error on the bus.
    BusError,
    /// An error counter rose.
    Counted,
    /// An error counter is 96 or more.
    Warning,
    /// The controller is error passive or bus-off.
    Passive,
    /// The controller is bus-off.
    BusOff,
    /// Another frame won.
    ArbitrationLost,
}

impl Trouble {
    /// Its bits in the answer to `F`.
    const fn bits(self, firmware: Firmware) -> u8 {
        match (firmware, self) {
            // CAN232 manual.
            (Firmware::Lawicel, Self::ReceiveOverrun) => 0x01 | 0x08,
            (Firmware::Lawicel, Self::TransmitOverrun) => 0x02,
            (Firmware::Lawicel, Self::ArbitrationLost) => 0x40,
            (Firmware::Lawicel, Self::BusError) => 0x80,
            // canable2-fw (Nakakiyo092), document 1.
            (Firmware::Canable2, Self::TransmitOverrun) => 0x01,
            (Firmware::Canable2, Self::ReceiveOverrun) => 0x02,
            (Firmware::Canable2, Self::Counted) => 0x80,
            // USBtin: EFLG of the MCP2515 put in the places of the CAN232 manual.
            (Firmware::Usbtin, Self::ReceiveOverrun) => 0x08,
            (Firmware::Usbtin, Self::BusOff) => 0x80,
            (Firmware::Lawicel | Firmware::Canable2 | Firmware::Usbtin, Self::Warning) => 0x04,
            (Firmware::Lawicel | Firmware::Canable2 | Firmware::Usbtin, Self::Passive) => 0x20,
            _ => 0,
        }
    }
}

/// The flags of an adapter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Status {
    firmware: Firmware,
    seen: u8,
    /// Bits that may be told.
    shown: u8,
}

impl Status {
    pub(super) const fn new(firmware: Firmware, reports: ErrorReports) -> Self {
        let shown = match reports {
            ErrorReports::Records | ErrorReports::Flags => u8::MAX,
            ErrorReports::Silent => {
                Trouble::ReceiveOverrun.bits(firmware) | Trouble::TransmitOverrun.bits(firmware)
            }
        };
        Self { firmware, seen: 0, shown }
    }

    pub(super) const fn note(&mut self, trouble: Trouble) {
        self.seen |= trouble.bits(self.firmware);
    }

    pub(super) const fn clear(&mut self) {
        self.seen = 0;
    }

    /// The flags as `F` reads them; what is read is forgotten, except by a USBtin, whose states
    /// are those of the moment.
    pub(super) fn read(&mut self, fault: &FaultConfinement) -> u8 {
        if self.firmware != Firmware::Usbtin {
            return core::mem::take(&mut self.seen) & self.shown;
        }
        let mut now = self.seen & Trouble::ReceiveOverrun.bits(self.firmware);
        let states = [
            (Trouble::Warning, fault.rec().max(fault.tec()) >= 96),
            (Trouble::Passive, fault.state() != FaultState::ErrorActive),
            (Trouble::BusOff, fault.state() == FaultState::BusOff),
        ];
        for (trouble, holds) in states {
            now |= if holds { trouble.bits(self.firmware) } else { 0 };
        }
        now & self.shown
    }
}
