//! What a scenario says must come of it.

use super::model::{ExpectTable, StageName, StateName};
use super::stats::NodeStats;
use crate::event::{FaultState, NodeId};
use crate::software::Stage;

/// An expectation that was not met.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {node}: {what}")]
pub struct Miss {
    /// Line of the table in the scenario.
    pub line: usize,
    /// The node.
    pub node: String,
    /// What was expected, and what came.
    pub what: String,
}

/// One table of expectations.
#[derive(Debug, Clone)]
pub(super) struct Expectation {
    pub(super) node: NodeId,
    table: ExpectTable,
    line: usize,
}

impl Expectation {
    pub(super) fn new(node: NodeId, table: &ExpectTable, line: usize) -> Self {
        Self { node, table: table.clone(), line }
    }

    pub(super) fn check(
        &self,
        stats: &NodeStats,
        state: FaultState,
        stage: Option<Stage>,
    ) -> Vec<Miss> {
        let table = &self.table;
        let mut misses = Vec::new();
        let mut miss = |what: String| {
            misses.push(Miss { line: self.line, node: stats.name.clone(), what });
        };
        let at_least = [
            ("received", table.received_min, stats.received),
            ("transmitted", table.transmitted_min, stats.transmitted),
            ("errors", table.errors_min, stats.errors),
            ("bus-off", table.bus_off_min, stats.bus_off),
        ];
        for (name, min, got) in at_least {
            if let Some(min) = min.filter(|min| got < *min) {
                miss(format!("{name} {got}, expected at least {min}"));
            }
        }
        let at_most = [
            ("received", table.received_max, stats.received),
            ("transmitted", table.transmitted_max, stats.transmitted),
            ("errors", table.errors_max, stats.errors),
            ("dominant", table.dominant_max, stats.dominant),
            ("bus-off", table.bus_off_max, stats.bus_off),
            ("messages", table.messages_max, stats.messages),
            ("broken silence", table.broken_silence_max, stats.broken_silence),
        ];
        for (name, max, got) in at_most {
            if let Some(max) = max.filter(|max| got > *max) {
                miss(format!("{name} {got}, expected at most {max}"));
            }
        }
        let want = table.state.map(|name| match name {
            StateName::ErrorActive => FaultState::ErrorActive,
            StateName::ErrorPassive => FaultState::ErrorPassive,
            StateName::BusOff => FaultState::BusOff,
        });
        if let Some(want) = want.filter(|want| *want != state) {
            miss(format!("ends {state}, expected {want}"));
        }
        let want = table.stage.map(|name| match name {
            StageName::Off => Stage::Off,
            StageName::Detecting => Stage::Detecting,
            StageName::Recovering => Stage::Recovering,
            StageName::Initialising => Stage::Initialising,
            StageName::PreOperational => Stage::PreOperational,
            StageName::Operational => Stage::Operational,
            StageName::Stopped => Stage::Stopped,
        });
        if let Some(want) = want.filter(|want| Some(*want) != stage) {
            let stage = stage.map_or("not autonomous".to_owned(), |stage| stage.to_string());
            miss(format!("ends {stage}, expected {want}"));
        }
        let want = table.found.map(|rate| rate.0.bits_per_second());
        if want.is_some() && stats.found_bitrate != want {
            miss(format!("found {:?}, expected {want:?}", stats.found_bitrate));
        }
        if table.lost && stats.found_bitrate.is_some() {
            miss(format!("found {:?}, expected nothing", stats.found_bitrate));
        }
        misses
    }
}
