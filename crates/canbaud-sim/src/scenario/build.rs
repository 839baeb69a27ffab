//! From the tables to nodes, traffic and disturbances; says what is impossible.

use std::path::Path;

use toml::Spanned;

use super::expect::Expectation;
use super::model::File;
use super::{ScenarioError, line_of};
use crate::event::NodeId;
use crate::node::NodeConfig;
use crate::time::{Span, Time};

mod member;
mod timing;
mod traffic;
mod trouble;

pub(super) use member::{gate, mode, wire};
pub(super) use timing::{timing_for, usual_sample_point};
pub(super) use trouble::{Change, Power, Trouble};

use member::{Member, member};
use traffic::{Stream, stream};
use trouble::{change, trouble};

/// A scenario that can be run.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// One line.
    pub title: String,
    /// What it shows.
    pub description: String,
    /// How long it takes.
    pub duration: Span,
    /// Its seed, where none is given.
    pub seed: u64,
    pub(super) members: Vec<Member>,
    pub(super) streams: Vec<Stream>,
    pub(super) troubles: Vec<Trouble>,
    pub(super) changes: Vec<(Time, NodeId, Change)>,
    pub(super) expectations: Vec<Expectation>,
}

impl Scenario {
    /// Names of the nodes, in order.
    #[must_use]
    pub fn node_names(&self) -> Vec<String> {
        self.members.iter().map(|member| member.config.name.clone()).collect()
    }

    /// Whether a node is to find its own way, so that a run needs a
    /// [`Supplier`](crate::software::Supplier).
    #[must_use]
    pub fn needs_software(&self) -> bool {
        self.members.iter().any(|member| member.autonomous.is_some())
    }

    /// Whether `node` is to find its own way.
    #[must_use]
    pub fn is_autonomous(&self, node: NodeId) -> bool {
        self.members.get(node.0).is_some_and(|member| member.autonomous.is_some())
    }

    /// How the node of this name is set up, and its place.
    #[must_use]
    pub fn node(&self, name: &str) -> Option<(NodeId, &NodeConfig)> {
        let place = self.members.iter().position(|member| member.config.name == name)?;
        Some((NodeId(place), &self.members[place].config))
    }
}

/// What is wrong with a table; the line is added where the table is known.
pub(super) type Outcome<T> = Result<T, String>;

pub(super) fn build(name: &str, text: &str, file: &File) -> Result<Scenario, ScenarioError> {
    let at_line = |start: usize, what: String| ScenarioError {
        file: name.to_owned(),
        line: line_of(text, start),
        what,
    };
    let mut scenario = Scenario {
        title: file.title.clone(),
        description: file.description.clone(),
        duration: file.duration.0,
        seed: file.seed,
        members: Vec::new(),
        streams: Vec::new(),
        troubles: Vec::new(),
        changes: Vec::new(),
        expectations: Vec::new(),
    };
    for table in &file.node {
        let member = member(table.get_ref(), &scenario).map_err(|w| at_line(start(table), w))?;
        scenario.members.push(member);
    }
    let directory = Path::new(name).parent().unwrap_or_else(|| Path::new(""));
    for table in &file.traffic {
        let stream = stream(table.get_ref(), &scenario, directory);
        scenario.streams.push(stream.map_err(|w| at_line(start(table), w))?);
    }
    for table in &file.disturbance {
        let trouble = trouble(table.get_ref(), &scenario);
        scenario.troubles.push(trouble.map_err(|w| at_line(start(table), w))?);
    }
    for table in &file.change {
        let change = change(table.get_ref(), &scenario);
        scenario.changes.push(change.map_err(|w| at_line(start(table), w))?);
    }
    for table in &file.expect {
        let node = find(&scenario, &table.get_ref().node).map_err(|w| at_line(start(table), w))?;
        let line = line_of(text, start(table));
        scenario.expectations.push(Expectation::new(node, table.get_ref(), line));
    }
    Ok(scenario)
}

fn start<T>(table: &Spanned<T>) -> usize {
    table.span().start
}

fn find(scenario: &Scenario, name: &str) -> Outcome<NodeId> {
    scenario.node(name).map(|(id, _)| id).ok_or_else(|| {
        format!("no node \"{name}\", there are: {}", scenario.node_names().join(", "))
    })
}
