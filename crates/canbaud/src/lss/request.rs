//! What a master sends.

use super::address::Part;
use super::wire::{MASTER_COB_ID, bytes_of, command, number};
use crate::wire::Frame;

/// The two states of a slave [CiA 305, LSS finite state automaton].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LssState {
    /// Only switch, identify and fastscan are heeded.
    Waiting,
    /// The settings can be asked and changed.
    Configuration,
}

impl LssState {
    /// The mode byte of "switch state global".
    #[must_use]
    pub const fn mode(self) -> u8 {
        match self {
            Self::Waiting => 0,
            Self::Configuration => 1,
        }
    }

    /// The state of a mode byte; `None` above 1, which is reserved.
    #[must_use]
    pub const fn from_mode(mode: u8) -> Option<Self> {
        match mode {
            0 => Some(Self::Waiting),
            1 => Some(Self::Configuration),
            _ => None,
        }
    }
}

/// One of the six numbers of "identify remote slave", in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Bound {
    /// The vendor-ID.
    VendorId,
    /// The product code.
    ProductCode,
    /// The least revision number.
    RevisionNumberLow,
    /// The greatest revision number.
    RevisionNumberHigh,
    /// The least serial number.
    SerialNumberLow,
    /// The greatest serial number.
    SerialNumberHigh,
}

impl Bound {
    /// All in order.
    pub const ALL: [Self; 6] = [
        Self::VendorId,
        Self::ProductCode,
        Self::RevisionNumberLow,
        Self::RevisionNumberHigh,
        Self::SerialNumberLow,
        Self::SerialNumberHigh,
    ];

    /// The one behind this.
    #[must_use]
    pub fn next(self) -> Option<Self> {
        Self::ALL.get(self as usize + 1).copied()
    }
}

pub(super) mod cs {
    //! Command specifiers [CiA 305].
    pub(in super::super) const SWITCH_STATE_GLOBAL: u8 = 0x04;
    pub(in super::super) const CONFIGURE_NODE_ID: u8 = 0x11;
    pub(in super::super) const CONFIGURE_BIT_TIMING: u8 = 0x13;
    pub(in super::super) const ACTIVATE_BIT_TIMING: u8 = 0x15;
    pub(in super::super) const STORE_CONFIGURATION: u8 = 0x17;
    /// To 43h, one for each part of the address.
    pub(in super::super) const SWITCH_STATE_SELECTIVE: u8 = 0x40;
    pub(in super::super) const SWITCHED_SELECTIVE: u8 = 0x44;
    /// To 4Bh, one for each bound.
    pub(in super::super) const IDENTIFY_REMOTE_SLAVE: u8 = 0x46;
    pub(in super::super) const IDENTIFY_NON_CONFIGURED: u8 = 0x4C;
    pub(in super::super) const IDENTIFY_SLAVE: u8 = 0x4F;
    pub(in super::super) const NON_CONFIGURED_SLAVE: u8 = 0x50;
    pub(in super::super) const FASTSCAN: u8 = 0x51;
    /// To 5Dh, one for each part of the address.
    pub(in super::super) const INQUIRE_IDENTITY: u8 = 0x5A;
    pub(in super::super) const INQUIRE_NODE_ID: u8 = 0x5E;
}

/// A command of the master [CiA 305], on COB-ID 7E5h.
///
/// Fields hold what is on the wire, also values that a slave has to refuse. Reserved bytes are sent
/// as 0 and not looked at when received.
///
/// ```
/// use canbaud::lss::Request;
/// let request = Request::ConfigureBitTiming { table_selector: 0, table_index: 9 };
/// assert_eq!(request.to_bytes(), [0x13, 0, 9, 0, 0, 0, 0, 0]);
/// assert_eq!(Request::from_bytes([0x13, 0, 9, 0, 0, 0, 0, 0]), Some(request));
/// assert_eq!(request.to_frame().id().raw(), 0x7E5);
/// assert_eq!(Request::from_bytes([0x99; 8]), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Request {
    /// 04h, switch state global: all slaves go to a state. Never answered.
    SwitchStateGlobal {
        /// 0 waiting, 1 configuration ([`LssState::from_mode`]).
        mode: u8,
    },
    /// 40h to 43h, switch state selective: the slave with this address goes to configuration and
    /// answers the last of the four.
    SwitchStateSelective {
        /// Which of the four.
        part: Part,
        /// Its value.
        number: u32,
    },
    /// 11h, configure node-ID: sets the pending node-ID.
    ConfigureNodeId {
        /// 1 to 127, or 255 ([`NodeId::new`](super::NodeId::new)).
        node_id: u8,
    },
    /// 13h, configure bit timing parameters: sets the pending bit rate.
    ConfigureBitTiming {
        /// 0: the table of CiA; 128 to 255: the manufacturer's.
        table_selector: u8,
        /// Index in the table ([`RateSetting::from_index`](super::RateSetting::from_index)).
        table_index: u8,
    },
    /// 15h, activate bit timing parameters: all slaves in configuration switch. Never answered.
    ActivateBitTiming {
        /// Each of the two periods: until the switch, and until anybody may send again.
        switch_delay_ms: u16,
    },
    /// 17h, store configuration: what is pending becomes persistent.
    StoreConfiguration,
    /// 46h to 4Bh, identify remote slave: slaves in the range answer the last of the six.
    IdentifyRemoteSlave {
        /// Which of the six.
        bound: Bound,
        /// Its value.
        number: u32,
    },
    /// 4Ch, identify non-configured remote slave: slaves without node-ID answer.
    IdentifyNonConfiguredRemoteSlave,
    /// 51h, fastscan: slaves without node-ID whose address matches so far answer.
    Fastscan {
        /// IDNumber, to compare with.
        id_number: u32,
        /// BitChecked: bits 31 down to this one are compared; 128: begin.
        bit_checked: u8,
        /// LSSSub: which part of the address.
        lss_sub: u8,
        /// LSSNext: which part is next.
        lss_next: u8,
    },
    /// 5Ah to 5Dh, inquire identity.
    InquireIdentity {
        /// Which part of the address.
        part: Part,
    },
    /// 5Eh, inquire node-ID.
    InquireNodeId,
}

