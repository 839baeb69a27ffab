//! A sender that alone drives the bus: what it does until somebody else may act is known at once.

use canbaud::wire::Level;

use super::bit_time::{Rate, SyncOutcome};
use super::config::{Gate, Mode, Tdc};
use super::core::Node;
use super::corners::SyncCorners;
use super::late::Samples;
use super::protocol::{Alone, Score};
use crate::bus::{Edge, EdgeLog};
use crate::clock::Tick;
use crate::event::{Sample, SampleRun};
use crate::time::{Span, Time};

/// Bits before the CRC delimiter that are not planned: receivers may be ahead of the sender, and
/// with the CRC delimiter they decide on the acknowledgement.
const MARGIN: u32 = 1;
/// Fewer bits are not worth a plan.
const LEAST: u32 = 4;

/// A change of TXD.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    pub(crate) at: Time,
    /// When it reaches the star point.
    pub(crate) star: Time,
    pub(crate) to: Level,
    /// The bit that it begins, counted from SOF.
    pub(crate) bit: u32,
}

/// What the sender does before its sample point [`Plan::end`].
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    alone: Alone,
    /// Bits that are sampled.
    bits: u32,
    /// The last sample point before the end.
    last: Tick,
    end: Tick,
    corners: SyncCorners,
    last_sync: Option<SyncOutcome>,
    txd_changed: Time,
}

impl Plan {
    /// Everything before this time is planned.
    pub(crate) const fn end(&self) -> Time {
        self.end.time()
    }
}

impl Node {
    /// Whether the node, just after one of its sample points, finds all that it sends on its own
    /// RXD before the next one, and no edge moves its bits.
    fn hears_itself_in_time(&self) -> bool {
        let config = &self.config;
        let plain = config.mode == Mode::Normal && config.gate == Gate::Absent;
        let compensates = self.bit.rate() == Rate::Data && config.tdc != Tdc::Off;
        plain
            && config.can_drive()
            && !compensates
            && self.forced_rxd.is_none()
            && self.edge_at == Time::NEVER
            && config.transceiver.shortest_way_out() > Span::ZERO
            && config.transceiver.longest_loop() < self.bit.least_to_sample()
    }

    /// What the node sends from its last sample point on, until `limit` or the end of the CRC
    /// field, if nobody else drives the bus. Its edges go to `log`, and to `changes` with the
    /// changes of TXD that make them.
    pub(crate) fn plan_alone(
        &self,
        limit: Time,
        log: &mut EdgeLog,
        changes: &mut Vec<Change>,
    ) -> Option<Plan> {
        let (alone, left) = self.protocol.alone()?;
        if left < MARGIN + LEAST || !self.hears_itself_in_time() || !self.rxd.is_settled(log) {
            return None;
        }
        let origin = self.bit.origin();
        // The bit of whose sample point the end is made is begun, but not sampled.
        let most = self.bit.bits_until(origin, limit).saturating_sub(1);
        let most = u64::from(left - MARGIN).min(most) as u32;
        if most < LEAST {
            return None;
        }
        let head = log.head();
        self.plan_bits(alone.clone(), most, log, changes)
            .or_else(|quiet| {
                // A node without CAN FD sends what it cannot read back itself.
                log.take_back(head);
                changes.clear();
                self.plan_bits(alone, quiet, log, changes)
            })
            .ok()
    }

    /// A plan for so many bits, or how many of them nothing comes of.
    fn plan_bits(
        &self,
        alone: Alone,
        most: u32,
        log: &mut EdgeLog,
        changes: &mut Vec<Change>,
    ) -> Result<Plan, u32> {
        let mut plan = Plan {
            alone,
            bits: 0,
            last: self.bit.origin(),
            end: self.bit.origin(),
            corners: self.corners,
            last_sync: self.bit.last_sync(),
            txd_changed: self.txd_changed,
        };
        let mut txd = self.txd;
        loop {
            let (level, run) = self.protocol.run_of(&plan.alone);
            if level != txd {
                changes.push(self.plan_change(&mut plan, level, log));
                txd = level;
            }
            let run = run.min(most - plan.bits);
            if run == 0 {
                break;
            }
            let quiet = plan.alone.read_back(level, run);
            plan.bits += quiet;
            if quiet < run {
                return Err(plan.bits);
            }
            plan.last = self.bit.bits_after(plan.last, run);
        }
        plan.end = self.bit.bits_after(plan.last, 1);
        Ok(plan)
    }

    /// TXD changes at the start of the next bit.
    fn plan_change(&self, plan: &mut Plan, to: Level, log: &mut EdgeLog) -> Change {
        let start = self.bit.start_after(plan.last);
        let at = start.time();
        let star = self.config.transceiver.to_star(at, to);
        if to == Level::Dominant {
            // It comes in during the same bit: a positive phase error or none.
            let arrival = self.rxd.arrival_of(log.head(), star, to);
            let in_sync_seg = self.bit.rate() == Rate::Nominal
                && arrival < self.bit.end_of_sync_seg(start).time();
            let outcome = if in_sync_seg { SyncOutcome::InSyncSeg } else { SyncOutcome::Ignored };
            plan.corners.note(outcome, 0);
            plan.last_sync = Some(outcome);
        }
        plan.txd_changed = at;
        log.push(Edge { at: star, to });
        Change { at, star, to, bit: plan.alone.bit() }
    }

    /// The bits of a plan, for those who listen.
    pub(crate) fn score(&self, plan: &Plan) -> Score {
        self.protocol.score(&plan.alone)
    }

    fn tell_plan<S: Samples>(&self, plan: &Plan, samples: &mut S) {
        let (mut tick, mut bit) = (self.bit.origin(), 0);
        while bit < plan.bits {
            let level = self.protocol.level_ahead(bit);
            let equal = |bit: &u32| self.protocol.level_ahead(*bit) == level;
            let bits = (bit..plan.bits).take_while(equal).fold(0, |count, _| count + 1);
            let first = self.bit.bits_after(tick, 1).time();
            tick = self.bit.bits_after(tick, bits);
            let sample = Sample { level, driven: level, busy: true };
            samples.take(SampleRun { first, last: tick.time(), bits, sample });
            bit += bits;
        }
    }

    /// Does what was planned; `log` has the edges still.
    pub(crate) fn send_alone<S: Samples>(&mut self, plan: Plan, log: &EdgeLog, samples: &mut S) {
        if S::WANTED {
            self.tell_plan(&plan, samples);
        }
        self.bit.go_by(plan.last, plan.end, plan.last_sync);
        self.corners = plan.corners;
        let sampled = self.protocol.go_on_from(plan.alone);
        self.txd = self.protocol.drive();
        self.txd_changed = plan.txd_changed;
        self.change_at = Time::NEVER;
        self.synchronised = sampled == Level::Dominant || self.txd == Level::Dominant;
        self.rxd.come_to(log.head(), self.txd);
        self.schedule();
    }
}
