//! The star point: who drives it, and what is under way to it.

use canbaud::wire::Level;

use super::log::{Edge, EdgeLog};
use crate::time::Time;

/// A change that is on its way to the star point.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    at: Time,
    driver: usize,
    to: Level,
}

/// The line at the star point.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    /// Level of each driver: nodes first, then what disturbances have added.
    drivers: Vec<Level>,
    dominant: usize,
    /// While above 0 the line is recessive whatever is driven: shorted or open.
    shorted: usize,
    under_way: Vec<Arrival>,
    level: Level,
    pub(crate) log: EdgeLog,
}

impl Line {
    pub(crate) fn new() -> Self {
        Self {
            drivers: Vec::new(),
            dominant: 0,
            shorted: 0,
            under_way: Vec::new(),
            level: Level::Recessive,
            log: EdgeLog::new(),
        }
    }

    /// A new driver; returns its number.
    pub(crate) fn add_driver(&mut self) -> usize {
        self.drivers.push(Level::Recessive);
        self.drivers.len() - 1
    }

    pub(crate) const fn level(&self) -> Level {
        self.level
    }

    /// A change that reaches the star point at `at`. One that overtakes an earlier change of the
    /// same driver eats it up.
    pub(crate) fn send(&mut self, at: Time, driver: usize, to: Level) {
        let overtaken = self.under_way.iter().position(|a| a.driver == driver && a.at >= at);
        if let Some(place) = overtaken {
            self.under_way.remove(place);
            return;
        }
        let place = self.under_way.iter().position(|a| a.at <= at).unwrap_or(self.under_way.len());
        self.under_way.insert(place, Arrival { at, driver, to });
    }

    /// Everything that `driver` has under way is lost, and it is recessive: it was cut off.
    pub(crate) fn cut(&mut self, now: Time, driver: usize) {
        self.under_way.retain(|a| a.driver != driver);
        self.send(now, driver, Level::Recessive);
    }

    /// When the next change arrives.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        self.under_way.last().map_or(Time::NEVER, |arrival| arrival.at)
    }

    /// Takes the next arrival; returns the edge if the line changed.
    pub(crate) fn arrive(&mut self) -> Option<Edge> {
        let arrival = self.under_way.pop()?;
        let driver = &mut self.drivers[arrival.driver];
        match (*driver, arrival.to) {
            (Level::Recessive, Level::Dominant) => self.dominant += 1,
            (Level::Dominant, Level::Recessive) => self.dominant -= 1,
            (Level::Dominant, Level::Dominant) | (Level::Recessive, Level::Recessive) => {}
        }
        *driver = arrival.to;
        self.settle(arrival.at)
    }

    /// Shorts the line to recessive.
    pub(crate) fn short(&mut self, now: Time) -> Option<Edge> {
        self.shorted += 1;
        self.settle(now)
    }

    /// Takes one short away.
    pub(crate) fn unshort(&mut self, now: Time) -> Option<Edge> {
        self.shorted = self.shorted.saturating_sub(1);
        self.settle(now)
    }

    /// Whether nobody but `driver` drives the line, and nothing is under way.
    pub(crate) fn belongs_to(&self, driver: usize) -> bool {
        let own = usize::from(self.drivers[driver] == Level::Dominant);
        self.under_way.is_empty() && self.shorted == 0 && self.dominant == own
    }

    /// `driver`, to whom the line belongs, has brought it to `level`; the edges are in the log.
    pub(crate) fn brought_to(&mut self, driver: usize, level: Level) {
        self.drivers[driver] = level;
        self.dominant = usize::from(level == Level::Dominant);
        self.level = level;
    }

    fn settle(&mut self, at: Time) -> Option<Edge> {
        let level =
            if self.shorted == 0 && self.dominant > 0 { Level::Dominant } else { Level::Recessive };
        if level == self.level {
            return None;
        }
        self.level = level;
        let edge = Edge { at, to: level };
        self.log.push(edge);
        Some(edge)
    }
}
