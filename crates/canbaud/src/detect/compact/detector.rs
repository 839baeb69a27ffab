//! Edges in, a verdict out.

use super::grid::{Gaps, Grid, Measured, grids};
use crate::detect::{BitTime, DataPhase, Found, Need, Verdict};
use crate::wire::{Logic, Polarity};

/// Fewest runs of a frame: even with every bit stuffed, 34 bits have seven.
const RUNS_MIN: usize = 7;
/// A verdict needs a CRC, less what was tried until it was right.
const CRC_BITS: u32 = 15;
const PROOF_BITS_MIN: u32 = 10;
/// A bit time less certain than 0.2 % is no answer: a tick more or less would be 0.5 %, and rates in use
/// lie 1.6 % apart.
const UNCERTAINTY_MAX_PPB: u32 = 2_000_000;
/// Two frames agree if their bit times differ by less than the 128th part: two of 0.2 % each, and some.
const AGREEMENT_SHIFT: u32 = 7;
/// Standard deviation of the time between two edges on whole ticks, in 10^-9 ticks.
const SPAN_DEVIATION: u32 = 408_248_290;

/// Finds and proves the bit rate of a bus from one classic frame, for the smallest controllers.
///
/// What [`PulseDetector`](crate::detect::PulseDetector) can do and this cannot: fewer than three
/// ticks a bit, CAN FD frames, an inverted line, glitches, sharpening the bit time over many frames,
/// telling two rates on one line. What it costs is in `docs/firmware.md`. It never guesses, either:
/// the frame has to have its CRC and form right and its edges on the grid, between two gaps. What was
/// compared with a CRC in vain counts against a proof as long as the detector lives: after 32 times
/// two different frames have to agree, and after 1024 nothing is proof enough. Noise hardly ever
/// comes as far; other signals on the line may, and a new detector begins anew.
///
/// `N` is the number of runs that it can hold; 128 are enough for any classic frame. The frame may
/// last up to 2^22 ticks. The line is RXD: high is recessive.
///
/// ```
/// use canbaud::detect::{CompactDetector, Verdict};
/// use canbaud::wire::Logic;
/// let mut detector = CompactDetector::<128>::new();
/// detector.begin(0, Logic::High);
/// assert_eq!(detector.verdict(), Verdict::NoTraffic);
/// ```
#[derive(Debug, Clone)]
pub struct CompactDetector<const N: usize = 128> {
    /// The runs since the gap before; the first one is dominant.
    runs: [u32; N],
    len: usize,
    start: Start,
    /// Behind a run that looked like a gap, but what preceded it was no frame: perhaps an error
    /// frame.
    later: Option<Start>,
    last: u64,
    level: Logic,
    /// How often a CRC was compared.
    compared: u32,
    seen: Seen,
}

/// Where a frame may begin, and the longest runs of both levels since.
#[derive(Debug, Clone, Copy)]
struct Start {
    /// Index of its first run.
    at: usize,
    /// The recessive run before.
    before: u32,
    dominant: u32,
    recessive: u32,
}

impl Start {
    const fn new(at: usize, before: u32) -> Self {
        Self { at, before, dominant: 0, recessive: 0 }
    }

    /// Takes the run at `at`.
    fn take(&mut self, at: usize, run: u32) {
        let longest = if at.is_multiple_of(2) { &mut self.dominant } else { &mut self.recessive };
        *longest = run.max(*longest);
    }

    /// Whether a frame may end with the runs before `end`, and the gap of `run` ticks behind them.
    fn may_be_frame(&self, end: usize, run: u32) -> bool {
        let count = end.saturating_sub(self.at);
        count % 2 == 1 && count >= RUNS_MIN && self.is_gap(run) && self.is_gap(self.before)
    }

    /// Against ten bits of a gap, recessive runs of a frame have five or six, an error flag has six
    /// or more.
    fn is_gap(&self, run: u32) -> bool {
        let run = u64::from(run);
        run * 2 >= u64::from(self.recessive) * 3 && run * 8 >= u64::from(self.dominant) * 9
    }
}

/// The most that was seen so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seen {
    Nothing,
    Edges,
    /// A stretch between two gaps that was no frame.
    Stretch,
    /// A frame that is too short for the timer's ticks.
    ShortFrame,
    /// A frame whose CRC may be right by accident.
    WeakFrame(Frame),
    Proof {
        bit: BitTime,
        frames: u32,
        proof_bits: u32,
    },
}

/// A frame that could be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Frame {
    bit: BitTime,
    /// Of its content.
    print: u32,
}

impl Frame {
    /// Whether both say the same, and are not one frame that is sent again.
    fn confirms(&self, other: &Self) -> bool {
        let apart = self.bit.ticks_q20.abs_diff(other.bit.ticks_q20);
        self.print != other.print && apart <= self.bit.ticks_q20 >> AGREEMENT_SHIFT
    }
}

