//! A listener that hears a sole sender: whose bits it reads is known, only when is not.

use canbaud::wire::Level;

use super::alone::Change;
use super::core::Node;
use super::late::Samples;
use super::protocol::Score;
use crate::bus::EdgeLog;
use crate::event::{Sample, SampleRun};
use crate::time::Time;

impl Node {
    /// Reads what a sole sender sends before `limit`: `changes`, the first of which is edge `number`
    /// of `log`.
    ///
    /// False if the node reads anything else than what is sent, or if something comes of it; it is
    /// of no use then until it has gone back.
    pub(crate) fn follow<S: Samples>(
        &mut self,
        score: &Score,
        changes: &[Change],
        number: u64,
        limit: Time,
        log: &EdgeLog,
        samples: &mut S,
    ) -> bool {
        let Some(first) = changes.first() else { return false };
        // What came before the first change.
        if self.is_deaf() || self.read_up_to(first.star, log, samples).is_some() {
            return false;
        }
        let Some(mut bit) = self.protocol.in_step(score) else { return false };
        if !self.rxd.has_come_to(number) {
            return false;
        }
        let (mut level, mut come) = (first.to.toggled(), number);
        for change in changes {
            let at = self.rxd.arrival_of(come, change.star, change.to);
            if at >= limit {
                break;
            }
            // The edge begins the bit that it begins at the sender.
            let Some(bits) = change.bit.checked_sub(bit) else { return false };
            if !self.sample_before(at, bits, level, samples) {
                return false;
            }
            bit = change.bit;
            level = change.to;
            come += 1;
            if level == Level::Dominant && !self.synchronised {
                self.meet(at, bits);
            }
        }
        self.rxd.come_to(come, level);
        let before = self.bit.sample();
        let bits = self.bit.pass(limit);
        if S::WANTED && bits > 0 {
            let last = self.bit.origin().time();
            samples.take(SampleRun { first: before, last, bits, sample: heard(level) });
        }
        let last = bit + bits;
        if before < limit {
            self.synchronised = level == Level::Dominant;
        }
        if !score.has(level, bit..last) || !self.protocol.keep_step(score, last) {
            return false;
        }
        self.end_reading(log);
        true
    }

    /// An edge to dominant comes in, `bits` bits after the last one.
    #[inline]
    fn meet(&mut self, at: Time, bits: u32) {
        if bits > 0 && self.bit.edge_in_sync_seg(at) {
            self.corners.in_sync_seg += 1;
            self.synchronised = true;
        } else {
            self.synchronise(at);
        }
    }

    /// Samples `bits` bits of `level`. False if they are not just those sampled before `at`.
    #[inline]
    fn sample_before<S: Samples>(
        &mut self,
        at: Time,
        bits: u32,
        level: Level,
        samples: &mut S,
    ) -> bool {
        if bits > 0 {
            let first = self.bit.sample();
            self.bit.skip(bits);
            if S::WANTED {
                let last = self.bit.origin().time();
                samples.take(SampleRun { first, last, bits, sample: heard(level) });
            }
            self.synchronised = level == Level::Dominant;
        }
        self.bit.origin().time() < at && at <= self.bit.sample()
    }
}

/// A sample of a listener.
const fn heard(level: Level) -> Sample {
    Sample { level, driven: Level::Recessive, busy: true }
}
