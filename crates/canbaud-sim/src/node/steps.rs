//! One event of a node after the other: edges, changes of TXD, sample points.

use canbaud::wire::Level;

use super::bit_time::Rate;
use super::config::Tdc;
use super::core::Node;
use super::late::Unseen;
use super::protocol::Quiet;
use super::sampling::SecondarySampling;
use crate::bus::EdgeLog;
use crate::event::Sample;
use crate::time::Time;

/// What the bus has to do after a step of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// Nothing.
    Quiet,
    /// TXD changed.
    Txd(Level),
    /// A bit was sampled.
    Sampled(Sample),
}

impl Node {
    #[inline]
    pub(super) fn schedule(&mut self) {
        self.note_due();
        self.next = self.due;
        self.heeds_edges = true;
        if !self.late_reading || self.change_at != Time::NEVER || self.forced_rxd.is_some() {
            return;
        }
        match self.protocol.quiet() {
            Quiet::Anyway(0) | Quiet::WhileRecessive(0) => {}
            Quiet::Anyway(bits) => {
                if let Some(later) = self.bit.before_sample(bits).filter(|at| *at > self.due) {
                    self.next = later;
                    self.heeds_edges = false;
                }
            }
            Quiet::WhileRecessive(bits) => {
                // The last sample was recessive, and no edge is on its way.
                let still = self.waits_for_edge() && self.edge_at == Time::NEVER;
                if still && self.config.hears_bus() {
                    self.next = self.bit.sample_after(bits);
                }
            }
        }
    }

    #[inline]
    fn note_due(&mut self) {
        let own = if self.change_at != Time::NEVER {
            self.change_at
        } else if self.protocol.sleeps() {
            Time::NEVER
        } else {
            self.bit.sample()
        };
        self.due = own.min(self.edge_at);
    }

    /// An edge to dominant is on its way from the star point. True if that changes when the node
    /// has to be looked at.
    #[inline]
    pub(crate) fn notice_edge(&mut self, now: Time, log: &EdgeLog) -> bool {
        if !self.heeds_edges || self.synchronised || self.edge_at != Time::NEVER {
            return false;
        }
        self.catch_up(now, log);
        if self.edge_at == Time::NEVER {
            self.look_for_edge(log);
            self.due = self.due.min(self.edge_at);
            self.next = self.due;
        }
        true
    }

    #[inline]
    pub(super) fn look_for_edge(&mut self, log: &EdgeLog) {
        self.edge_at = if self.is_deaf() { Time::NEVER } else { self.rxd.next_dominant(log) };
    }

    /// Whether the next edge to dominant synchronises. A node that was set up while the bus was
    /// dominant does not know yet.
    #[inline]
    pub(super) fn waits_for_edge(&self) -> bool {
        !self.synchronised && self.rxd.level() == Level::Recessive
    }

    /// Whether no edge on the bus reaches it.
    #[inline]
    pub(super) fn is_deaf(&self) -> bool {
        self.forced_rxd.is_some() || !self.config.hears_bus() || self.protocol.is_off()
    }

    /// The node's next event has come.
    #[inline]
    pub(crate) fn step(&mut self, now: Time, log: &EdgeLog) -> Step {
        if self.due < now {
            self.read(now, log, &mut Unseen);
            if self.next > now {
                return Step::Quiet;
            }
        }
        if self.edge_at <= now {
            self.take_edge(now, log);
            Step::Quiet
        } else if self.change_at <= now {
            self.change_txd(now)
        } else {
            self.take_sample(now, log)
        }
    }

    fn change_txd(&mut self, now: Time) -> Step {
        self.txd = self.protocol.drive();
        self.txd_changed = now;
        self.change_at = Time::NEVER;
        self.schedule();
        Step::Txd(self.txd)
    }

    fn take_edge(&mut self, now: Time, log: &EdgeLog) {
        // The pulse may have been eaten up since.
        if self.forced_rxd.is_none() && self.rxd.level_at(log, now) == Level::Recessive {
            self.look_for_edge(log);
            self.schedule();
            return;
        }
        self.edge_at = Time::NEVER;
        self.synchronise(now);
        self.schedule();
    }

    pub(super) fn synchronise(&mut self, now: Time) {
        self.synchronised = true;
        if self.protocol.is_transmitting() && self.protocol.is_at_res() {
            self.loop_delay = now.since(self.txd_changed);
        }
        let rule = self.protocol.sync_rule(self.txd);
        let (outcome, position) = self.bit.edge(now, rule);
        self.corners.note(outcome, self.bit.sjw());
        if self.change_at != Time::NEVER {
            self.change_at = self.bit.change_after_edge(position);
        }
        self.protocol.wake();
    }

    fn take_sample(&mut self, now: Time, log: &EdgeLog) -> Step {
        let rxd = match self.forced_rxd {
            Some(forced) => forced,
            None if self.config.hears_bus() => self.rxd.level_at(log, now),
            None => Level::Recessive,
        };
        let level = self.config.controller_rxd(self.txd, rxd);
        let late_error = self.secondary.as_mut().map(|s| s.finds_error(log, now));
        let driven = self.txd;
        self.protocol.sample(level, late_error);
        self.bit.advance(self.protocol.rate());
        self.secondary_sampling();
        if self.protocol.drive() != self.txd {
            self.change_at = self.bit.start();
        }
        self.synchronised = level == Level::Dominant;
        self.edge_at = Time::NEVER;
        if !self.synchronised {
            self.look_for_edge(log);
        }
        self.schedule();
        Step::Sampled(Sample { level, driven, busy: self.protocol.is_busy() })
    }

    /// Follows the data phase of a transmitter with TDC: the bit that begins next is to be checked
    /// at the secondary sample point.
    fn secondary_sampling(&mut self) {
        let Tdc::Offset(offset) = self.config.tdc else { return };
        if self.bit.rate() == Rate::Nominal || !self.protocol.is_transmitting() {
            self.secondary = None;
            return;
        }
        let check_at = self.bit.quanta_after(self.bit.start() + self.loop_delay, offset);
        let secondary =
            self.secondary.get_or_insert_with(|| SecondarySampling::new(self.rxd.clone()));
        secondary.sent(self.protocol.drive(), check_at);
    }
}
