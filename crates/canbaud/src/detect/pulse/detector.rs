//! The detector: edges in, a verdict out, in fixed memory.

use super::measure::{Measurement, pool};
use super::places::Places;
use super::prove::{Idle, Proof, SAME_RATE_SHIFT, Tries, prove, prove_at};
use super::segment::{Candidate, End, Segmenter};
use super::{glitch, interval};
use crate::detect::{BitTime, DataPhase, Found, Need, Phase, Verdict};
use crate::wire::clock::BitClock;
use crate::wire::reader::{Activity, Rates};
use crate::wire::{BusTiming, DataTiming, FdCrc, Frame, Logic, Polarity};

/// Proof that a verdict needs, in bits: one CRC, less what was tried until it was right.
const PROOF_BITS_MIN: u32 = 10;
/// A nominal bit time less certain than 1.2 % is no answer: rates in use lie 1.6 % apart.
const UNCERTAINTY_MAX_PPB: u32 = 12_000_000;
/// The same for frames with a data phase, whose nominal part is short.
const SWITCHED_UNCERTAINTY_MAX_PPB: u32 = 5_000_000;
/// Proof of a second rate: two different frames.
const RIVAL_BITS_MIN: u32 = 25;
/// Or this many that may be alike.
const RIVAL_FRAMES_MIN: u32 = 4;

/// Finds and proves the bit rate of a bus from its edges. `N` is the number of runs that it can
/// hold: 160 for any classic frame and the short CAN FD frames, 800 for all.
///
/// Time is a parameter: ticks of whatever timer captured the edges. Feed every edge; ask for the
/// verdict at any time.
///
/// ```
/// use canbaud::detect::{PulseDetector, Verdict};
/// use canbaud::wire::Logic;
/// let mut detector = PulseDetector::<160>::new();
/// detector.begin(0, Logic::High);
/// assert_eq!(detector.verdict(), Verdict::NoTraffic);
/// ```
#[derive(Debug, Clone)]
pub struct PulseDetector<const N: usize = 160> {
    segmenter: Segmenter<N>,
    last: u64,
    edges: u32,
    candidates: u32,
    rates: ProvenRates,
    /// Readings whose CRC was compared: each was a chance to be wrong.
    tried: u32,
}

/// A rate that proved at least one frame.
#[derive(Debug, Clone, Copy)]
struct Rate {
    rates: Rates,
    polarity: Polarity,
    nominal: Measurement,
    data: Measurement,
    fd_frames: u32,
    proven: u32,
    proof_bits: u32,
    /// Hash of the last frame: the same frame again proves nothing new.
    last_frame: u32,
}

