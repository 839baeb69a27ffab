//! Runs both detectors over one capture and judges what they say. All arithmetic is in integers.

use canbaud::detect::{BitTime, DataPhase, Found, MinimumPulse, Phase, PulseDetector, Verdict};
use canbaud::wire::{Logic, Polarity};
use canbaud_sim::NodeConfig;
use canbaud_sim::benchmark::{BITRATES, Labelled, Scene, Traffic};

use crate::case::Draw;

/// A bit time further than this from the truth is wrong: half the distance of 615.385 and
/// 625 kbit/s, the nearest rates of the grid.
pub const TOLERANCE_PPM: u128 = 8_000;
/// A recessive time of so many bits is between two attempts to send.
const GAP_BITS: u64 = 9;
/// The recording goes on for so many bits after its last edge.
const TAIL_BITS: u64 = 20;
/// Runs that the detector can hold: enough for all frames.
const RUNS: usize = 800;

/// What somebody said of the rate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The truth.
    Right,
    /// The rate of the babbler, who is on the bus, too.
    Babbler,
    /// Both rates that are on the bus.
    Both,
    /// Nothing.
    None,
    /// Something else, and what.
    Wrong(String),
}

/// What came of one capture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// What `PulseDetector` said, at any time.
    pub answer: Answer,
    /// Bits from the first edge to the last one that the first answer needed, and attempts to
    /// send until then.
    pub decided: Option<Decision>,
    /// What the minimum pulse method said.
    pub minimum: Answer,
    /// The first answer of `PulseDetector`.
    pub first: Option<Verdict>,
    /// The last verdict.
    pub verdict: Verdict,
}

/// When the first answer was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Decision {
    /// Bits on the bus.
    pub bits: u64,
    /// Attempts to send a frame.
    pub attempts: u64,
}

/// What is true of a capture.
struct Truth {
    /// Ticks per bit, times 2^20.
    nominal_q20: u128,
    data_q20: Option<u128>,
    babbler_q20: Option<u128>,
    traffic: Traffic,
    polarity: Polarity,
}

/// Ticks of `timer_hz` per bit of a timing of `periods` clock periods, times 2^20.
fn bit_time(config: &NodeConfig, periods: u32, timer_hz: u64) -> u128 {
    let clock_ppb = 1_000_000_000 + i128::from(config.oscillator.ppb);
    let hertz = u128::from(config.oscillator.hertz) * clock_ppb.unsigned_abs();
    ((u128::from(timer_hz) * u128::from(periods) * 1_000_000_000) << 20) / hertz
}

impl Truth {
    fn of(draw: &Draw, inverted: bool) -> Option<Self> {
        let case = &draw.case;
        let mut config = NodeConfig::at("talker", case.bitrate).ok()?;
        config.oscillator.ppb = i64::from(case.ppm) * 1_000;
        let data_bitrate = match case.traffic {
            Traffic::Classic | Traffic::Fd => None,
            Traffic::FdBrs(rate) | Traffic::FdBrsNonIso(rate) => Some(rate),
        };
        if let Some(rate) = data_bitrate {
            config = config.with_data_bitrate(rate).ok()?;
        }
        let periods = |timing: &canbaud_sim::BitTiming| timing.prescaler() * timing.quanta();
        let babbler = if case.bitrate == 250_000 { 125_000 } else { 250_000 };
        let babbler = NodeConfig::at("babbler", babbler).ok()?;
        let babbler_q20 = bit_time(&babbler, periods(&babbler.nominal), case.timer_hz);
        Some(Self {
            nominal_q20: bit_time(&config, periods(&config.nominal), case.timer_hz),
            data_q20: config.data.map(|data| bit_time(&config, periods(&data), case.timer_hz)),
            babbler_q20: (case.scene == Scene::Babbler).then_some(babbler_q20),
            traffic: case.traffic,
            polarity: if inverted { Polarity::Inverted } else { Polarity::Normal },
        })
    }

    fn judge(&self, verdict: &Verdict) -> Answer {
        match verdict {
            Verdict::Found(found) => self.judge_found(found),
            Verdict::Undecided(_) => Answer::None,
            Verdict::NoTraffic => wrong("no traffic on a busy bus"),
            Verdict::Conflict { phase: Phase::Nominal, first, second } => {
                let is_both = |a: &BitTime, b: &BitTime| {
                    near(a, self.nominal_q20)
                        && self.babbler_q20.is_some_and(|babbler| near(b, babbler))
                };
                if is_both(first, second) || is_both(second, first) {
                    Answer::Both
                } else {
                    wrong("two rates that are not both there")
                }
            }
            Verdict::Conflict { phase: Phase::Data, .. } => {
                wrong("two data rates on a bus that has one")
            }
        }
    }