impl Request {
    /// BitChecked of the fastscan that begins anew.
    pub const FASTSCAN_BEGIN: u8 = 0x80;

    /// The eight bytes.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 8] {
        match self {
            Self::SwitchStateGlobal { mode } => command(cs::SWITCH_STATE_GLOBAL, mode as u32),
            Self::SwitchStateSelective { part, number } => {
                command(cs::SWITCH_STATE_SELECTIVE + part.sub(), number)
            }
            Self::ConfigureNodeId { node_id } => command(cs::CONFIGURE_NODE_ID, node_id as u32),
            Self::ConfigureBitTiming { table_selector, table_index } => {
                [cs::CONFIGURE_BIT_TIMING, table_selector, table_index, 0, 0, 0, 0, 0]
            }
            Self::ActivateBitTiming { switch_delay_ms } => {
                command(cs::ACTIVATE_BIT_TIMING, switch_delay_ms as u32)
            }
            Self::StoreConfiguration => command(cs::STORE_CONFIGURATION, 0),
            Self::IdentifyRemoteSlave { bound, number } => {
                command(cs::IDENTIFY_REMOTE_SLAVE + bound as u8, number)
            }
            Self::IdentifyNonConfiguredRemoteSlave => command(cs::IDENTIFY_NON_CONFIGURED, 0),
            Self::Fastscan { id_number, bit_checked, lss_sub, lss_next } => {
                let [cs, a, b, c, d, ..] = command(cs::FASTSCAN, id_number);
                [cs, a, b, c, d, bit_checked, lss_sub, lss_next]
            }
            Self::InquireIdentity { part } => command(cs::INQUIRE_IDENTITY + part.sub(), 0),
            Self::InquireNodeId => command(cs::INQUIRE_NODE_ID, 0),
        }
    }

    /// The command in eight bytes; `None` if there is no such command.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 8]) -> Option<Self> {
        let number = number(bytes);
        let [cs, first, second, _, _, bit_checked, lss_sub, lss_next] = bytes;
        Some(match cs {
            cs::SWITCH_STATE_GLOBAL => Self::SwitchStateGlobal { mode: first },
            cs::CONFIGURE_NODE_ID => Self::ConfigureNodeId { node_id: first },
            cs::CONFIGURE_BIT_TIMING => {
                Self::ConfigureBitTiming { table_selector: first, table_index: second }
            }
            cs::ACTIVATE_BIT_TIMING => {
                Self::ActivateBitTiming { switch_delay_ms: u16::from_le_bytes([first, second]) }
            }
            cs::STORE_CONFIGURATION => Self::StoreConfiguration,
            cs::SWITCH_STATE_SELECTIVE..=0x43 => {
                let part = Part::from_sub(cs - cs::SWITCH_STATE_SELECTIVE)?;
                Self::SwitchStateSelective { part, number }
            }
            cs::IDENTIFY_REMOTE_SLAVE..=0x4B => {
                let place = usize::from(cs - cs::IDENTIFY_REMOTE_SLAVE);
                Self::IdentifyRemoteSlave { bound: *Bound::ALL.get(place)?, number }
            }
            cs::IDENTIFY_NON_CONFIGURED => Self::IdentifyNonConfiguredRemoteSlave,
            cs::FASTSCAN => Self::Fastscan { id_number: number, bit_checked, lss_sub, lss_next },
            cs::INQUIRE_IDENTITY..=0x5D => {
                Self::InquireIdentity { part: Part::from_sub(cs - cs::INQUIRE_IDENTITY)? }
            }
            cs::INQUIRE_NODE_ID => Self::InquireNodeId,
            _ => return None,
        })
    }

    /// The frame, on COB-ID 7E5h with DLC 8.
    #[must_use]
    pub const fn to_frame(self) -> Frame {
        Frame::of_eight(MASTER_COB_ID, self.to_bytes())
    }

    /// The command in a frame; `None` unless it is a classic data frame with base identifier 7E5h,
    /// DLC 8 and a known command specifier.
    #[must_use]
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        bytes_of(frame, MASTER_COB_ID).and_then(Self::from_bytes)
    }
}