impl<const N: usize> PulseDetector<N> {
    /// A detector before its first edge.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            segmenter: Segmenter::new(),
            last: 0,
            edges: 0,
            candidates: 0,
            rates: ProvenRates { leader: None, rival: None },
            tried: 0,
        }
    }

    /// Unbroken recording begins at `at` with the line at `level`; also after a pause.
    pub fn begin(&mut self, at: u64, level: Logic) {
        self.segmenter.begin(level);
        self.last = at;
    }

    /// An edge at `at`, later than the one before; the level toggles.
    pub fn push(&mut self, at: u64) {
        let run = u32::try_from(at.saturating_sub(self.last)).unwrap_or(u32::MAX);
        self.last = at;
        self.edges = self.edges.saturating_add(1);
        if self.judge(run, End::Edge) {
            self.segmenter.restart(run);
        } else {
            self.segmenter.store(run);
        }
    }

    /// The line has not changed from the last edge to `at`, and the recording ends or pauses;
    /// [`PulseDetector::begin`] comes before the next edge.
    pub fn finish(&mut self, at: u64) {
        let run = u32::try_from(at.saturating_sub(self.last)).unwrap_or(u32::MAX);
        self.judge(run, End::OfRecording);
        self.segmenter.stop();
    }

    /// What is known so far.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match (&self.rates.leader, &self.rates.rival) {
            (None, _) if self.edges == 0 => Verdict::NoTraffic,
            (None, _) if self.candidates == 0 => Verdict::Undecided(Need::CompleteFrame),
            (None, _) => Verdict::Undecided(Need::CleanFrame),
            (Some(leader), Some(rival)) if rival.is_beyond_accident() => {
                match leader.apart_from(rival) {
                    Some((phase, first, second)) => Verdict::Conflict { phase, first, second },
                    None => leader.verdict(),
                }
            }
            (Some(leader), Some(_)) if leader.proven == 1 => Verdict::Undecided(Need::AnotherFrame),
            (Some(leader), _) => leader.verdict(),
        }
    }

    /// What a decoder must know to read the bus; `None` before a verdict of `Found`.
    #[must_use]
    pub fn bus_timing(&self) -> Option<BusTiming> {
        match (self.verdict(), &self.rates.leader) {
            (Verdict::Found(_), Some(leader)) => Some(leader.bus_timing()),
            _ => None,
        }
    }

    /// Whether the run of `run` ticks, which just ended, is the gap behind a proven frame.
    fn judge(&mut self, run: u32, end: End) -> bool {
        let mut skip = 0;
        while let Some(candidate) = self.segmenter.candidate(run, end, skip) {
            self.candidates = self.candidates.saturating_add(1);
            if self.judge_candidate(candidate) {
                return true;
            }
            skip += 1;
        }
        false
    }

    fn judge_candidate(&mut self, candidate: Candidate) -> bool {
        let runs = self.segmenter.runs_from(candidate.at);
        let gap = candidate.gap;
        let idle = Idle { before: candidate.before, behind: candidate.behind };
        let polarity = match candidate.idle {
            Logic::High => Polarity::Normal,
            Logic::Low => Polarity::Inverted,
        };
        let mut room = [0; N];
        let rates = &mut self.rates;
        if rates.read(Activity { runs, gap }, idle, polarity, &mut room) {
            return true;
        }
        let proven = Self::prove_anew(runs, gap, idle, &mut self.tried, &mut room);
        if let Some((proof, runs)) = proven {
            rates.enter(&proof, Activity { runs, gap }, polarity);
        }
        proven.is_some()
    }

    /// Proves a rate that is not known yet, if need be without glitches; gives the runs, too.
    fn prove_anew<'a>(
        runs: &'a [u32],
        gap: u32,
        idle: Idle,
        tried: &mut u32,
        room: &'a mut [u32; N],
    ) -> Option<(Proof, &'a [u32])> {
        if let Some(proof) = prove(Activity { runs, gap }, idle, tried) {
            return Some((proof, runs));
        }
        let (width, proof) = glitch::widths(runs).find_map(|width| {
            let clean = glitch::without(runs, width, room)?;
            prove(Activity { runs: clean, gap }, idle, tried).map(|proof| (width, proof))
        })?;
        glitch::without(runs, width, room).map(|clean| (proof, clean))
    }
}

/// The rates that proved frames: the one with more, and another.
#[derive(Debug, Clone, Copy)]
struct ProvenRates {
    leader: Option<Rate>,
    rival: Option<Rate>,
}

impl ProvenRates {
    fn iter_mut(&mut self) -> impl Iterator<Item = &mut Rate> {
        [&mut self.leader, &mut self.rival].into_iter().flatten()
    }

    /// Reads a frame at one of the rates; `room` holds it without its glitches.
    fn read(
        &mut self,
        activity: Activity<'_>,
        idle: Idle,
        polarity: Polarity,
        room: &mut [u32],
    ) -> bool {
        let read = self.iter_mut().any(|rate| {
            rate.polarity == polarity
                && idle.suits(rate.rates.nominal.ticks_q20())
                && rate.reads(activity, room)
        });
        self.rank();
        read
    }

    /// Enters a proof with the rate that it is for.
    fn enter(&mut self, proof: &Proof, activity: Activity<'_>, polarity: Polarity) {
        // Two rates on one line are a conflict already.
        let full = self.rival.is_some_and(|rival| rival.proven > 1);
        let same = self.iter_mut().find(|rate| rate.polarity == polarity && rate.is_of(proof));
        match same {
            Some(rate) => rate.add(proof, activity),
            None if full => {}
            None => {
                let slot = if self.leader.is_none() { &mut self.leader } else { &mut self.rival };
                *slot = Some(Rate::new(proof, activity, polarity));
            }
        }
        self.rank();
    }

    /// The rate with more proven frames leads.
    fn rank(&mut self) {
        let proven = |rate: &Option<Rate>| rate.map_or(0, |rate| rate.proven);
        if proven(&self.rival) > proven(&self.leader) {
            core::mem::swap(&mut self.leader, &mut self.rival);
        }
    }
}

impl<const N: usize> Default for PulseDetector<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl Rate {
    fn new(proof: &Proof, activity: Activity<'_>, polarity: Polarity) -> Self {
        let mut rate = Self {
            rates: proof.attempt.rates,
            polarity,
            nominal: Measurement::default(),
            data: Measurement::default(),
            fd_frames: 0,
            proven: 0,
            proof_bits: 0,
            last_frame: 0,
        };
        // Each comparison of a CRC was one chance to be wrong.
        let chances = proof.compared.max(1).next_power_of_two().trailing_zeros();
        rate.add(proof, activity);
        rate.proof_bits = rate.proof_bits.saturating_sub(chances);
        rate
    }

