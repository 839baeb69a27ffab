//! Entries of the agenda: what comes from outside the nodes.

use core::cmp::Ordering;

use canbaud::wire::{Frame, Level};

use super::Simulation;
use crate::event::{Disturbance, NodeId, Observer};
use crate::node::{FaultConfinement, NodeConfig};
use crate::time::Time;

/// What to do.
#[derive(Debug)]
pub(super) enum Act {
    Send { node: NodeId, frame: Frame },
    Drive { driver: usize, level: Level },
    Short,
    Unshort,
    ForceRxd { node: NodeId, level: Option<Level> },
    Drift { node: NodeId, ppb: i64 },
    Reconfigure { node: NodeId, config: Box<NodeConfig> },
}

/// What to do, and when; entries of the same time in the order in which they were made.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) at: Time,
    pub(super) number: u64,
    pub(super) act: Act,
}

impl Entry {
    const fn key(&self) -> (Time, u64) {
        (self.at, self.number)
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

impl Simulation {
    /// Does what is next on the agenda.
    pub(super) fn act<O: Observer>(&mut self, observer: &mut O) {
        let Some(std::cmp::Reverse(entry)) = self.agenda.pop() else { return };
        let now = self.now;
        if let Act::ForceRxd { node, .. } | Act::Drift { node, .. } = &entry.act {
            self.nodes[node.0].catch_up(now, &self.line.log);
        }
        let edge = match entry.act {
            Act::Send { node, frame } => {
                self.nodes[node.0].request(now, frame);
                self.refresh(node, observer);
                None
            }
            Act::Drive { driver, level } => {
                observer.disturbed(now, Disturbance::Driven(level));
                self.line.send(now, driver, level);
                None
            }
            Act::Short => {
                observer.disturbed(now, Disturbance::Shorted);
                self.line.short(now)
            }
            Act::Unshort => {
                observer.disturbed(now, Disturbance::Unshorted);
                self.line.unshort(now)
            }
            Act::ForceRxd { node, level } => {
                observer.disturbed(now, Disturbance::ForcedRxd(node, level));
                self.nodes[node.0].force_rxd(now, &self.line.log, level);
                self.refresh(node, observer);
                None
            }
            Act::Drift { node, ppb } => {
                // Checked when the entry was made.
                if self.nodes[node.0].drift(ppb).is_ok() {
                    self.refresh(node, observer);
                }
                None
            }
            Act::Reconfigure { node, config } => {
                self.reconfigure(node, *config, observer);
                None
            }
        };
        if let Some(edge) = edge {
            // The next turn looks at all nodes anyway.
            let _ = self.after_edge(edge.at, edge.to, observer);
        }
    }

    fn refresh<O: Observer>(&mut self, node: NodeId, observer: &mut O) {
        self.next[node.0] = self.nodes[node.0].next();
        if self.nodes[node.0].has_events() {
            self.publish(node.0, observer);
        }
    }

    fn reconfigure<O: Observer>(&mut self, id: NodeId, config: NodeConfig, observer: &mut O) {
        // The oscillator was checked when the entry was made.
        let Ok(node) = self.build(id, config, FaultConfinement::default()) else { return };
        let old = core::mem::replace(&mut self.nodes[id.0], node);
        if old.txd() == Level::Dominant && old.config().can_drive() {
            observer.txd(self.now, id, Level::Recessive);
            self.line.cut(self.now, self.drivers[id.0]);
        }
        observer.reconfigured(self.now, id, self.nodes[id.0].config());
        self.refresh(id, observer);
    }
}
