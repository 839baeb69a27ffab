//! Which bus errors the firmware tells, and how: firmwares differ.

use canbaud_sim::{ErrorKind, Place};

use crate::gs_usb::{HostFrame, can};

/// When the firmware sends an error frame for an error on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reports {
    /// Each error, if the host has switched berr-reporting on and a counter is not zero
    /// (candleLight of 2026).
    OnRequest,
    /// Each error, always.
    Always,
    /// None; as all firmwares, it tells when a counter comes to a limit (candleLight of 2022).
    States,
}

impl Reports {
    pub(super) fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "on-request" => Self::OnRequest,
            "always" => Self::Always,
            "states" => Self::States,
            _ => return None,
        })
    }

    /// The error frame for an error in the node, if there is one. `berr` is whether the host asked
    /// for errors.
    pub(super) fn report(
        self,
        kind: ErrorKind,
        place: Place,
        counters: (u16, u16),
        berr: bool,
    ) -> Option<HostFrame> {
        let told = match self {
            Self::OnRequest => berr && counters != (0, 0),
            Self::Always => true,
            Self::States => false,
        };
        told.then(|| protocol_error(kind, place, counters))
    }
}

/// Where the receive error counter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Level {
    #[default]
    Active,
    Warning,
    Passive,
}

impl Level {
    pub(super) const fn of(rec: u16) -> Self {
        match rec {
            0..96 => Self::Active,
            96..128 => Self::Warning,
            128.. => Self::Passive,
        }
    }

    /// The error frame of a change to this level.
    pub(super) fn report(self, (tec, rec): (u16, u16)) -> HostFrame {
        let detail = match self {
            Self::Active => 0x40,
            Self::Warning => 0x04,
            Self::Passive => 0x10,
        };
        let data = [0, detail, 0, 0, 0, 0, low(tec), low(rec)];
        HostFrame::error(can::ERR_CRTL | can::ERR_CNT, data)
    }
}

fn low(counter: u16) -> u8 {
    u8::try_from(counter).unwrap_or(u8::MAX)
}

fn protocol_error(kind: ErrorKind, place: Place, (tec, rec): (u16, u16)) -> HostFrame {
    let class = can::ERR_PROT | can::ERR_BUSERROR | can::ERR_CNT;
    let (class, detail, location) = match (kind, place) {
        (ErrorKind::Stuff, _) => (class, 0x04, 0),
        (ErrorKind::Form, _) => (class, 0x02, 0),
        // Own dominant bits that read recessive.
        (ErrorKind::Bit, Place::Flag | Place::AckSlot) => (class, 0x08, 0),
        (ErrorKind::Bit, _) => (class, 0x10, 0),
        (ErrorKind::Crc, _) => (class, 0, 0x08),
        (ErrorKind::Ack, _) => (class | can::ERR_ACK, 0, 0x19),
    };
    HostFrame::error(class, [0, 0, detail, location, 0, 0, low(tec), low(rec)])
}
