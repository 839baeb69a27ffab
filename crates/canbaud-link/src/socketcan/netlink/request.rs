//! Requests to the kernel.

use super::attribute::push;
use super::can::{TdcInfo, TimingInfo, attr};
use super::message::{HEADER, RTM_NEWLINK};

const RTM_GETLINK: u16 = 18;
const F_REQUEST: u16 = 0x1;
const F_ACK: u16 = 0x4;
const F_DUMP: u16 = 0x300;
const IFF_UP: u32 = 1;
const IFLA_LINKINFO: u16 = 18;
const IFLA_INFO_KIND: u16 = 1;
const IFLA_INFO_DATA: u16 = 2;

/// Up or down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// Set up.
    Up,
    /// Set down.
    Down,
}

/// What to change of a CAN interface; only what is there is changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinkChange {
    /// Up or down; the kernel does it behind everything else.
    pub set: Option<Change>,
    /// Nominal bit timing: a bit rate alone is calculated by the kernel.
    pub timing: Option<TimingInfo>,
    /// Bit timing of the data phase.
    pub data_timing: Option<TimingInfo>,
    /// Which bits of the control mode to set to what: mask and values.
    pub ctrlmode: Option<(u32, u32)>,
    /// Transmitter delay compensation.
    pub tdc: Option<TdcInfo>,
    /// Restart after bus-off, in ms.
    pub restart_ms: Option<u32>,
}

impl LinkChange {
    /// Up or down and nothing else.
    #[must_use]
    pub fn only(set: Change) -> Self {
        Self { set: Some(set), ..Self::default() }
    }

    /// The request for interface `index`.
    #[must_use]
    pub fn encode(&self, sequence: u32, index: u32) -> Vec<u8> {
        let (flags, mask) = match self.set {
            Some(Change::Up) => (IFF_UP, IFF_UP),
            Some(Change::Down) => (0, IFF_UP),
            None => (0, 0),
        };
        let mut out = begin(RTM_NEWLINK, F_REQUEST | F_ACK, sequence, index, flags, mask);
        let mut data = Vec::new();
        if let Some(timing) = self.timing {
            push(&mut data, attr::BITTIMING, &timing.to_bytes());
        }
        if let Some(timing) = self.data_timing {
            push(&mut data, attr::DATA_BITTIMING, &timing.to_bytes());
        }
        if let Some((mask, values)) = self.ctrlmode {
            let pair = [mask.to_ne_bytes(), values.to_ne_bytes()].concat();
            push(&mut data, attr::CTRLMODE, &pair);
        }
        if let Some(tdc) = self.tdc {
            push(&mut data, attr::TDC, &tdc_values(tdc));
        }
        if let Some(ms) = self.restart_ms {
            push(&mut data, attr::RESTART_MS, &ms.to_ne_bytes());
        }
        if !data.is_empty() {
            let mut info = Vec::new();
            push(&mut info, IFLA_INFO_KIND, b"can");
            push(&mut info, IFLA_INFO_DATA, &data);
            push(&mut out, IFLA_LINKINFO, &info);
        }
        finish(out)
    }
}

fn tdc_values(tdc: TdcInfo) -> Vec<u8> {
    let mut nest = Vec::new();
    let values =
        [(attr::TDC_TDCV, tdc.tdcv), (attr::TDC_TDCO, tdc.tdco), (attr::TDC_TDCF, tdc.tdcf)];
    for (kind, value) in values {
        if let Some(value) = value {
            push(&mut nest, kind, &value.to_ne_bytes());
        }
    }
    nest
}

/// Asks for all links.
#[must_use]
pub fn dump_links(sequence: u32) -> Vec<u8> {
    finish(begin(RTM_GETLINK, F_REQUEST | F_DUMP, sequence, 0, 0, 0))
}

/// Asks for the link `index`.
#[must_use]
pub fn get_link(sequence: u32, index: u32) -> Vec<u8> {
    finish(begin(RTM_GETLINK, F_REQUEST, sequence, index, 0, 0))
}

fn begin(kind: u16, how: u16, sequence: u32, index: u32, flags: u32, mask: u32) -> Vec<u8> {
    let mut out = vec![0; 4];
    out.extend(kind.to_ne_bytes());
    out.extend(how.to_ne_bytes());
    out.extend(sequence.to_ne_bytes());
    // Port: the kernel fills in the sender's.
    out.extend([0; 4]);
    debug_assert_eq!(out.len(), HEADER);
    // Family, padding, hardware type.
    out.extend([0; 4]);
    for word in [index, flags, mask] {
        out.extend(word.to_ne_bytes());
    }
    out
}

fn finish(mut out: Vec<u8>) -> Vec<u8> {
    // A request has a few hundred bytes.
    let length = u32::try_from(out.len()).unwrap_or(u32::MAX).to_ne_bytes();
    if let Some(room) = out.first_chunk_mut() {
        *room = length;
    }
    out
}
