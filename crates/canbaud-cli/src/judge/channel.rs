//! One line: edges to the detector until a rate is proven, then to the decoder.

use canbaud::detect::{PulseDetector, Verdict};
use canbaud::units::Bitrate;
use canbaud::wire::{BusTiming, Decoder, Item, Level, Logic, Polarity};

use super::JudgeOptions;
use super::evidence::{Counting, Evidence};
use super::known::{self, Grid};

/// Runs that a frame may have: the longest CAN FD frame has under 700.
pub(super) const RUNS: usize = 1024;
/// Edges kept of one channel while its rate is sought, so that no frame is lost: 256 KiB.
const KEPT_EDGES: usize = 1 << 15;
/// Edges kept of all channels of a capture together: 8 MiB.
const KEPT_EDGES_OF_ALL: usize = 1 << 20;
/// Frames that make rate and polarity sure enough to decode.
const FRAMES_TO_START: u32 = 16;
/// Uncertainty of the bit time at which the last bit of the longest frame is still in place.
const UNCERTAINTY_TO_START_PPB: u32 = 100_000;

/// An unbroken stretch of recording.
#[derive(Debug, Clone)]
struct Stretch {
    begin: u64,
    level: Logic,
    edges: Vec<u64>,
    end: Option<u64>,
}

/// What happens with the edges.
enum Mode {
    /// The rate is sought; edges are kept.
    Searching { detector: Box<PulseDetector<RUNS>>, kept: Vec<Stretch>, kept_edges: usize },
    /// The rate is known.
    Decoding { decoder: Box<Decoder<RUNS>> },
}

/// How the line looks apart from any bit rate.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LineFacts {
    pub(super) edges: u64,
    pub(super) ticks: u64,
    pub(super) shortest: Option<u64>,
    high_ticks: u64,
}

/// Whether edges were let go before the rate was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Start {
    Kept,
    LetGo,
}

/// Follows one line through a capture.
pub(super) struct ChannelJudge {
    mode: Mode,
    start: Start,
    grid: Grid,
    kept_edges_max: usize,
    last: u64,
    level: Logic,
    given_polarity: Option<Polarity>,
    given: Option<BusTiming>,
    verdict: Option<Verdict>,
    timing: Option<(BusTiming, Polarity)>,
    pub(super) facts: LineFacts,
    pub(super) evidence: Evidence,
}

/// Takes the items of a channel as they are decoded.
pub(super) type ItemSink<'a> = &'a mut dyn FnMut(&Item);

impl ChannelJudge {
    /// For one of `channels` channels that are judged together.
    pub(super) fn new(grid: Grid, channels: usize, options: &JudgeOptions) -> Self {
        let given = options.bitrate.and_then(|rate| given_timing(grid, rate, options.data_bitrate));
        Self {
            mode: searching(),
            start: Start::Kept,
            grid,
            kept_edges_max: KEPT_EDGES.min(KEPT_EDGES_OF_ALL / channels.max(1)),
            last: 0,
            level: Logic::High,
            given_polarity: options.polarity,
            given,
            verdict: None,
            timing: None,
            facts: LineFacts::default(),
            evidence: Evidence::new(grid),
        }
    }

    pub(super) const fn is_searching(&self) -> bool {
        matches!(self.mode, Mode::Searching { .. })
    }

    /// Whether enough frames were seen to know rate and polarity well.
    pub(super) const fn frames_proven(&self) -> u64 {
        self.evidence.counts.good()
    }

    /// The verdict of the detector, once the recording has ended or a rate is proven.
    pub(super) const fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    pub(super) fn polarity(&self) -> Option<Polarity> {
        self.timing.map(|(_, polarity)| polarity)
    }

    /// The ticks that this judge counts in.
    pub(super) const fn grid(&self) -> Grid {
        self.grid
    }

    /// Whether frames are destroyed, or off the rate, so that another one may be on the line.
    pub(super) fn has_many_errors(&self) -> bool {
        let counts = &self.evidence.counts;
        let errors = counts.error.saturating_sub(self.evidence.acknowledge_errors);
        let strangers = self.evidence.off_rate;
        self.timing.is_some() && self.given.is_none() && (errors >= 4 || strangers >= 2)
    }

    /// Takes what a detector said that saw the whole line.
    pub(super) fn note_rival(&mut self, verdict: Verdict) {
        if matches!(verdict, Verdict::Conflict { .. }) {
            self.verdict = Some(verdict);
        }
    }

    /// Whether the rate is the user's word.
    pub(super) const fn is_given(&self) -> bool {
        self.given.is_some()
    }

    /// Whether a rate was found only after the first edges were let go.
    pub(super) fn missed_the_start(&self) -> bool {
        self.start == Start::LetGo && self.timing.is_some()
    }

    /// Reads the capture again from its start, at the rate found.
    pub(super) fn rewind(&mut self) {
        self.facts = LineFacts::default();
        self.evidence = Evidence::new(self.grid);
        self.start = Start::Kept;
        match self.timing.and_then(|(timing, _)| Decoder::new(&timing)) {
            Some(decoder) => self.mode = Mode::Decoding { decoder: Box::new(decoder) },
            None => self.mode = searching(),
        }
    }

