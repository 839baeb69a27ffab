//! Verdict and evidence of one channel to its report.

use canbaud::detect::{BitTime, DataPhase, Measurement, Need, Phase, Verdict};
use canbaud::rates::{self, KnownRate};
use canbaud::units::Timebase;
use canbaud::wire::Polarity;
use canbaud_capture::{Channel, ChannelKind};

use super::caveats;
use super::channel::ChannelJudge;
use crate::output::bitrate;
use crate::report::{ChannelReport, Outcome, Rate};

/// Intermission, in bits: belongs to a frame when the load of a bus is told.
const INTERMISSION_BITS: f64 = 3.0;

/// Ticks of a judge as seconds and bit rates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    timebase: Timebase,
}

impl Scale {
    pub(super) fn seconds(self, ticks: f64) -> f64 {
        ticks * (self.timebase.seconds() as f64 / self.timebase.ticks() as f64)
    }

    pub(super) fn rate(self, bit: BitTime, table: &'static [KnownRate]) -> Option<Rate> {
        let millibits = bit.millibits_per_second(self.timebase)?;
        let known = rates::nearest(table, millibits, bit.uncertainty_ppb);
        let rounded = u32::try_from((millibits + 500) / 1000).ok()?;
        Some(Rate {
            bitrate: known.map_or(rounded, |known| known.bitrate().bits_per_second()),
            measured: millibits as f64 / 1000.0,
            uncertainty_ppm: f64::from(bit.uncertainty_ppb) / 1000.0,
            known_as: known.map(KnownRate::users),
        })
    }
}

/// The report on `channel`.
pub(super) fn report(
    channel: &Channel,
    judge: &mut ChannelJudge,
    notes: &[String],
) -> ChannelReport {
    judge.conclude(&mut |_| {});
    let scale = Scale { timebase: judge.grid().timebase };
    let evidence = &judge.evidence;
    let good = evidence.counts.good();
    let (nominal, data) = match (judge.is_given(), good) {
        (true, 0) => (None, None),
        _ => measured(judge),
    };
    let outcome = match judge.verdict() {
        Some(Verdict::Conflict { .. }) => Outcome::Conflict,
        _ if good > 0 => Outcome::Found,
        // One frame that nobody acknowledged is no frame to a receiver, but proves the rate.
        Some(Verdict::Found(_)) if !judge.is_given() => Outcome::Found,
        _ if judge.facts.edges == 0 => Outcome::NoTraffic,
        _ => Outcome::Undecided,
    };
    let other = match judge.verdict() {
        Some(Verdict::Conflict { phase: Phase::Nominal, second, .. }) => {
            scale.rate(second, rates::nominal())
        }
        Some(Verdict::Conflict { phase: Phase::Data, second, .. }) => {
            scale.rate(second, rates::data())
        }
        _ => None,
    };
    let duration_s = scale.seconds(judge.facts.ticks as f64);
    let bit_s = nominal.map(|bit| scale.seconds(bit.ticks_q20 as f64 / f64::from(1 << 20)));
    let busy = scale.seconds(evidence.busy_ticks as f64)
        + INTERMISSION_BITS * bit_s.unwrap_or(0.0) * good as f64;
    let asymmetry = evidence.nominal.asymmetry_q8() as f64 / 256.0;
    let resolution = channel.resolution_ticks as f64 / judge.grid().divisor as f64;
    let shortest = judge.facts.shortest.map(|ticks| scale.seconds(ticks as f64));
    let mut report = ChannelReport {
        channel: channel.name.clone(),
        inverted: judge.polarity() == Some(Polarity::Inverted),
        outcome,
        need: (outcome == Outcome::Undecided).then(|| need(judge, scale, shortest, duration_s)),
        nominal: nominal.and_then(|bit| scale.rate(bit, rates::nominal())),
        data: data.and_then(|bit| scale.rate(bit, rates::data())),
        other,
        proven_frames: if judge.is_given() { good } else { good.max(proven(judge)) },
        frames: evidence.counts,
        error_probability: error_probability(judge),
        bus_load: if duration_s > 0.0 { (busy / duration_s).min(1.0) } else { 0.0 },
        asymmetry_ns: nominal.map(|_| scale.seconds(asymmetry) * 1e9),
        clock_spread_ppm: evidence.clock_spread_ppm(),
        samples_per_bit: bit_s.map(|bit| bit / scale.seconds(resolution)),
        duration_s,
        edges: judge.facts.edges,
        caveats: Vec::new(),
    };
    report.caveats = caveats::of(&report, judge, channel, notes);
    report
}

