//! Which bus errors the firmware tells, and how: firmwares differ.

use canbaud_sim::{ErrorKind, Event, Place};

use crate::gs_usb::{HostFrame, can};

/// When the firmware sends an error frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reports {
    /// Each error, if the host has switched berr-reporting on and a counter is not zero
    /// (candleLight of 2026).
    OnRequest,
    /// Each error, always.
    Always,
    /// Only when the receive error counter comes to its limits (candleLight of 2022).
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

    /// The error frame for what happened in the node, if there is one. `berr` is whether the host
    /// asked for errors.
    pub(super) fn report(
        self,
        event: &Event,
        counters: (u16, u16),
        berr: bool,
    ) -> Option<HostFrame> {
        let (tec, rec) = counters;
        match (self, event) {
            (Self::OnRequest, Event::Error { kind, place, .. }) if berr && (tec, rec) != (0, 0) => {
                Some(protocol_error(*kind, *place, counters))
            }
            (Self::Always, Event::Error { kind, place, .. }) => {
                Some(protocol_error(*kind, *place, counters))
            }
            (_, Event::Counted { rec, .. }) => limit(*rec).map(|detail| {
                let data = [0, detail, 0, 0, 0, 0, low(tec), low(*rec)];
                HostFrame::error(can::ERR_CRTL | can::ERR_CNT, data)
            }),
            _ => None,
        }
    }
}

fn low(counter: u16) -> u8 {
    u8::try_from(counter).unwrap_or(u8::MAX)
}

/// `data[1]` when the receive error counter has just come to a limit.
const fn limit(rec: u16) -> Option<u8> {
    match rec {
        96 => Some(0x04),
        128 => Some(0x10),
        _ => None,
    }
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
