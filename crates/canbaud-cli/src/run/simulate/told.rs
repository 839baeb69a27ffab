//! What the software of nodes tells while a bus is served to the outside.

use canbaud_sim::{NodeId, Observer, Time};

/// Lines since they were taken last.
#[derive(Debug)]
pub(super) struct Told {
    names: Vec<String>,
    lines: Vec<String>,
}

impl Told {
    pub(super) const fn new(names: Vec<String>) -> Self {
        Self { names, lines: Vec::new() }
    }

    pub(super) fn take(&mut self) -> Vec<String> {
        core::mem::take(&mut self.lines)
    }
}

impl Observer for Told {
    fn told(&mut self, at: Time, node: NodeId, what: &str) {
        let name = self.names.get(node.0).map_or("?", String::as_str);
        self.lines.push(format!("{:.6} {name}: {what}", at.seconds()));
    }
}
