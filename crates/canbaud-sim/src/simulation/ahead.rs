//! Computing ahead: while one node alone sends and all others listen, what it sends is known up to
//! the end of the CRC field. Each listener then reads it in one go.
//!
//! Should something come of what a listener reads (an error, say), the time up to which all is
//! computed ends there, and what was computed beyond is taken back.

use super::Simulation;
use crate::bus::EdgeLog;
use crate::event::{NodeId, Observer, SampleRun, Sampling};
use crate::node::{Before, Change, Node, Plan, Samples, Score, Unseen};
use crate::time::{Span, Time};

/// What a run computes ahead with, kept to be used again.
#[derive(Debug, Default)]
pub(super) struct Ahead {
    changes: Vec<Change>,
    /// Listeners, and what they were before they read.
    listeners: Vec<(usize, Before)>,
    /// What each node sampled, if the observer wants to know.
    samples: Vec<Vec<SampleRun>>,
    /// The listener that read something last time that came to something: it reads first.
    suspect: usize,
    /// Not again before this time.
    not_before: Time,
}

impl Simulation {
    /// Computes ahead if the node at `place`, which has just sampled a bit, is a sole sender.
    /// True if it did.
    pub(super) fn compute_ahead<O: Observer>(
        &mut self,
        place: usize,
        until: Time,
        observer: &mut O,
    ) -> bool {
        let alone = self.now >= self.ahead.not_before
            && self.line.belongs_to(self.drivers[place])
            && self.note_listeners(place);
        if !alone {
            return false;
        }
        let entry = self.agenda.peek().map_or(Time::NEVER, |entry| entry.0.at);
        let mut limit = entry.min(until + Span::from_fs(1));
        let head = self.line.log.head();
        loop {
            self.ahead.changes.clear();
            let plan =
                self.nodes[place].plan_alone(limit, &mut self.line.log, &mut self.ahead.changes);
            let Some(plan) = plan else {
                self.refresh_all();
                return false;
            };
            let score = self.nodes[place].score(&plan);
            match self.listen::<O>(plan.end(), &score, head) {
                None => {
                    self.follow::<O>(place, plan, observer);
                    return true;
                }
                Some(trouble) => {
                    self.line.log.take_back(head);
                    self.ahead.not_before = trouble;
                    limit = trouble;
                }
            }
        }
    }

    /// Whether all but the node at `place` listen or are out of it.
    fn note_listeners(&mut self, place: usize) -> bool {
        let passive = |node: &Node| node.only_listens() || node.is_out_of_it();
        let mut others = self.nodes.iter().enumerate().filter(|(other, _)| *other != place);
        if !others.all(|(_, node)| passive(node)) {
            return false;
        }
        self.ahead.listeners.clear();
        let (after, first) = (self.ahead.suspect..self.nodes.len(), 0..self.ahead.suspect);
        for other in after.chain(first) {
            let node = &self.nodes[other];
            if other != place && node.only_listens() {
                self.ahead.listeners.push((other, node.before()));
            }
        }
        true
    }

    /// Lets all listeners read up to `end`. Returns when something comes of it before that; all
    /// are back where they were then.
    fn listen<O: Observer>(&mut self, end: Time, score: &Score, head: u64) -> Option<Time> {
        if O::SAMPLING == Sampling::InRuns {
            self.ahead.samples.resize_with(self.nodes.len(), Vec::new);
            self.ahead.samples.iter_mut().for_each(Vec::clear);
        }
        for (index, (place, before)) in self.ahead.listeners.iter().enumerate() {
            let node = &mut self.nodes[*place];
            let heard =
                Heard { score, changes: &self.ahead.changes, head, end, log: &self.line.log };
            let trouble = if O::SAMPLING == Sampling::InRuns {
                heard.by(node, before, &mut self.ahead.samples[*place])
            } else {
                heard.by(node, before, &mut Unseen)
            };
            if trouble.is_some() {
                self.ahead.suspect = *place;
                for (place, before) in &self.ahead.listeners[..=index] {
                    self.nodes[*place].go_back(before.clone());
                }
                return trouble;
            }
        }
        None
    }

    /// Everything went as planned.
    fn follow<O: Observer>(&mut self, place: usize, plan: Plan, observer: &mut O) {
        let end = plan.end();
        let node = &mut self.nodes[place];
        if O::SAMPLING == Sampling::InRuns {
            node.send_alone(plan, &self.line.log, &mut self.ahead.samples[place]);
        } else {
            node.send_alone(plan, &self.line.log, &mut Unseen);
        }
        self.line.brought_to(self.drivers[place], node.txd());
        for (node, next) in self.nodes.iter().zip(&mut self.next) {
            *next = node.next();
        }
        self.steps += self.ahead.changes.len() as u64;
        self.tell(place, observer);
        self.now = self.now.max(end - Span::from_fs(1));
    }

    /// Tells the observer what happened: changes in the order in which they did, then what the
    /// nodes sampled of them.
    fn tell<O: Observer>(&self, sender: usize, observer: &mut O) {
        for change in &self.ahead.changes {
            observer.txd(change.at, NodeId(sender), change.to);
            observer.bus(change.star, change.to);
        }
        if O::SAMPLING == Sampling::InRuns {
            for (place, runs) in self.ahead.samples.iter().enumerate() {
                runs.iter().for_each(|run| observer.samples(NodeId(place), run));
            }
        }
    }
}

/// What there is to hear of a sole sender.
struct Heard<'a> {
    score: &'a Score,
    changes: &'a [Change],
    /// The edge of the log that the first change makes.
    head: u64,
    end: Time,
    log: &'a EdgeLog,
}

impl Heard<'_> {
    /// Lets a listener read it, as quickly as can be. Returns when something comes of it.
    fn by<S: Samples>(&self, node: &mut Node, before: &Before, samples: &mut S) -> Option<Time> {
        if node.follow(self.score, self.changes, self.head, self.end, self.log, samples) {
            return None;
        }
        samples.forget();
        node.go_back(before.clone());
        node.read(self.end, self.log, samples)
    }
}
