//! Reading many bits at once: bits that nothing comes of but that they have been read.

use canbaud::wire::Level;

use super::bit_time::Position;
use super::core::Node;
use super::corners::SyncCorners;
use super::protocol::Reading;
use super::sampling::Rxd;
use crate::bus::EdgeLog;
use crate::event::{Sample, SampleRun};
use crate::time::Time;

/// Takes the samples of bits that are read many at a time.
pub(crate) trait Samples {
    /// Whether anybody looks at them.
    const WANTED: bool;

    /// The bits that come next.
    fn take(&mut self, run: SampleRun);

    /// All that were taken are to be taken again.
    fn forget(&mut self);
}

/// No edge ever comes in.
const SILENCE: (Time, Level) = (Time::NEVER, Level::Recessive);

/// Nobody looks.
pub(crate) struct Unseen;

impl Samples for Unseen {
    const WANTED: bool = false;

    #[inline]
    fn take(&mut self, _: SampleRun) {}

    fn forget(&mut self) {}
}

impl Samples for Vec<SampleRun> {
    const WANTED: bool = true;

    fn take(&mut self, run: SampleRun) {
        self.push(run);
    }

    fn forget(&mut self) {
        self.clear();
    }
}

/// What reading changes in a node, as it was before.
#[derive(Debug, Clone)]
pub(crate) struct Before {
    position: Position,
    rxd: Rxd,
    reading: Reading,
    synchronised: bool,
    edge_at: Time,
    corners: SyncCorners,
}

impl Node {
    /// Allows or forbids late reading; the node has to be up to date.
    pub(crate) fn set_late_reading(&mut self, allowed: bool) {
        if self.late_reading != allowed {
            self.late_reading = allowed;
            self.schedule();
        }
    }

    /// Reads what came in before `now` and was not looked at; a sample at `now` itself may be more
    /// than a quiet one and stays due.
    pub(crate) fn catch_up(&mut self, now: Time, log: &EdgeLog) {
        if self.next > self.due {
            let stopped = self.read(now, log, &mut Unseen);
            debug_assert_eq!(stopped, None);
        }
    }

    /// Whether nothing can come of this node, unless it reads something.
    pub(crate) fn only_listens(&self) -> bool {
        self.txd == Level::Recessive
            && self.change_at == Time::NEVER
            && self.forced_rxd.is_none()
            && (self.synchronised || self.waits_for_edge())
            && self.protocol.listens()
    }

    /// Whether nothing can come of this node, whatever happens on the bus.
    pub(crate) fn is_out_of_it(&self) -> bool {
        self.due == Time::NEVER && self.is_deaf()
    }

    /// What [`Node::read`] may change, to be kept.
    pub(crate) fn before(&self) -> Before {
        Before {
            position: self.bit.position(),
            rxd: self.rxd.clone(),
            reading: self.protocol.reading(),
            synchronised: self.synchronised,
            edge_at: self.edge_at,
            corners: self.corners,
        }
    }

    /// Back to where it was before it read.
    pub(crate) fn go_back(&mut self, before: Before) {
        self.bit.go_back(before.position);
        self.rxd = before.rxd;
        self.protocol.read_anew(before.reading);
        self.synchronised = before.synchronised;
        self.edge_at = before.edge_at;
        self.corners = before.corners;
        self.schedule();
    }

    /// Reads all bits sampled before `limit`, as long as nothing comes of them.
    ///
    /// Returns the sample point of the first bit of which something does; the node is of no use
    /// then until it has gone back.
    pub(crate) fn read<S: Samples>(
        &mut self,
        limit: Time,
        log: &EdgeLog,
        samples: &mut S,
    ) -> Option<Time> {
        let stopped = self.read_up_to(limit, log, samples);
        if stopped.is_none() {
            self.end_reading(log);
        }
        stopped
    }

    /// [`Node::read`] without its end: [`Node::end_reading`] is still to be done.
    #[inline]
    pub(super) fn read_up_to<S: Samples>(
        &mut self,
        limit: Time,
        log: &EdgeLog,
        samples: &mut S,
    ) -> Option<Time> {
        let (busy, driven) = (self.protocol.is_busy(), Level::Recessive);
        let mut coming = if self.is_deaf() { SILENCE } else { self.rxd.coming(log) };
        loop {
            let sample_at = self.bit.sample();
            let next = coming.0.min(sample_at);
            if next >= limit {
                break;
            }
            if coming.0 <= sample_at {
                coming = self.let_in(coming, log);
                // A pulse that the asymmetry eats up is no edge.
                if self.rxd.level() == Level::Dominant && !self.synchronised {
                    self.synchronise(next);
                }
                continue;
            }
            let level = if self.is_deaf() { Level::Recessive } else { self.rxd.level() };
            let from = self.bit.sample_tick();
            let bits = self.bit.pass(coming.0.min(limit));
            if S::WANTED && bits > 0 {
                let last = self.bit.origin().time();
                let sample = Sample { level, driven, busy };
                samples.take(SampleRun { first: sample_at, last, bits, sample });
            }
            let quiet = self.protocol.read_quiet(level, bits);
            if quiet < bits {
                return Some(self.bit.bits_after(from, quiet).time());
            }
            self.synchronised = level == Level::Dominant;
        }
        None
    }

    /// Looks for what comes next.
    pub(super) fn end_reading(&mut self, log: &EdgeLog) {
        self.edge_at = Time::NEVER;
        if !self.synchronised {
            self.look_for_edge(log);
        }
        self.schedule();
    }

    /// The edge that is coming comes in, with those that it has overtaken. Returns the next one.
    #[inline]
    fn let_in(&mut self, coming: (Time, Level), log: &EdgeLog) -> (Time, Level) {
        let (at, mut level) = coming;
        loop {
            self.rxd.come_in(level);
            let next = self.rxd.coming(log);
            if next.0 > at {
                return next;
            }
            level = next.1;
        }
    }
}
