//! Network management of a CANopen device, as far as coming up needs it \[CiA 301\].

use crate::lss::NodeId;
use crate::wire::{Frame, FrameKind, Id};

/// Identifier of NMT commands.
const COMMAND: Id = Id::Base(0x000);
/// Identifier of boot-up and heartbeat of node-ID 0.
const ERROR_CONTROL: u16 = 0x700;

/// The NMT state of a device that takes part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NmtState {
    /// After the boot-up message.
    PreOperational,
    /// Started by the NMT master, or by itself as a mini-master.
    Operational,
    /// Stopped by the NMT master.
    Stopped,
}

impl NmtState {
    /// The state as a heartbeat carries it.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Stopped => 4,
            Self::Operational => 5,
            Self::PreOperational => 127,
        }
    }
}

/// What an NMT master asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NmtCommand {
    /// Be in this state.
    Enter(NmtState),
    /// Start the application anew.
    ResetNode,
    /// Start the communication anew.
    ResetCommunication,
}

impl NmtCommand {
    /// The command in `frame`, if it is one and it is for `node`.
    ///
    /// ```
    /// use canbaud::lss::NodeId;
    /// use canbaud::node::{NmtCommand, NmtState};
    /// use canbaud::wire::{Frame, FrameKind, Id};
    /// let start_all = Frame::new(Id::Base(0), FrameKind::Data, 2, &[1, 0]).unwrap();
    /// let node = NodeId::new(5).unwrap();
    /// let start = NmtCommand::Enter(NmtState::Operational);
    /// assert_eq!(NmtCommand::for_node(node, &start_all), Some(start));
    /// ```
    #[must_use]
    pub fn for_node(node: NodeId, frame: &Frame) -> Option<Self> {
        if frame.id() != COMMAND || frame.kind() != FrameKind::Data {
            return None;
        }
        let &[command, to] = frame.data() else { return None };
        if !node.is_configured() || (to != 0 && to != node.get()) {
            return None;
        }
        match command {
            1 => Some(Self::Enter(NmtState::Operational)),
            2 => Some(Self::Enter(NmtState::Stopped)),
            128 => Some(Self::Enter(NmtState::PreOperational)),
            129 => Some(Self::ResetNode),
            130 => Some(Self::ResetCommunication),
            _ => None,
        }
    }
}

/// The message that `node` sends when it has come up, or regularly after that.
///
/// ```
/// use canbaud::lss::NodeId;
/// use canbaud::node::{NmtState, boot_up, heartbeat};
/// let node = NodeId::new(5).unwrap();
/// let boot_up = boot_up(node).unwrap();
/// assert_eq!((boot_up.id().raw(), boot_up.data()), (0x705, &[0][..]));
/// assert_eq!(heartbeat(node, NmtState::Operational).unwrap().data(), &[5]);
/// ```
#[must_use]
pub fn heartbeat(node: NodeId, state: NmtState) -> Option<Frame> {
    error_control(node, state.code())
}

/// The boot-up message of `node`; `None` if it has no node-ID.
#[must_use]
pub fn boot_up(node: NodeId) -> Option<Frame> {
    error_control(node, 0)
}

fn error_control(node: NodeId, code: u8) -> Option<Frame> {
    if !node.is_configured() {
        return None;
    }
    let id = Id::base(ERROR_CONTROL + u16::from(node.get()))?;
    Frame::new(id, FrameKind::Data, 1, &[code]).ok()
}

/// The command that starts `node`; 0 is all.
pub(super) fn start(node: u8) -> Option<Frame> {
    Frame::new(COMMAND, FrameKind::Data, 2, &[1, node]).ok()
}

/// Whose boot-up message this is, or whose heartbeat with the state pre-operational.
pub(super) fn is_asking_for_start(frame: &Frame) -> Option<NodeId> {
    let &[code] = frame.data() else { return None };
    let (Id::Base(id), FrameKind::Data) = (frame.id(), frame.kind()) else { return None };
    let node = NodeId::new(u8::try_from(id.checked_sub(ERROR_CONTROL)?).ok()?)?;
    let waits = code & 0x7F == 0 || code & 0x7F == NmtState::PreOperational.code();
    (node.is_configured() && waits).then_some(node)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(data: &[u8]) -> Option<NmtCommand> {
        let frame = Frame::new(COMMAND, FrameKind::Data, data.len() as u8, data).unwrap();
        NmtCommand::for_node(NodeId::new(7).unwrap(), &frame)
    }

    #[test]
    fn commands_are_taken_by_whom_they_are_for() {
        assert_eq!(command(&[2, 7]), Some(NmtCommand::Enter(NmtState::Stopped)));
        assert_eq!(command(&[128, 0]), Some(NmtCommand::Enter(NmtState::PreOperational)));
        assert_eq!(command(&[129, 7]), Some(NmtCommand::ResetNode));
        assert_eq!(command(&[130, 0]), Some(NmtCommand::ResetCommunication));
        assert_eq!(command(&[1, 8]), None);
        assert_eq!(command(&[3, 7]), None);
        assert_eq!(command(&[1]), None);
        assert_eq!(command(&[1, 7, 0]), None);
    }

    #[test]
    fn a_device_without_a_node_id_neither_obeys_nor_speaks() {
        let start = Frame::new(COMMAND, FrameKind::Data, 2, &[1, 0]).unwrap();
        assert_eq!(NmtCommand::for_node(NodeId::UNCONFIGURED, &start), None);
        assert_eq!(boot_up(NodeId::UNCONFIGURED), None);
        assert_eq!(heartbeat(NodeId::UNCONFIGURED, NmtState::Stopped), None);
    }
}
