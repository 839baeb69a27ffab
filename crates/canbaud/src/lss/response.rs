//! What a slave sends.

use core::fmt;

use super::address::Part;
use super::request::cs;
use super::wire::{SLAVE_COB_ID, bytes_of, command, number};
use crate::wire::Frame;

/// How a slave took a setting: error code and specific error [CiA 305].
///
/// What a code means depends on the command: 1 is "out of range" for a node-ID, "not supported" for
/// bit timing and storing; 2 is "storage access error", for storing alone; 255 leaves it to the
/// manufacturer's specific error; the rest is reserved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Outcome {
    /// Error code; 0 is success.
    pub error_code: u8,
    /// Specific error, only with error code 255.
    pub specific_error: u8,
}

impl Outcome {
    /// Done.
    pub const SUCCESS: Self = Self::error(0);
    /// Out of range, or not supported.
    pub const REFUSED: Self = Self::error(1);
    /// Store configuration: the storage medium cannot be accessed.
    pub const STORAGE_ACCESS: Self = Self::error(2);

    const fn error(error_code: u8) -> Self {
        Self { error_code, specific_error: 0 }
    }

    /// An error with a meaning of the manufacturer's.
    #[must_use]
    pub const fn manufacturer(specific_error: u8) -> Self {
        Self { error_code: 0xFF, specific_error }
    }

    /// Whether it was done.
    #[must_use]
    pub const fn is_success(self) -> bool {
        self.error_code == 0
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.error_code, self.specific_error) {
            (0, _) => f.write_str("success"),
            (0xFF, specific) => write!(f, "error 255, manufacturer's error {specific}"),
            (code, _) => write!(f, "error {code}"),
        }
    }
}

/// An answer of a slave [CiA 305], on COB-ID 7E4h.
///
/// ```
/// use canbaud::lss::{Outcome, Response};
/// let response = Response::ConfigureBitTiming(Outcome::REFUSED);
/// assert_eq!(response.to_bytes(), [0x13, 1, 0, 0, 0, 0, 0, 0]);
/// assert_eq!(Response::from_bytes([0x13, 1, 0, 0, 0, 0, 0, 0]), Some(response));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Response {
    /// 11h.
    ConfigureNodeId(Outcome),
    /// 13h.
    ConfigureBitTiming(Outcome),
    /// 17h.
    StoreConfiguration(Outcome),
    /// 44h: the slave of this address is in configuration now.
    SwitchStateSelective,
    /// 4Fh, identify slave: to identify remote slave and to fastscan.
    IdentifySlave,
    /// 50h, identify non-configured slave.
    IdentifyNonConfiguredSlave,
    /// 5Ah to 5Dh.
    InquireIdentity {
        /// Which part of the address.
        part: Part,
        /// Its value.
        number: u32,
    },
    /// 5Eh.
    InquireNodeId {
        /// 1 to 127, or 255.
        node_id: u8,
    },
}

impl Response {
    /// The eight bytes.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 8] {
        match self {
            Self::ConfigureNodeId(outcome) => set(cs::CONFIGURE_NODE_ID, outcome),
            Self::ConfigureBitTiming(outcome) => set(cs::CONFIGURE_BIT_TIMING, outcome),
            Self::StoreConfiguration(outcome) => set(cs::STORE_CONFIGURATION, outcome),
            Self::SwitchStateSelective => command(cs::SWITCHED_SELECTIVE, 0),
            Self::IdentifySlave => command(cs::IDENTIFY_SLAVE, 0),
            Self::IdentifyNonConfiguredSlave => command(cs::NON_CONFIGURED_SLAVE, 0),
            Self::InquireIdentity { part, number } => {
                command(cs::INQUIRE_IDENTITY + part.sub(), number)
            }
            Self::InquireNodeId { node_id } => command(cs::INQUIRE_NODE_ID, node_id as u32),
        }
    }

    /// The answer in eight bytes; `None` if there is no such answer.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 8]) -> Option<Self> {
        let [cs, first, second, ..] = bytes;
        let outcome = Outcome { error_code: first, specific_error: second };
        Some(match cs {
            cs::CONFIGURE_NODE_ID => Self::ConfigureNodeId(outcome),
            cs::CONFIGURE_BIT_TIMING => Self::ConfigureBitTiming(outcome),
            cs::STORE_CONFIGURATION => Self::StoreConfiguration(outcome),
            cs::SWITCHED_SELECTIVE => Self::SwitchStateSelective,
            cs::IDENTIFY_SLAVE => Self::IdentifySlave,
            cs::NON_CONFIGURED_SLAVE => Self::IdentifyNonConfiguredSlave,
            cs::INQUIRE_IDENTITY..=0x5D => {
                let part = Part::from_sub(cs - cs::INQUIRE_IDENTITY)?;
                Self::InquireIdentity { part, number: number(bytes) }
            }
            cs::INQUIRE_NODE_ID => Self::InquireNodeId { node_id: first },
            _ => return None,
        })
    }

    /// The frame, on COB-ID 7E4h with DLC 8.
    #[must_use]
    pub const fn to_frame(self) -> Frame {
        Frame::of_eight(SLAVE_COB_ID, self.to_bytes())
    }

    /// The answer in a frame; `None` unless it is a classic data frame with base identifier 7E4h,
    /// DLC 8 and a known command specifier.
    #[must_use]
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        bytes_of(frame, SLAVE_COB_ID).and_then(Self::from_bytes)
    }
}

const fn set(cs: u8, outcome: Outcome) -> [u8; 8] {
    [cs, outcome.error_code, outcome.specific_error, 0, 0, 0, 0, 0]
}
