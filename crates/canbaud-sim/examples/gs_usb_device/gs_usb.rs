//! The gs_usb protocol of candleLight and its relatives, as the kernel's driver speaks it.
//! Every number is little endian.

use canbaud::wire::{Frame, FrameKind, Id};

/// A feature that the device has, and the mode flag that switches it on.
pub(super) mod feature {
    pub(crate) const LISTEN_ONLY: u32 = 1 << 0;
    pub(crate) const HW_TIMESTAMP: u32 = 1 << 4;
    pub(crate) const FD: u32 = 1 << 8;
    pub(crate) const BT_CONST_EXT: u32 = 1 << 10;
    pub(crate) const BERR_REPORTING: u32 = 1 << 12;
    pub(crate) const GET_STATE: u32 = 1 << 13;
}

/// Bits of an identifier and classes of error frames [linux/can.h, linux/can/error.h].
pub(super) mod can {
    pub(crate) const EFF_FLAG: u32 = 0x8000_0000;
    pub(crate) const RTR_FLAG: u32 = 0x4000_0000;
    pub(crate) const ERR_FLAG: u32 = 0x2000_0000;
    pub(crate) const ERR_CRTL: u32 = 0x004;
    pub(crate) const ERR_PROT: u32 = 0x008;
    pub(crate) const ERR_ACK: u32 = 0x020;
    pub(crate) const ERR_BUSERROR: u32 = 0x080;
    pub(crate) const ERR_CNT: u32 = 0x200;
}

/// Flags of a host frame.
const FLAG_OVERFLOW: u8 = 1 << 0;
const FLAG_FD: u8 = 1 << 1;
const FLAG_BRS: u8 = 1 << 2;
const FLAG_ESI: u8 = 1 << 3;

/// `echo_id` of what was received.
const RECEIVED: u32 = 0xFFFF_FFFF;

/// The vendor requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Request {
    HostFormat,
    BitTiming,
    Mode,
    BtConst,
    DeviceConfig,
    Timestamp,
    DataBitTiming,
    BtConstExt,
    GetState,
}

impl Request {
    pub(super) const fn new(number: u8) -> Option<Self> {
        Some(match number {
            0 => Self::HostFormat,
            1 => Self::BitTiming,
            2 => Self::Mode,
            4 => Self::BtConst,
            5 => Self::DeviceConfig,
            6 => Self::Timestamp,
            10 => Self::DataBitTiming,
            11 => Self::BtConstExt,
            14 => Self::GetState,
            _ => return None,
        })
    }
}

/// Little endian words of a request.
pub(super) fn words<const N: usize>(data: &[u8]) -> Option<[u32; N]> {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(data.chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().ok()?);
    }
    (data.len() >= 4 * N).then_some(words)
}

/// Words as bytes.
pub(super) fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Limits of the bit timing: those of the bxCAN of an STM32F0, and those of an FDCAN.
pub(super) fn bt_const(features: u32, clock_hz: u32) -> Vec<u8> {
    let fd = features & feature::FD != 0;
    let limits: [u32; 8] =
        if fd { [1, 256, 1, 128, 128, 1, 512, 1] } else { [1, 16, 1, 8, 4, 1, 1024, 1] };
    bytes(&[&[features, clock_hz][..], &limits].concat())
}

/// The same with those of the data phase.
pub(super) fn bt_const_ext(features: u32, clock_hz: u32) -> Vec<u8> {
    [bt_const(features, clock_hz), bytes(&[1, 32, 1, 16, 16, 1, 32, 1])].concat()
}

/// One channel, software version 2, hardware version 1.
pub(super) fn device_config() -> Vec<u8> {
    bytes(&[0, 2, 1])
}

/// What goes to the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct HostFrame {
    echo_id: u32,
    can_id: u32,
    dlc: u8,
    flags: u8,
    data: Vec<u8>,
}

impl HostFrame {
    /// A frame from the bus.
    pub(super) fn received(frame: &Frame) -> Self {
        let (kind, id) = (frame.kind(), frame.id());
        let extended = if id.is_extended() { can::EFF_FLAG } else { 0 };
        let remote = if kind == FrameKind::Remote { can::RTR_FLAG } else { 0 };
        let flags = match kind {
            FrameKind::Data | FrameKind::Remote => 0,
            FrameKind::Fd { brs, esi } => {
                FLAG_FD | if brs { FLAG_BRS } else { 0 } | if esi { FLAG_ESI } else { 0 }
            }
        };
        Self {
            echo_id: RECEIVED,
            can_id: id.raw() | extended | remote,
            dlc: frame.dlc(),
            flags,
            data: frame.data().to_vec(),
        }
    }

    /// An error report [linux/can/error.h].
    pub(super) fn error(class: u32, data: [u8; 8]) -> Self {
        let can_id = can::ERR_FLAG | class;
        Self { echo_id: RECEIVED, can_id, dlc: 8, flags: 0, data: data.to_vec() }
    }

    /// The host's frame went out.
    pub(super) const fn echo(echo_id: u32) -> Self {
        Self { echo_id, can_id: 0, dlc: 0, flags: 0, data: Vec::new() }
    }

    /// The queue was full before this frame.
    pub(super) const fn after_overflow(mut self) -> Self {
        self.flags |= FLAG_OVERFLOW;
        self
    }

    /// The frame as it crosses the bus; `stamp` in µs if time stamps are on.
    pub(super) fn encode(&self, stamp: Option<u32>) -> Vec<u8> {
        let mut wire = bytes(&[self.echo_id, self.can_id]);
        wire.extend([self.dlc, 0, self.flags, 0]);
        wire.extend(&self.data);
        // The data field has one of two lengths.
        wire.resize(12 + if self.flags & FLAG_FD != 0 { 64 } else { 8 }, 0);
        wire.extend(stamp.iter().flat_map(|stamp| stamp.to_le_bytes()));
        wire
    }
}

/// A frame that the host wants sent, with its echo id.
pub(super) fn to_send(wire: &[u8]) -> Option<(u32, Frame)> {
    let [echo_id, can_id] = words(wire)?;
    let (dlc, flags) = (*wire.get(8)?, *wire.get(10)?);
    let id = if can_id & can::EFF_FLAG != 0 {
        Id::extended(can_id & 0x1FFF_FFFF)?
    } else {
        Id::base((can_id & 0x7FF) as u16)?
    };
    let kind = match (flags & FLAG_FD != 0, can_id & can::RTR_FLAG != 0) {
        (true, _) => FrameKind::Fd { brs: flags & FLAG_BRS != 0, esi: flags & FLAG_ESI != 0 },
        (false, true) => FrameKind::Remote,
        (false, false) => FrameKind::Data,
    };
    let length = Frame::data_length(kind, dlc);
    let frame = Frame::new(id, kind, dlc, wire.get(12..12 + length)?).ok()?;
    Some((echo_id, frame))
}