/// The bit times: from all decoded frames, or from the detector where it alone saw frames.
fn measured(judge: &ChannelJudge) -> (Option<BitTime>, Option<BitTime>) {
    let evidence = &judge.evidence;
    let (found_nominal, found_data) = match judge.verdict() {
        Some(Verdict::Found(found)) => (
            Some(found.nominal),
            match found.data {
                DataPhase::Switched(bit) => Some(bit),
                DataPhase::NoFd | DataPhase::NeverSwitched => None,
            },
        ),
        Some(Verdict::Conflict { phase: Phase::Nominal, first, .. }) => (Some(first), None),
        Some(Verdict::Conflict { phase: Phase::Data, first, .. }) => (None, Some(first)),
        _ => (None, None),
    };
    // Of few frames the detector knows more than their sums tell: the bounds of single edges.
    let better = |all: &Measurement, found: Option<BitTime>| match (all.bit_time(), found) {
        (Some(all), Some(found)) if all.uncertainty_ppb > found.uncertainty_ppb => Some(found),
        (Some(_), Some(found)) if judge.evidence.counts.good() <= 1 => Some(found),
        (all, found) => all.or(found),
    };
    (better(&evidence.nominal, found_nominal), better(&evidence.data, found_data))
}

fn proven(judge: &ChannelJudge) -> u64 {
    match judge.verdict() {
        Some(Verdict::Found(found)) => u64::from(found.proven_frames),
        _ => 0,
    }
}

/// Chances that were taken until the first frame, in bits, where the detector does not say.
const CHANCES_BITS: u32 = 5;

/// 2 to the power of minus the bits of proof.
fn error_probability(judge: &ChannelJudge) -> f64 {
    let found = match judge.verdict() {
        Some(Verdict::Found(found)) => found.proof_bits,
        _ => 0,
    };
    let bits = match judge.evidence.counts.good() {
        0 | 1 => found,
        _ => judge.evidence.proof_bits.saturating_sub(CHANCES_BITS).max(found),
    };
    0.5_f64.powi(i32::try_from(bits).unwrap_or(1000).min(1000))
}

/// Half a bit at 8 Mbit/s.
const FINE_ENOUGH_S: f64 = 62.5e-9;

/// What an undecided channel lacks.
fn need(judge: &ChannelJudge, scale: Scale, shortest_s: Option<f64>, duration_s: f64) -> String {
    let coarse = judge.facts.shortest.is_some_and(|ticks| ticks <= 2);
    // The longest classic frame has about 150 bits; the shortest run is one bit, or a tick of it.
    let frame_s = shortest_s.map_or(0.0, |bit| 160.0 * bit);
    match judge.verdict() {
        verdict if judge.is_given() => {
            let proven = match verdict {
                Some(Verdict::Found(found)) => scale.rate(found.nominal, rates::nominal()),
                _ => None,
            };
            match proven {
                Some(rate) => format!(
                    "no frame fits the given bit rate; the edges prove {}",
                    bitrate(rate.bitrate)
                ),
                None => {
                    "no frame fits the given bit rate: leave it out to have it found".to_owned()
                }
            }
        }
        Some(Verdict::Undecided(Need::AnotherFrame)) => {
            "one frame fits a rate, but proves too little: capture another, different frame"
                .to_owned()
        }
        Some(Verdict::Undecided(Need::CompleteFrame)) if duration_s > 4.0 * frame_s => {
            "no complete frame between two stretches of idle: a stuck line or no CAN bus; check \
             the probe"
                .to_owned()
        }
        Some(Verdict::Undecided(Need::CompleteFrame)) => {
            let more = (frame_s - duration_s).max(frame_s / 2.0);
            format!(
                "no complete frame between two stretches of idle: capture {} more",
                milliseconds(more)
            )
        }
        // A recorder that resolves 8 Mbit/s is fine enough for any bus.
        _ if coarse && shortest_s.is_some_and(|bit| bit > FINE_ENOUGH_S) => format!(
            "no frame fits, and runs of one or two samples may be bits: sample at >= {}",
            hertz(8.0 / shortest_s.unwrap_or(1.0))
        ),
        _ => "no frame with a right CRC at any bit rate: noise, another kind of bus, or a poor \
              contact; check the probe and capture again"
            .to_owned(),
    }
}

fn milliseconds(seconds: f64) -> String {
    let ms = seconds * 1e3;
    if ms >= 10.0 { format!("{ms:.0} ms") } else { format!("{:.1} ms", ms.max(0.1)) }
}

fn hertz(frequency: f64) -> String {
    if frequency >= 1e6 {
        format!("{:.0} MHz", (frequency / 1e6).ceil())
    } else {
        format!("{:.0} kHz", (frequency / 1e3).ceil())
    }
}

/// What speaks for a channel to be the one that carries the bus, the strongest first.
pub(super) fn rank(report: &ChannelReport, judge: &ChannelJudge) -> (u8, u64, u8, u64) {
    let outcome = match report.outcome {
        Outcome::Found => 3,
        Outcome::Conflict => 2,
        Outcome::Undecided => 1,
        Outcome::NoTraffic => 0,
    };
    let clean = u8::from(report.frames.error == 0);
    (outcome, report.proven_frames.max(proven(judge)), clean, report.edges)
}

/// Whether a channel is computed from two others.
pub(super) const fn is_difference(channel: &Channel) -> bool {
    matches!(channel.kind, ChannelKind::Difference(..))
}