    fn judge_found(&self, found: &Found) -> Answer {
        if found.polarity != self.polarity {
            return wrong("polarity");
        }
        if !near(&found.nominal, self.nominal_q20) {
            let babbler = self.babbler_q20.is_some_and(|babbler| near(&found.nominal, babbler));
            return if babbler {
                Answer::Babbler
            } else {
                off("nominal rate", &found.nominal, self.nominal_q20)
            };
        }
        match (self.traffic, found.data, self.data_q20) {
            (Traffic::Classic, DataPhase::NoFd, _) | (Traffic::Fd, DataPhase::NeverSwitched, _) => {
                Answer::Right
            }
            (_, DataPhase::Switched(data), Some(truth)) if near(&data, truth) => Answer::Right,
            (_, DataPhase::Switched(data), Some(truth)) => off("data rate", &data, truth),
            _ => wrong("data phase"),
        }
    }
}

/// A measured bit time that is too far off.
fn off(what: &str, measured: &BitTime, truth_q20: u128) -> Answer {
    let apart = u128::from(measured.ticks_q20).abs_diff(truth_q20);
    let parts = apart * 1_000_000 / truth_q20.max(1);
    let stated = measured.uncertainty_ppb / 1_000;
    Answer::Wrong(format!("{what} {parts} ppm off, said to be uncertain by {stated} ppm"))
}

fn wrong(what: &str) -> Answer {
    Answer::Wrong(what.to_owned())
}

fn near(measured: &BitTime, truth_q20: u128) -> bool {
    u128::from(measured.ticks_q20).abs_diff(truth_q20) * 1_000_000 <= truth_q20 * TOLERANCE_PPM
}

/// What comes of `draw`; `None` if no node can have its rates.
#[must_use]
pub fn run(draw: &Draw) -> Option<Outcome> {
    let labelled = draw.case.generate(draw.seed, draw.frames)?;
    let truth = Truth::of(draw, labelled.truth.inverted)?;
    let mut detector = PulseDetector::<RUNS>::new();
    let level = if labelled.starts_high { Logic::High } else { Logic::Low };
    detector.begin(0, level);
    let mut answer = Answer::None;
    let (mut decided, mut first) = (None, None);
    let mut look = |detector: &PulseDetector<RUNS>, seen: usize| {
        let said = match detector.verdict() {
            // A second rate may yet turn out to be an accident.
            Verdict::NoTraffic | Verdict::Conflict { .. } => Answer::None,
            verdict => truth.judge(&verdict),
        };
        if said != Answer::None && decided.is_none() {
            decided = Some(decision(&labelled, &truth, seen));
            first = Some(detector.verdict());
        }
        if matches!(said, Answer::Wrong(_)) && answer == Answer::None {
            answer = said;
        }
    };
    for (seen, (at, _)) in labelled.edges.iter().enumerate() {
        detector.push(*at);
        look(&detector, seen);
    }
    if let Some((last, _)) = labelled.edges.last() {
        detector.finish(last + ticks(TAIL_BITS, &truth));
        look(&detector, labelled.edges.len());
    }
    let verdict = detector.verdict();
    if answer == Answer::None {
        answer = truth.judge(&verdict);
    }
    Some(Outcome { answer, decided, minimum: minimum(draw, &labelled), first, verdict })
}

fn ticks(bits: u64, truth: &Truth) -> u64 {
    ((u128::from(bits) * truth.nominal_q20) >> 20) as u64
}

/// The first answer came with edge `seen`, which ended the gap after what decided.
fn decision(labelled: &Labelled, truth: &Truth, seen: usize) -> Decision {
    let needed = &labelled.edges[..seen];
    let (Some((first, _)), Some((last, _))) = (needed.first(), needed.last()) else {
        return Decision { bits: 0, attempts: 0 };
    };
    let bits = ((u128::from(last - first) << 20) / truth.nominal_q20) as u64;
    let gap = ticks(GAP_BITS, truth);
    let recessive = labelled.starts_high;
    let is_gap = |pair: &[(u64, bool)]| pair[0].1 == recessive && pair[1].0 - pair[0].0 >= gap;
    let gaps = needed.windows(2).filter(|pair| is_gap(pair)).count() as u64;
    Decision { bits, attempts: gaps + 1 }
}