impl<const N: usize> CompactDetector<N> {
    /// A detector before its first edge.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            runs: [0; N],
            len: 0,
            start: Start::new(0, 0),
            later: None,
            last: 0,
            level: Logic::High,
            compared: 0,
            seen: Seen::Nothing,
        }
    }

    /// Unbroken recording begins at `at` with the line at `level`; also after a lost edge.
    pub fn begin(&mut self, at: u64, level: Logic) {
        self.restart(0);
        self.last = at;
        self.level = level;
    }

    /// An edge at `at`, later than the one before; the level toggles.
    pub fn push(&mut self, at: u64) {
        if self.seen == Seen::Nothing {
            self.seen = Seen::Edges;
        }
        let run = self.run_until(at);
        self.last = at;
        match self.level {
            Logic::Low => self.store(run),
            Logic::High => self.end_recessive(run),
        }
        self.level = self.level.toggled();
    }

    /// The line has not changed from the last edge to `at`, and the recording ends or pauses:
    /// [`CompactDetector::begin`] comes before the next edge.
    pub fn finish(&mut self, at: u64) {
        if self.level == Logic::High {
            let run = self.run_until(at);
            self.judge(run);
        }
        self.restart(0);
    }

    /// What is known so far. Once a rate is found, further edges do not change it.
    #[must_use]
    pub const fn verdict(&self) -> Verdict {
        match self.seen {
            Seen::Nothing => Verdict::NoTraffic,
            Seen::Edges => Verdict::Undecided(Need::CompleteFrame),
            Seen::Stretch => Verdict::Undecided(Need::CleanFrame),
            Seen::ShortFrame | Seen::WeakFrame(_) => Verdict::Undecided(Need::AnotherFrame),
            Seen::Proof { bit, frames, proof_bits } => Verdict::Found(Found {
                nominal: bit,
                data: DataPhase::NoFd,
                proven_frames: frames,
                proof_bits,
                polarity: Polarity::Normal,
            }),
        }
    }

    fn run_until(&self, at: u64) -> u32 {
        u32::try_from(at.saturating_sub(self.last)).unwrap_or(u32::MAX)
    }

    /// A recessive run ended: the gap behind a frame, a better gap before one, or a run of one.
    fn end_recessive(&mut self, run: u32) {
        match self.judge(run) {
            Stretch::Frame => self.restart(run),
            _ if run >= self.start.before => self.restart(run),
            Stretch::NoFrame => {
                self.store(run);
                self.later = Some(Start::new(self.len, run));
            }
            Stretch::GoesOn => self.store(run),
        }
    }

    fn restart(&mut self, before: u32) {
        self.start = Start::new(0, before);
        self.later = None;
        self.len = 0;
    }

    fn store(&mut self, run: u32) {
        if self.len == N {
            self.make_room();
        }
        if let Some(slot) = self.runs.get_mut(self.len) {
            *slot = run;
            self.start.take(self.len, run);
            if let Some(later) = &mut self.later {
                later.take(self.len, run);
            }
            self.len += 1;
        }
    }

    /// Drops everything before the longest recessive run: more likely than others, it is a gap.
    fn make_room(&mut self) {
        let (mut at, mut before) = (N, 0);
        for (index, &run) in self.runs.iter().enumerate().skip(1).step_by(2) {
            if run >= before {
                (at, before) = (index + 1, run);
            }
        }
        self.restart(before);
        for from in at..N {
            if let Some(&run) = self.runs.get(from) {
                self.store(run);
            }
        }
    }

    /// What ends with the recessive run of `run` ticks.
    fn judge(&mut self, run: u32) -> Stretch {
        let mut stretch = Stretch::GoesOn;
        for start in [Some(self.start), self.later].into_iter().flatten() {
            if start.may_be_frame(self.len, run) {
                if self.prove(start, run) {
                    return Stretch::Frame;
                }
                stretch = Stretch::NoFrame;
            }
        }
        stretch
    }

    fn prove(&mut self, start: Start, behind: u32) -> bool {
        let waits = match self.seen {
            Seen::Proof { .. } => return true,
            Seen::WeakFrame(frame) => Some(frame),
            Seen::Nothing | Seen::Edges | Seen::Stretch | Seen::ShortFrame => None,
        };
        let runs = self.runs.get(start.at..self.len).unwrap_or(&[]);
        let compared = &mut self.compared;
        let right = grids(runs, Gaps { before: start.before, behind })
            .find_map(|grid| Some((grid, grid.read(runs, compared)?)));
        let frame = right.and_then(|(grid, measured)| {
            Some(Frame { bit: bit_time(grid, measured)?, print: measured.print })
        });
        self.seen = match frame {
            Some(frame) if frame.bit.uncertainty_ppb <= UNCERTAINTY_MAX_PPB => {
                self.weigh(frame, waits)
            }
            Some(_) => waits.map_or(Seen::ShortFrame, Seen::WeakFrame),
            None => waits.map_or(Seen::Stretch, Seen::WeakFrame),
        };
        frame.is_some()
    }

    /// Each comparison of a CRC was one chance to be right by accident.
    fn weigh(&self, frame: Frame, waits: Option<Frame>) -> Seen {
        let chances = u32::BITS - self.compared.saturating_sub(1).leading_zeros();
        let confirmed = waits.is_some_and(|before| frame.confirms(&before));
        let frames = if confirmed { 2 } else { 1 };
        let proof_bits = (frames * CRC_BITS).saturating_sub(frames * chances);
        if proof_bits >= PROOF_BITS_MIN {
            Seen::Proof { bit: frame.bit, frames, proof_bits }
        } else {
            Seen::WeakFrame(frame)
        }
    }
}

/// What a recessive run ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stretch {
    GoesOn,
    /// It looks like a gap, but the runs before it are no frame.
    NoFrame,
    Frame,
}

fn bit_time(grid: Grid, measured: Measured) -> Option<BitTime> {
    // Rounding alone makes up to a tick; of more than that, twice the deviation is about the most.
    let beyond = 2 * measured.stray_ticks.saturating_sub(1);
    let deviation = SPAN_DEVIATION.saturating_mul(beyond.max(1));
    let uncertainty_ppb = deviation.checked_div(grid.ticks)?;
    Some(BitTime { ticks_q20: measured.ticks_q20, uncertainty_ppb })
}

impl<const N: usize> Default for CompactDetector<N> {
    fn default() -> Self {
        Self::new()
    }
}
