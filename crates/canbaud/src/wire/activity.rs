//! Cuts a stream of edges into stretches of bus activity, without glitches.

use super::line::Level;
use super::reader::{Activity, Rates};

/// Where the stream is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing has begun.
    Off,
    /// Recessive since this time.
    Idle { since: u64 },
    /// Between the first dominant edge and the gap; before it, recessive since this time.
    Active { idle_since: u64 },
}

/// How far what was before the activity is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Before {
    /// The recording began less than a bus idle condition before: perhaps in mid-frame.
    Unknown,
    /// Recessive for this many ticks.
    Gap(u32),
}

/// How the activity ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    Edge,
    Recording,
}

/// The runs of one stretch of activity, at most `N` of them.
#[derive(Debug, Clone)]
pub(crate) struct ActivityBuffer<const N: usize> {
    runs: [u32; N],
    len: usize,
    state: State,
    before: Before,
    ending: Ending,
    origin: u64,
    last: u64,
    level: Level,
    gap: u32,
    /// Recessive runs of at least this many ticks end an activity.
    gap_min: u32,
    /// Runs shorter than this are no bits of any node.
    run_min: u32,
    /// A first dominant run of at least this many ticks, this soon, is an overload flag.
    flag_min: u32,
    idle_min: u32,
}

impl<const N: usize> ActivityBuffer<N> {
    pub(crate) const fn new() -> Self {
        Self {
            runs: [0; N],
            len: 0,
            state: State::Off,
            before: Before::Unknown,
            ending: Ending::Edge,
            origin: 0,
            last: 0,
            level: Level::Recessive,
            gap: 0,
            gap_min: 0,
            run_min: 0,
            flag_min: 0,
            idle_min: 0,
        }
    }

    /// Derives all limits from the bit times.
    pub(crate) fn set_limits(&mut self, rates: &Rates) {
        let nominal = rates.nominal.ticks_q20();
        let shortest = rates.data.map_or(nominal, |data| data.clock.ticks_q20().min(nominal));
        // Longer than what stuffing and CRC delimiter allow (6), shorter than error delimiter (8).
        self.gap_min = ticks(nominal, 15, 2);
        self.flag_min = ticks(nominal, 11, 2);
        // Bus idle is 11 recessive bits; ACK delimiter, EOF and intermission may show 10.5.
        self.idle_min = ticks(nominal, 21, 2);
        self.run_min = ticks(shortest, 3, 10);
    }

    pub(crate) fn begin(&mut self, at: u64, level: Level) {
        self.len = 0;
        self.origin = at;
        self.last = at;
        self.level = level;
        self.before = Before::Unknown;
        self.state = match level {
            Level::Recessive => State::Idle { since: at },
            Level::Dominant => State::Active { idle_since: at },
        };
    }

    /// Takes an edge; `true` if it begins the next activity and the one before is complete.
    #[inline]
    pub(crate) fn push(&mut self, at: u64) -> bool {
        let run = clamp(at.wrapping_sub(self.last));
        match (self.state, self.level) {
            (State::Off, _) => false,
            (State::Idle { since }, _) => {
                let known = self.before != Before::Unknown || run >= self.idle_min;
                self.state = State::Active { idle_since: since };
                self.before = if known { Before::Gap(run) } else { Before::Unknown };
                self.origin = at;
                self.len = 0;
                self.last = at;
                self.level = Level::Dominant;
                false
            }
            (State::Active { idle_since }, _) if run < self.run_min => {
                self.drop_glitch(idle_since);
                false
            }
            (State::Active { .. }, Level::Recessive) if run >= self.gap_min => {
                self.gap = run;
                self.ending = Ending::Edge;
                true
            }
            (State::Active { .. }, _) => {
                self.store(run);
                self.last = at;
                self.level = self.level.toggled();
                false
            }
        }
    }

    #[inline]
    fn store(&mut self, run: u32) {
        if let Some(slot) = self.runs.get_mut(self.len) {
            *slot = run;
        }
        self.len = self.len.saturating_add(1);
    }

    /// The run since the last edge is too short: both its edges go.
    fn drop_glitch(&mut self, idle_since: u64) {
        self.level = self.level.toggled();
        if self.len == 0 {
            self.state = State::Idle { since: idle_since };
            self.last = idle_since;
            return;
        }
        self.len -= 1;
        if let Some(&run) = self.runs.get(self.len) {
            self.last = self.last.wrapping_sub(u64::from(run));
        }
    }

    /// Goes on with the activity that begins at `at`, the edge that ended the last gap.
    pub(crate) fn restart(&mut self, at: u64) {
        self.before = Before::Gap(self.gap);
        self.state = State::Active { idle_since: self.last };
        self.origin = at;
        self.last = at;
        self.len = 0;
        self.level = Level::Dominant;
    }

    /// The recording ends at `at`.
    pub(crate) fn close(&mut self, at: u64) {
        let run = clamp(at.saturating_sub(self.last));
        self.ending = Ending::Recording;
        match (self.state, self.level) {
            (State::Active { .. }, Level::Recessive) => self.gap = run,
            (State::Active { .. }, Level::Dominant) => {
                self.store(run);
                self.gap = 0;
            }
            (State::Off | State::Idle { .. }, _) => {}
        }
    }

    pub(crate) fn clear(&mut self) {
        self.state = State::Off;
        self.len = 0;
    }

    /// The activity, if there is one that fits the buffer.
    pub(crate) fn activity(&self) -> Option<Activity<'_>> {
        match self.state {
            State::Active { .. } => {
                let runs = self.runs.get(..self.len.min(N))?;
                (!runs.is_empty()).then_some(Activity { runs, gap: self.gap })
            }
            State::Off | State::Idle { .. } => None,
        }
    }

    /// When the activity began.
    pub(crate) const fn origin(&self) -> u64 {
        self.origin
    }

    /// When its last edge was.
    pub(crate) const fn end(&self) -> u64 {
        self.last
    }

    /// When the run at `index` began.
    pub(crate) fn run_start(&self, index: usize) -> u64 {
        let before = self.runs.get(..index.min(self.len).min(N)).unwrap_or(&[]);
        let sum = before.iter().map(|&run| u64::from(run)).sum::<u64>();
        self.origin.saturating_add(sum)
    }

    /// Whether the recording began in it or too shortly before it to say that it began with SOF.
    pub(crate) fn is_integrating(&self) -> bool {
        self.before == Before::Unknown
    }

    /// Whether the recording ended in the run at `index`.
    pub(crate) fn is_cut_at(&self, index: usize) -> bool {
        let last = match self.level {
            Level::Dominant => self.len.saturating_sub(1),
            Level::Recessive => self.len,
        };
        self.ending == Ending::Recording && index >= last
    }

    /// Whether `activity` is an overload flag: one long dominant run right behind a frame.
    pub(crate) fn is_overload(&self, activity: Activity<'_>) -> bool {
        match (activity.runs, self.before) {
            (&[flag], Before::Gap(gap)) => flag >= self.flag_min && gap < self.idle_min,
            _ => false,
        }
    }
}

/// `numerator / denominator` bit times, rounded down.
fn ticks(bit_q20: u64, numerator: u64, denominator: u64) -> u32 {
    clamp((bit_q20 * numerator / denominator) >> 20)
}

fn clamp(ticks: u64) -> u32 {
    u32::try_from(ticks).unwrap_or(u32::MAX)
}