/// AP2925: the shortest of a hundred dominant levels, and the rate of the grid that it is nearest to.
fn minimum(draw: &Draw, labelled: &Labelled) -> Answer {
    let mut minimum = MinimumPulse::new();
    for pair in labelled.edges.windows(2) {
        let (dominant_at, is_high) = pair[0];
        if !is_high {
            minimum.push(u32::try_from(pair[1].0 - dominant_at).unwrap_or(u32::MAX));
        }
    }
    let Some(shortest) = minimum.shortest() else { return Answer::None };
    let distance =
        |bitrate: &u32| (u64::from(shortest) * u64::from(*bitrate)).abs_diff(labelled.timer_hz);
    match BITRATES.into_iter().min_by_key(distance) {
        Some(bitrate) if bitrate == draw.case.bitrate => Answer::Right,
        Some(_) | None => wrong("another rate"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud_sim::benchmark::PLAIN;

    fn draw(text: &str) -> Outcome {
        run(&text.parse().unwrap()).unwrap()
    }

    #[test]
    fn plain_case_is_decided_by_its_first_frame() {
        let outcome = draw("seed=1,frames=12");
        assert_eq!(outcome.answer, Answer::Right);
        let decision = outcome.decided.unwrap();
        assert_eq!(decision.attempts, 1);
        // The shortest frame is 44 bits without its recessive end, the longest 150 with stuff bits.
        assert!((30..=150).contains(&decision.bits), "{decision:?}");
        assert_eq!(outcome.minimum, Answer::Right);
    }

    #[test]
    fn bit_times_are_those_of_the_case() {
        let case = canbaud_sim::benchmark::Case { ppm: 5_000, ..PLAIN };
        let truth = Truth::of(&Draw { case, seed: 1, frames: 1 }, false).unwrap();
        // 16 ticks, 0.5 % less.
        let want = (16_u128 << 20) * 1_000 / 1_005;
        assert!(truth.nominal_q20.abs_diff(want) <= 1);
    }

    #[test]
    fn nothing_is_said_of_too_few_levels_or_too_few_ticks() {
        let outcome = draw("seed=1,frames=1");
        assert_eq!((outcome.answer, outcome.minimum), (Answer::Right, Answer::None));
        let outcome = draw("bitrate=1000000,timer=1000000,seed=1,frames=12");
        assert_eq!((outcome.answer, outcome.decided), (Answer::None, None));
    }

    #[test]
    fn claims_that_are_not_true_are_wrong() {
        let draw = Draw { case: PLAIN, seed: 1, frames: 1 };
        let truth = Truth::of(&draw, false).unwrap();
        let bit = |ticks: u64| BitTime { ticks_q20: ticks << 20, uncertainty_ppb: 0 };
        let found = |nominal, data, polarity| {
            truth.judge(&Verdict::Found(Found {
                nominal,
                data,
                proven_frames: 1,
                proof_bits: 30,
                polarity,
            }))
        };
        let (no_fd, normal) = (DataPhase::NoFd, Polarity::Normal);
        assert_eq!(found(bit(16), no_fd, normal), Answer::Right);
        assert_eq!(found(bit(17), no_fd, normal), off("nominal rate", &bit(17), 16 << 20));
        assert_eq!(found(bit(16), no_fd, Polarity::Inverted), wrong("polarity"));
        let switched = DataPhase::Switched(bit(4));
        assert_eq!(found(bit(16), switched, normal), wrong("data phase"));
        let conflict = |first, second| Verdict::Conflict {
            phase: Phase::Nominal,
            first: bit(first),
            second: bit(second),
        };
        assert!(matches!(truth.judge(&conflict(16, 32)), Answer::Wrong(_)));
        let case = canbaud_sim::benchmark::Case { scene: Scene::Babbler, ..PLAIN };
        let truth = Truth::of(&Draw { case, ..draw }, false).unwrap();
        assert_eq!(truth.judge(&conflict(16, 32)), Answer::Both);
        assert_eq!(truth.judge(&conflict(32, 16)), Answer::Both);
        assert!(matches!(truth.judge(&conflict(16, 64)), Answer::Wrong(_)));
    }

    #[test]
    fn one_rate_that_began_as_two_is_no_conflict() {
        // Two ticks a data bit: a first frame was measured too roughly to be that of the others.
        for text in [
            "bitrate=125000,timer=16000000,traffic=fd-8000000,seed=642507045,frames=12",
            "timer=16000000,traffic=fd-8000000,seed=3980073045,frames=12",
            "bitrate=1000000,timer=2000000,ppm=-3000,seed=3255894867,frames=12",
        ] {
            assert_eq!(draw(text).answer, Answer::Right, "{text}");
        }
    }
}
