//! The polling loop that measures dominant levels with a CPU's timer [AP2925, measure.c].

use canbaud::wire::Level;

use crate::clock::{Clock, ClockError, Quantum, Tick};
use crate::time::Time;

/// A dominant level as the loop measured it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pulse {
    /// Timer ticks, one per CPU clock.
    pub ticks: u64,
}

/// Where the program is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// `JNB`: waits for the end of a dominant level that was there before.
    WaitRecessive,
    /// `JB`: waits for a dominant level.
    WaitDominant,
    /// `JNB`: the timer runs.
    Measure { since: u64 },
}

/// A CPU that looks at RXD every few clocks.
///
/// It sees a level only at its polls, so a pulse measures long or short by up to one turn of the
/// loop; the tables of AP2925 have ranges for that.
#[derive(Debug, Clone)]
pub struct PollingLoop {
    clock: Clock,
    period: Quantum,
    /// CPU clocks of one turn of a wait loop.
    turn: u64,
    /// CPU clocks from the end of a pulse to the next poll.
    store: u64,
    state: State,
    /// The clock of the next poll.
    next: u64,
    level: Level,
}

impl PollingLoop {
    /// A loop of `turn` CPU clocks (C166: 4) at `hertz`, whose clock is `ppb` parts per billion
    /// fast, that spends `store` clocks on storing a result, and begins at clock `phase`.
    ///
    /// # Errors
    /// [`ClockError`] if there is no such clock.
    pub fn new(
        hertz: u64,
        ppb: i64,
        turn: u64,
        store: u64,
        phase: u64,
    ) -> Result<Self, ClockError> {
        let clock = Clock::new(hertz, ppb)?;
        Ok(Self {
            period: clock.quantum(1),
            clock,
            turn: turn.max(1),
            store,
            state: State::WaitRecessive,
            next: phase,
            level: Level::Recessive,
        })
    }

    /// An edge of RXD, in the order of time. Returns the pulse that the loop has measured before
    /// it, if it has.
    pub fn edge(&mut self, at: Time, level: Level) -> Option<Pulse> {
        // Polls up to and including the one at `from` see the level before the edge.
        let from = self.clock.locate(Tick::default(), &self.period, at);
        let pulse = self.poll_until(from);
        self.level = level;
        pulse
    }

    /// The level has not changed up to clock `until`.
    fn poll_until(&mut self, until: u64) -> Option<Pulse> {
        let mut pulse = None;
        while self.next <= until {
            match (self.state, self.level) {
                (State::WaitRecessive, Level::Recessive) => {
                    self.state = State::WaitDominant;
                    self.next += self.turn;
                }
                (State::WaitDominant, Level::Dominant) => {
                    self.state = State::Measure { since: self.next };
                    self.next += self.turn;
                }
                (State::Measure { since }, Level::Recessive) => {
                    pulse = Some(Pulse { ticks: self.next - since });
                    self.state = State::WaitRecessive;
                    self.next += self.store.max(1);
                }
                // It goes on waiting, in whole turns.
                _ => self.next += (until - self.next) / self.turn * self.turn + self.turn,
            }
        }
        pulse
    }

    /// The bus stays as it is up to `time`; returns a pulse that ends by then.
    pub fn rest(&mut self, time: Time) -> Option<Pulse> {
        let until = self.clock.locate(Tick::default(), &self.period, time);
        self.poll_until(until)
    }
}