    pub(super) fn begin(&mut self, at: u64, level: Logic) {
        let at = self.grid.of(at);
        self.last = at;
        self.level = level;
        let bus_level = self.bus_level(level);
        match &mut self.mode {
            Mode::Searching { detector, kept, .. } => {
                detector.begin(at, level);
                kept.push(Stretch { begin: at, level, edges: Vec::new(), end: None });
            }
            Mode::Decoding { decoder } => decoder.begin(at, bus_level),
        }
    }

    pub(super) fn edges(&mut self, times: &[u64], sink: ItemSink<'_>) {
        let scaled;
        let times = if self.grid.divisor == 1 {
            times
        } else {
            scaled = self.grid.of_edges(times);
            &scaled
        };
        self.note(times);
        match &mut self.mode {
            Mode::Decoding { decoder } => {
                decoder.edges(times, &mut Counting { evidence: &mut self.evidence, sink });
            }
            Mode::Searching { detector, kept, kept_edges } => {
                for &at in times {
                    detector.push(at);
                }
                *kept_edges += times.len();
                if let Some(stretch) = kept.last_mut() {
                    stretch.edges.extend_from_slice(times);
                }
                if *kept_edges > self.kept_edges_max {
                    self.start = Start::LetGo;
                    *kept_edges = 0;
                    kept.clear();
                }
                if let Verdict::Found(found) = detector.verdict()
                    && found.proven_frames >= FRAMES_TO_START
                    && found.nominal.uncertainty_ppb <= UNCERTAINTY_TO_START_PPB
                {
                    self.start_decoding(sink);
                }
            }
        }
    }

    pub(super) fn end(&mut self, at: u64, sink: ItemSink<'_>) {
        let at = self.grid.of(at).max(self.last);
        self.advance(at);
        match &mut self.mode {
            Mode::Searching { detector, kept, .. } => {
                detector.finish(at);
                if let Some(stretch) = kept.last_mut() {
                    stretch.end = Some(at);
                }
            }
            Mode::Decoding { decoder } => {
                decoder.finish(at, &mut Counting { evidence: &mut self.evidence, sink });
            }
        }
    }

    /// The capture has ended: what was not decided before is decided now.
    pub(super) fn conclude(&mut self, sink: ItemSink<'_>) {
        if self.is_searching() {
            self.start_decoding(sink);
        }
    }

    /// Takes the verdict of the detector and decodes what was kept.
    fn start_decoding(&mut self, sink: ItemSink<'_>) {
        let Mode::Searching { detector, kept, .. } = &mut self.mode else { return };
        let verdict = detector.verdict();
        self.verdict = Some(verdict);
        let found = detector.bus_timing();
        let polarity = match verdict {
            Verdict::Found(found) => found.polarity,
            _ => self.facts.likely_polarity(),
        };
        let timing = match (self.given, found) {
            (Some(given), Some(found)) => Some(known::merge(given, found)),
            (given, found) => given.or(found),
        };
        let kept = std::mem::take(kept);
        let Some(timing) = timing else { return };
        let Some(decoder) = Decoder::new(&timing) else { return };
        self.timing = Some((timing, self.given_polarity.unwrap_or(polarity)));
        let mut decoder = Box::new(decoder);
        let mut counting = Counting { evidence: &mut self.evidence, sink };
        let polarity = self.given_polarity.unwrap_or(polarity);
        for stretch in kept {
            decoder.begin(stretch.begin, polarity.level(stretch.level));
            decoder.edges(&stretch.edges, &mut counting);
            if let Some(end) = stretch.end {
                decoder.finish(end, &mut counting);
            }
        }
        self.mode = Mode::Decoding { decoder };
    }

    fn bus_level(&self, level: Logic) -> Level {
        self.timing.map_or(Polarity::Normal, |(_, polarity)| polarity).level(level)
    }

    /// Facts about the line that hold at any rate.
    fn note(&mut self, times: &[u64]) {
        self.facts.edges += times.len() as u64;
        if let (Mode::Decoding { .. }, Some(&last)) = (&self.mode, times.last()) {
            self.facts.ticks += last - self.last;
            self.last = last;
            return;
        }
        // The run before the first edge began before the recording.
        let mut whole = self.facts.edges > times.len() as u64;
        for &at in times {
            let run = at.saturating_sub(self.last);
            self.advance(at);
            if whole {
                let shortest = self.facts.shortest.map_or(run, |known| known.min(run));
                self.facts.shortest = Some(shortest);
            }
            whole = true;
            self.level = self.level.toggled();
        }
    }

    fn advance(&mut self, at: u64) {
        let run = at.saturating_sub(self.last);
        self.facts.ticks += run;
        if self.level == Logic::High {
            self.facts.high_ticks += run;
        }
        self.last = at;
    }
}

impl LineFacts {
    /// A bus is recessive most of the time.
    const fn likely_polarity(&self) -> Polarity {
        if self.high_ticks * 2 >= self.ticks { Polarity::Normal } else { Polarity::Inverted }
    }
}

fn searching() -> Mode {
    Mode::Searching { detector: Box::new(PulseDetector::new()), kept: Vec::new(), kept_edges: 0 }
}

/// What the user says of the bus, in ticks.
fn given_timing(grid: Grid, bitrate: Bitrate, data: Option<Bitrate>) -> Option<BusTiming> {
    let ticks_q20 = grid.ticks_q20(bitrate)?;
    let data = match data {
        Some(data) => Some(known::data_timing(ticks_q20, grid.ticks_q20(data)?)),
        None => None,
    };
    Some(BusTiming { data, ..BusTiming::classic(ticks_q20) })
}
