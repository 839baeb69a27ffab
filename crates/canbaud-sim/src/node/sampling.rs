//! The RXD pin: which edges have come in, which are under way, and the secondary sample point.

use std::collections::VecDeque;

use canbaud::wire::Level;

use crate::bus::{EdgeLog, Transceiver};
use crate::time::Time;

/// RXD as seen up to some instant.
#[derive(Debug, Clone)]
pub(crate) struct Rxd {
    transceiver: Transceiver,
    /// Part of the lot that decides on jitter.
    salt: u64,
    cursor: u64,
    level: Level,
}

impl Rxd {
    /// RXD from now on, the bus being at `level`.
    pub(crate) const fn new(
        transceiver: Transceiver,
        salt: u64,
        log: &EdgeLog,
        level: Level,
    ) -> Self {
        Self { transceiver, salt, cursor: log.head(), level }
    }

    #[inline]
    fn arrival(&self, log: &EdgeLog, number: u64) -> Option<(Time, Level)> {
        let edge = log.get(number)?;
        let lot = self.salt ^ number;
        Some((self.transceiver.to_rxd(edge.at, edge.to, lot), edge.to))
    }

    /// The level at `time`; times must not go back.
    #[inline]
    pub(crate) fn level_at(&mut self, log: &EdgeLog, time: Time) -> Level {
        if self.cursor < log.oldest() {
            self.skip_forgotten(log);
        }
        while self.cursor < log.head() {
            let Some((at, to)) = self.arrival(log, self.cursor) else { break };
            if at > time {
                break;
            }
            self.level = to;
            self.cursor += 1;
        }
        self.level
    }

    #[cold]
    fn skip_forgotten(&mut self, log: &EdgeLog) {
        self.cursor = log.oldest();
        if let Some(edge) = log.get(self.cursor) {
            self.level = edge.to.toggled();
        }
    }

    /// The level that the last [`Rxd::level_at`] returned.
    #[inline]
    pub(crate) const fn level(&self) -> Level {
        self.level
    }

    /// The next edge to come in: when, and the level after it. One whose time is over comes in at
    /// once: it was overtaken by a later edge.
    #[inline]
    pub(crate) fn coming(&mut self, log: &EdgeLog) -> (Time, Level) {
        if self.cursor < log.oldest() {
            self.skip_forgotten(log);
        }
        self.arrival(log, self.cursor).unwrap_or((Time::NEVER, self.level))
    }

    /// The edge that was coming, to `level`, has come in.
    #[inline]
    pub(crate) fn come_in(&mut self, level: Level) {
        self.level = level;
        self.cursor += 1;
    }

    /// Whether every edge that has left the star point has come in by the last
    /// [`Rxd::level_at`].
    #[inline]
    pub(crate) const fn is_settled(&self, log: &EdgeLog) -> bool {
        self.cursor == log.head()
    }

    /// When edge `number`, at the star point at `at`, comes in.
    #[inline]
    pub(crate) fn arrival_of(&self, number: u64, at: Time, to: Level) -> Time {
        self.transceiver.to_rxd(at, to, self.salt ^ number)
    }

    /// Whether all edges before edge `number` have come in, and no other one.
    pub(crate) const fn has_come_to(&self, number: u64) -> bool {
        self.cursor == number
    }

    /// All edges before edge `number` have come in; the last one was to `level`.
    pub(crate) const fn come_to(&mut self, number: u64, level: Level) {
        self.cursor = number;
        self.level = level;
    }

    /// When the next recessive to dominant edge after the last [`Rxd::level_at`] comes in, of
    /// those that have left the star point. A pulse that the asymmetry eats up does not count.
    #[inline]
    pub(crate) fn next_dominant(&self, log: &EdgeLog) -> Time {
        if self.cursor == log.head() { Time::NEVER } else { self.find_dominant(log) }
    }

    fn find_dominant(&self, log: &EdgeLog) -> Time {
        let mut number = self.cursor.max(log.oldest());
        let mut latest = Time::ZERO;
        while let Some((at, to)) = self.arrival(log, number) {
            if to == Level::Dominant {
                // It does not come in before a pulse that was eaten up before it.
                let at = at.max(latest);
                latest = at;
                match self.arrival(log, number + 1) {
                    Some((end, _)) if end <= at => {}
                    Some(_) | None => return at,
                }
            }
            number += 1;
        }
        Time::NEVER
    }
}

/// A bit of the data phase that waits for its check.
#[derive(Debug, Clone, Copy)]
struct Sent {
    check_at: Time,
    level: Level,
}

/// Transmitter delay compensation: sent bits are checked at a secondary sample point.
#[derive(Debug, Clone)]
pub(crate) struct SecondarySampling {
    rxd: Rxd,
    waiting: VecDeque<Sent>,
}

impl SecondarySampling {
    /// From the start of a data phase on; `rxd` as it is at the sample point before.
    pub(crate) fn new(rxd: Rxd) -> Self {
        Self { rxd, waiting: VecDeque::new() }
    }

    pub(crate) fn sent(&mut self, level: Level, check_at: Time) {
        self.waiting.push_back(Sent { check_at, level });
    }

    /// Checks all bits that were due by `now`; true if one came back with the other level.
    pub(crate) fn finds_error(&mut self, log: &EdgeLog, now: Time) -> bool {
        let mut found = false;
        while let Some(sent) = self.waiting.front().filter(|sent| sent.check_at <= now) {
            found |= self.rxd.level_at(log, sent.check_at) != sent.level;
            self.waiting.pop_front();
        }
        found
    }
}
