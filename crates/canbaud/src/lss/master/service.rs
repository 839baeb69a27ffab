//! What a master can ask for, and what comes back.

use core::fmt;

use crate::lss::{
    Bound, IdRange, LssAddress, LssState, NodeId, Outcome, Part, RateSetting, Request, Response,
};
use crate::units::Micros;

/// A service that is one exchange of frames; [`Fastscan`](super::Fastscan) and
/// [`Activation`](super::Activation) are more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Service {
    /// All slaves go to this state; no answer.
    SwitchStateGlobal(LssState),
    /// The slave of this address goes to configuration.
    SwitchStateSelective(LssAddress),
    /// Sets the pending node-ID of the slave in configuration.
    ConfigureNodeId(NodeId),
    /// Sets the pending bit rate of the slave in configuration.
    ConfigureBitTiming {
        /// 0: the table of CiA; 128 to 255: the manufacturer's.
        table_selector: u8,
        /// Index in the table.
        table_index: u8,
    },
    /// Makes what is pending persistent.
    StoreConfiguration,
    /// Asks for one part of the address of the slave in configuration.
    InquireIdentity(Part),
    /// Asks for the node-ID of the slave in configuration.
    InquireNodeId,
    /// Asks whether there is a slave in this range, in whatever state.
    IdentifyRemoteSlave(IdRange),
    /// Asks whether there is a slave without node-ID, in whatever state.
    IdentifyNonConfiguredRemoteSlave,
}

impl Service {
    /// Configure bit timing from table 0; `None` for a bit rate that is not in it.
    #[must_use]
    pub fn configure_rate(setting: RateSetting) -> Option<Self> {
        let table_index = setting.index()?;
        Some(Self::ConfigureBitTiming { table_selector: 0, table_index })
    }

    /// Frame `place` of the service, from 0 on; `None` behind the last.
    #[must_use]
    pub fn request(&self, place: usize) -> Option<Request> {
        let single = |request| if place == 0 { Some(request) } else { None };
        match *self {
            Self::SwitchStateGlobal(state) => {
                single(Request::SwitchStateGlobal { mode: state.mode() })
            }
            Self::SwitchStateSelective(address) => {
                let part = *Part::ALL.get(place)?;
                Some(Request::SwitchStateSelective { part, number: address.part(part) })
            }
            Self::ConfigureNodeId(node_id) => {
                single(Request::ConfigureNodeId { node_id: node_id.get() })
            }
            Self::ConfigureBitTiming { table_selector, table_index } => {
                single(Request::ConfigureBitTiming { table_selector, table_index })
            }
            Self::StoreConfiguration => single(Request::StoreConfiguration),
            Self::InquireIdentity(part) => single(Request::InquireIdentity { part }),
            Self::InquireNodeId => single(Request::InquireNodeId),
            Self::IdentifyRemoteSlave(range) => {
                let bound = *Bound::ALL.get(place)?;
                Some(Request::IdentifyRemoteSlave { bound, number: range.bound(bound) })
            }
            Self::IdentifyNonConfiguredRemoteSlave => {
                single(Request::IdentifyNonConfiguredRemoteSlave)
            }
        }
    }

    /// Whether a slave owes an answer.
    #[must_use]
    pub const fn is_answered(&self) -> bool {
        !matches!(self, Self::SwitchStateGlobal(_))
    }

    /// What `response` means here; `None` if it answers something else.
    pub(super) fn reply(&self, response: Response) -> Option<Result<Reply, ServiceError>> {
        let set = |outcome: Outcome| {
            Some(if outcome.is_success() {
                Ok(Reply::Done)
            } else {
                Err(ServiceError::Refused(outcome))
            })
        };
        match (*self, response) {
            (Self::ConfigureNodeId(_), Response::ConfigureNodeId(outcome))
            | (Self::ConfigureBitTiming { .. }, Response::ConfigureBitTiming(outcome))
            | (Self::StoreConfiguration, Response::StoreConfiguration(outcome)) => set(outcome),
            (Self::SwitchStateSelective(_), Response::SwitchStateSelective)
            | (Self::IdentifyRemoteSlave(_), Response::IdentifySlave)
            | (Self::IdentifyNonConfiguredRemoteSlave, Response::IdentifyNonConfiguredSlave) => {
                Some(Ok(Reply::Done))
            }
            (Self::InquireIdentity(asked), Response::InquireIdentity { part, number })
                if asked == part =>
            {
                Some(Ok(Reply::Number(number)))
            }
            (Self::InquireNodeId, Response::InquireNodeId { node_id }) => {
                Some(Ok(Reply::NodeId(node_id)))
            }
            _ => None,
        }
    }
}

impl IdRange {
    const fn bound(&self, bound: Bound) -> u32 {
        match bound {
            Bound::VendorId => self.vendor_id,
            Bound::ProductCode => self.product_code,
            Bound::RevisionNumberLow => self.revision_number.0,
            Bound::RevisionNumberHigh => self.revision_number.1,
            Bound::SerialNumberLow => self.serial_number.0,
            Bound::SerialNumberHigh => self.serial_number.1,
        }
    }
}

/// What a service came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reply {
    /// Sent, where no answer is due; else: a slave did it, or is there.
    Done,
    /// A part of the address.
    Number(u32),
    /// The node-ID, as received.
    NodeId(u8),
}

/// Why a service came to nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ServiceError {
    /// Nobody answered within this time: no slave is in configuration, none has the address, or it
    /// does not know the command.
    NoAnswer(Micros),
    /// The slave said no.
    Refused(Outcome),
    /// Two slaves gave different answers: more than one is in configuration.
    SeveralAnswers,
}

impl fmt::Display for ServiceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer(time) => write!(f, "no answer within {time}"),
            Self::Refused(outcome) => write!(f, "refused: {outcome}"),
            Self::SeveralAnswers => f.write_str("more than one device answered"),
        }
    }
}

impl core::error::Error for ServiceError {}
