//! The run: which event comes next.

use std::cmp::Reverse;

use canbaud::wire::Level;

use super::{Pace, Simulation, Stop};
use crate::event::{NodeId, Observer, Sampling, tell};
use crate::node::Step;
use crate::time::{Span, Time};

impl Simulation {
    /// Runs until `until`, or until a watched node has news.
    pub fn run<O: Observer>(&mut self, until: Time, observer: &mut O) -> Stop {
        let late = self.pace == Pace::Ahead && O::SAMPLING == Sampling::Untold;
        for node in &mut self.nodes {
            node.set_late_reading(late);
        }
        self.refresh_all();
        let stop = self.run_on(until, observer);
        // News may come before other events of the same time.
        let done = match stop {
            Stop::Reached => self.now + Span::from_fs(1),
            Stop::News => self.now,
        };
        for node in &mut self.nodes {
            node.catch_up(done, &self.line.log);
        }
        self.refresh_all();
        stop
    }

    pub(super) fn refresh_all(&mut self) {
        for (node, next) in self.nodes.iter().zip(&mut self.next) {
            *next = node.next();
        }
    }

    fn run_on<O: Observer>(&mut self, until: Time, observer: &mut O) -> Stop {
        loop {
            let (mut at, mut place, mut second) = (Time::NEVER, 0, Time::NEVER);
            for (index, &next) in self.next.iter().enumerate() {
                // Without a branch, which could not be foretold.
                second = second.min(next.max(at));
                place = if next < at { index } else { place };
                at = at.min(next);
            }
            let arrival = self.line.next();
            let entry = self.agenda.peek().map_or(Time::NEVER, |Reverse(entry)| entry.at);
            let first = at.min(arrival).min(entry);
            if first > until || first == Time::NEVER {
                self.now = self.now.max(until);
                return Stop::Reached;
            }
            self.now = first;
            self.steps += 1;
            if entry == first {
                self.act(observer);
            } else if arrival == first {
                second = second.min(self.arrive(observer));
                self.run_alone(place, second.min(entry), until, observer);
            } else if !self.step(place, until, observer) {
                self.run_alone(place, second.min(entry), until, observer);
            }
            if !self.news.is_empty() {
                return Stop::News;
            }
        }
    }

    /// Goes on with one node, and with what arrives at the star point, strictly before `horizon`:
    /// until then no other node has anything to do.
    #[inline]
    fn run_alone<O: Observer>(
        &mut self,
        place: usize,
        horizon: Time,
        until: Time,
        observer: &mut O,
    ) {
        let mut horizon = horizon.min(until);
        while self.news.is_empty() {
            let (next, arrival) = (self.next[place], self.line.next());
            let first = next.min(arrival);
            if first >= horizon {
                return;
            }
            self.now = first;
            self.steps += 1;
            if arrival <= next {
                horizon = horizon.min(self.arrive(observer));
            } else if self.step(place, until, observer) {
                return;
            }
        }
    }

    /// Something reaches the star point. Returns when the first of the nodes that heed it has to
    /// be looked at.
    fn arrive<O: Observer>(&mut self, observer: &mut O) -> Time {
        match self.line.arrive() {
            Some(edge) => self.after_edge(edge.at, edge.to, observer),
            None => Time::NEVER,
        }
    }

    /// The next event of the node at `place`. True if more than that was computed.
    #[inline]
    fn step<O: Observer>(&mut self, place: usize, until: Time, observer: &mut O) -> bool {
        let now = self.now;
        let node = &mut self.nodes[place];
        let step = node.step(now, &self.line.log);
        self.next[place] = node.next();
        match step {
            Step::Quiet => {}
            Step::Sampled(sample) => {
                tell(observer, now, NodeId(place), &sample);
            }
            Step::Txd(level) => self.drive(place, level, observer),
        }
        let node = &self.nodes[place];
        if node.has_events() {
            self.publish(place, observer);
            return false;
        }
        let sampled = matches!(step, Step::Sampled(_));
        sampled
            && self.pace == Pace::Ahead
            && O::SAMPLING != Sampling::InTime
            && self.nodes[place].is_transmitting()
            && self.compute_ahead(place, until, observer)
    }

    fn drive<O: Observer>(&mut self, place: usize, level: Level, observer: &mut O) {
        let config = self.nodes[place].config();
        if config.can_drive() {
            let at = config.transceiver.to_star(self.now, level);
            observer.txd(self.now, NodeId(place), level);
            self.line.send(at, self.drivers[place], level);
        }
    }

    #[cold]
    pub(super) fn publish<O: Observer>(&mut self, place: usize, observer: &mut O) {
        while let Some(event) = self.nodes[place].take_event() {
            observer.event(self.now, NodeId(place), &event);
            if self.watched[place] {
                self.news.push((self.now, NodeId(place), event));
            }
        }
    }

    pub(super) fn after_edge<O: Observer>(
        &mut self,
        at: Time,
        to: Level,
        observer: &mut O,
    ) -> Time {
        observer.bus(at, to);
        let mut first = Time::NEVER;
        if to == Level::Dominant {
            for (node, next) in self.nodes.iter_mut().zip(&mut self.next) {
                if node.notice_edge(at, &self.line.log) {
                    *next = node.next();
                    first = first.min(*next);
                }
            }
        }
        first
    }
}