    /// Whether a frame is of this rate, by its own edges.
    fn is_of(&self, proof: &Proof) -> bool {
        let same = |known: u64, other: u64| known.abs_diff(other) <= known >> SAME_RATE_SHIFT;
        let reading = &proof.attempt.reading;
        let nominal = proof.fit.ticks_q20();
        let data = proof.attempt.rates.data.filter(|_| reading.brs_run.is_some());
        same(
            self.rates.nominal.ticks_q20(),
            nominal.unwrap_or(proof.attempt.rates.nominal.ticks_q20()),
        ) && match (self.rates.data, data) {
            (Some(known), Some(other)) => same(known.clock.ticks_q20(), other.clock.ticks_q20()),
            _ => true,
        }
    }

    /// Reads one more frame at this rate; `room` holds it without its glitches.
    fn reads(&mut self, activity: Activity<'_>, room: &mut [u32]) -> bool {
        let shortest = self.rates.data.map_or(self.rates.nominal, |data| data.clock);
        let width = (3 * shortest.ticks_q20() / 10) >> 20;
        let width = u32::try_from(width).unwrap_or(u32::MAX);
        let runs = glitch::without(activity.runs, width, room).unwrap_or(activity.runs);
        let activity = Activity { runs, ..activity };
        // A receiver tolerates several percent; a frame that far off is of another rate.
        let proof =
            prove_at(activity, &self.rates, Tries::All, &mut 0).filter(|proof| self.is_of(proof));
        if let Some(proof) = &proof {
            self.add(proof, activity);
        }
        proof.is_some()
    }

    fn add(&mut self, proof: &Proof, activity: Activity<'_>) {
        let hash = hash(&proof.received.frame);
        if self.proven == 0 || hash != self.last_frame {
            self.proof_bits = self.proof_bits.saturating_add(crc_bits(proof));
        }
        self.last_frame = hash;
        self.proven = self.proven.saturating_add(1);
        self.nominal.add_fit(&proof.fit);
        if proof.received.fd_crc.is_some() {
            self.fd_frames = self.fd_frames.saturating_add(1);
            self.rates.fd_crc = proof.attempt.rates.fd_crc;
        }
        if proof.attempt.reading.brs_run.is_some() {
            self.data.add(&proof.attempt.reading.data);
            self.rates.data = proof.attempt.rates.data;
        }
        if self.proven == 1 && self.nominal.frames() == 1 {
            self.nominal.set_noise(proof.noise_q20);
            self.data.set_noise(proof.noise_q20);
            if let Some(interval) = &proof.interval {
                self.nominal.set_interval(interval);
            }
        }
        if self.data.frames() == 1
            && let Some(places) = Places::data(activity, &proof.attempt)
            && let Some(interval) = interval::of(&places)
        {
            self.data.set_interval(&interval);
        }
        self.sharpen();
    }

    /// Whether this many frames, or frames this different, are no accident of a CRC.
    fn is_beyond_accident(&self) -> bool {
        self.proof_bits >= RIVAL_BITS_MIN || self.proven >= RIVAL_FRAMES_MIN
    }

    /// The bit times in which two rates differ: the nominal ones, or else those of the data phase;
    /// `None` if they differ in neither, as far as was measured. A first frame with few ticks a
    /// bit may begin a rate of its own, and the next ones show that it is the same.
    fn apart_from(&self, other: &Self) -> Option<(Phase, BitTime, BitTime)> {
        let (first, second) = (self.nominal.bit_time()?, other.nominal.bit_time()?);
        if self.polarity != other.polarity || !may_be_one(first, second) {
            return Some((Phase::Nominal, first, second));
        }
        let (first, second) = (self.data.bit_time()?, other.data.bit_time()?);
        (!may_be_one(first, second)).then_some((Phase::Data, first, second))
    }

    /// Reads the next frame at the bit times measured so far.
    fn sharpen(&mut self) {
        let measured = self.nominal.ticks_q20().and_then(BitClock::new);
        if let Some(clock) = measured {
            self.rates.nominal = clock;
        }
        let data = self.data.ticks_q20().and_then(BitClock::new);
        if let (Some(clock), Some(rate)) = (data, &mut self.rates.data) {
            rate.clock = clock;
        }
        let late = self.nominal.asymmetry_q8() << 12;
        let moved = late - self.rates.late_ticks_q20;
        self.rates.late_ticks_q20 = late;
        if let Some(rate) = &mut self.rates.data {
            // The BRS bit begins with an edge to recessive: what was late was missing from it.
            rate.brs_ticks_q20 = rate.brs_ticks_q20.saturating_add_signed(moved);
        }
    }

