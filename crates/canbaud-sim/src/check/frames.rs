//! Each frame that is accepted was sent.

use canbaud::wire::{Frame, FrameKind};

use super::Findings;
use crate::event::{Event, NodeId};
use crate::node::NodeConfig;
use crate::time::Time;

/// What each node is sending.
#[derive(Debug)]
pub(super) struct Frames {
    sending: Vec<Option<Frame>>,
    /// Nominal bit time in femtoseconds, at the nominal clock.
    bit_fs: Vec<f64>,
    /// Whether the node takes part in CAN FD, and with which CRC.
    fd: Vec<(crate::node::FdSupport, canbaud::wire::FdCrc)>,
    phantoms: u64,
}

fn bit_fs(config: &NodeConfig) -> f64 {
    let periods = config.nominal.prescaler() * config.nominal.quanta();
    1e15 * f64::from(periods) / config.oscillator.hertz as f64
}

/// Same identifier, format, DLC and data; ESI is the sender's state, not content.
fn same(a: &Frame, b: &Frame) -> bool {
    let kinds = match (a.kind(), b.kind()) {
        (FrameKind::Fd { brs: x, .. }, FrameKind::Fd { brs: y, .. }) => x == y,
        (x, y) => x == y,
    };
    kinds && a.id() == b.id() && a.dlc() == b.dlc() && a.data() == b.data()
}

impl Frames {
    pub(super) fn new(configs: &[NodeConfig]) -> Self {
        Self {
            sending: vec![None; configs.len()],
            bit_fs: configs.iter().map(bit_fs).collect(),
            fd: configs.iter().map(|config| (config.fd, config.fd_crc)).collect(),
            phantoms: 0,
        }
    }

    pub(super) const fn phantoms(&self) -> u64 {
        self.phantoms
    }

    pub(super) fn reconfigured(&mut self, node: NodeId, config: &NodeConfig) {
        self.sending[node.0] = None;
        self.bit_fs[node.0] = bit_fs(config);
        self.fd[node.0] = (config.fd, config.fd_crc);
    }

    /// Whether a node at this rate, with this kind of CAN FD, can be expected to read `from`.
    fn can_read(&self, node: NodeId, from: usize) -> bool {
        let ratio = self.bit_fs[node.0] / self.bit_fs[from];
        (0.99..1.01).contains(&ratio) && self.fd[node.0] == self.fd[from]
    }

    pub(super) fn event(&mut self, at: Time, node: NodeId, event: &Event, findings: &mut Findings) {
        match event {
            Event::TransmissionStarted { frame, .. } => self.sending[node.0] = Some(*frame),
            Event::ArbitrationLost { .. } | Event::Error { .. } | Event::Abandoned { .. } => {
                self.sending[node.0] = None;
            }
            Event::Transmitted { frame } => {
                let begun = self.sending[node.0].take();
                if begun.is_none_or(|begun| !same(&begun, frame)) {
                    findings.add(at, Some(node), format!("sent {frame:?} without beginning to"));
                }
            }
            Event::Received { frame } => {
                let sent = self.sending.iter().flatten().any(|sending| same(sending, frame));
                if sent {
                    return;
                }
                let peers = (0..self.sending.len()).filter(|peer| *peer != node.0);
                if peers
                    .filter(|peer| self.sending[*peer].is_some())
                    .all(|p| !self.can_read(node, p))
                {
                    self.phantoms += 1;
                } else {
                    findings.add(at, Some(node), format!("accepts {frame:?}, which nobody sends"));
                }
            }
            Event::Counted { .. }
            | Event::Fault(_)
            | Event::RecoverySequence(_)
            | Event::Overload
            | Event::ProtocolException
            | Event::Integrated => {}
        }
    }
}
