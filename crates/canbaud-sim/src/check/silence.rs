//! A node that must not drive the bus never does: zero dominant bits.

use canbaud::wire::Level;

use super::Findings;
use crate::event::NodeId;
use crate::node::{Gate, Mode, NodeConfig, Wire};
use crate::time::Time;

/// Which nodes must keep silent.
#[derive(Debug)]
pub(super) struct Silence {
    silent: Vec<Option<&'static str>>,
}

/// Why a node must keep silent.
fn reason(config: &NodeConfig) -> Option<&'static str> {
    if config.wire == Wire::Cut {
        return Some("it is cut off");
    }
    if config.gate == Gate::Closed {
        return Some("its gate is closed");
    }
    match config.mode {
        Mode::BusMonitoring => Some("it monitors the bus"),
        Mode::Loopback => Some("it is in loopback"),
        Mode::Disabled => Some("it is switched off"),
        Mode::Normal | Mode::Restricted => None,
    }
}

impl Silence {
    pub(super) fn new(configs: &[NodeConfig]) -> Self {
        Self { silent: configs.iter().map(reason).collect() }
    }

    pub(super) fn reconfigured(&mut self, node: NodeId, config: &NodeConfig) {
        self.silent[node.0] = reason(config);
    }

    pub(super) fn txd(&self, at: Time, node: NodeId, level: Level, findings: &mut Findings) {
        if let (Level::Dominant, Some(reason)) = (level, self.silent[node.0]) {
            findings.add(at, Some(node), format!("drives the bus dominant although {reason}"));
        }
    }
}