    fn verdict(&self) -> Verdict {
        let Some(nominal) = self.nominal.bit_time() else {
            return Verdict::Undecided(Need::CleanFrame);
        };
        if self.proof_bits < PROOF_BITS_MIN || nominal.uncertainty_ppb > UNCERTAINTY_MAX_PPB {
            return Verdict::Undecided(Need::AnotherFrame);
        }
        let (nominal, data) = match (self.fd_frames, self.data.bit_time()) {
            (0, _) => (nominal, DataPhase::NoFd),
            (_, None) => (nominal, DataPhase::NeverSwitched),
            (_, Some(bit)) => {
                let (nominal, data) = pool(nominal, bit);
                (nominal, DataPhase::Switched(data))
            }
        };
        if let DataPhase::Switched(bit) = data
            && bit.uncertainty_ppb.max(nominal.uncertainty_ppb) > SWITCHED_UNCERTAINTY_MAX_PPB
        {
            return Verdict::Undecided(Need::AnotherFrame);
        }
        Verdict::Found(Found {
            nominal,
            data,
            proven_frames: self.proven,
            proof_bits: self.proof_bits,
            polarity: self.polarity,
        })
    }

    fn bus_timing(&self) -> BusTiming {
        BusTiming {
            ticks_q20: self.rates.nominal.ticks_q20(),
            data: self.rates.data.map(|data| DataTiming {
                ticks_q20: data.clock.ticks_q20(),
                brs_ticks_q20: data.brs_ticks_q20,
            }),
            fd_crc: self.rates.fd_crc,
            asymmetry_q20: self.rates.late_ticks_q20,
        }
    }
}

/// Whether two measurements may be of one bit time: nearly equal, or no further apart than four
/// standard deviations.
fn may_be_one(first: BitTime, second: BitTime) -> bool {
    let apart = first.ticks_q20.abs_diff(second.ticks_q20);
    if apart <= first.ticks_q20 >> SAME_RATE_SHIFT {
        return true;
    }
    let apart_ppb = u128::from(apart) * 1_000_000_000 / u128::from(first.ticks_q20.max(1));
    let variance = |bit: BitTime| u128::from(bit.uncertainty_ppb) * u128::from(bit.uncertainty_ppb);
    apart_ppb.saturating_pow(2) <= 16 * (variance(first) + variance(second))
}

/// Bits of a frame that check the rest of it.
fn crc_bits(proof: &Proof) -> u32 {
    let data = proof.received.frame.data().len();
    match (proof.received.fd_crc, data) {
        (None, _) => 15,
        (Some(FdCrc::Iso), 0..=16) => 17 + 4,
        (Some(FdCrc::Iso), _) => 21 + 4,
        (Some(FdCrc::NonIso), 0..=16) => 17,
        (Some(FdCrc::NonIso), _) => 21,
    }
}

/// FNV-1a over identifier, DLC and data.
fn hash(frame: &Frame) -> u32 {
    let id = frame.id().raw().to_le_bytes();
    let head = id.iter().chain(core::iter::once(&0)).copied();
    head.chain(core::iter::once(frame.dlc()))
        .chain(frame.data().iter().copied())
        .fold(0x811C_9DC5, |hash: u32, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(first: (u64, u32), second: (u64, u32)) -> bool {
        let bit = |(ticks_q20, uncertainty_ppb)| BitTime { ticks_q20, uncertainty_ppb };
        may_be_one(bit(first), bit(second))
    }

    #[test]
    fn bit_times_are_two_when_they_differ_by_more_than_their_uncertainty() {
        // 1 % apart is one rate, however well it was measured.
        assert!(one((1_000_000, 0), (1_010_000, 0)));
        // 2 % apart at 0.1 % are two.
        assert!(!one((1_000_000, 1_000_000), (1_020_000, 1_000_000)));
        // 1.7 % apart, at 0.6 %: one; at 0.3 %: two.
        assert!(one((2_104_290, 1_121_518), (2_140_496, 5_777_632)));
        assert!(!one((2_104_290, 1_121_518), (2_140_496, 3_000_000)));
        assert!(!one((1, 0), (u64::MAX, u32::MAX)));
        assert!(one((0, 0), (0, 0)));
    }
}
