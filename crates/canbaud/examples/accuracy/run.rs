//! Runs trials on all cores.

use crate::args::{Args, Detector};
use crate::support::bound::{Bound, Estimate};
use crate::support::interval::feasible;
use crate::support::judge::{Judgement, TrueData, Truth, judge};
use crate::support::line::{Phase, Recording};
use crate::support::trial::Trial;
use crate::tally::Tally;
use canbaud::detect::{BitTime, DataPhase, Found, Need, PulseDetector, Verdict};
use std::sync::atomic::{AtomicU64, Ordering};

/// Pulses that the measured detector can hold.
const PULSES: usize = 800;

/// Trials that a thread takes at once.
const CHUNK: u64 = 256;

/// One trial with everything that came out of it.
#[derive(Clone)]
pub(crate) struct Outcome {
    pub(crate) number: u64,
    pub(crate) trial: Trial,
    pub(crate) recording: Recording,
    pub(crate) bound: Bound,
    pub(crate) verdict: Verdict,
    pub(crate) judgement: Judgement,
}

/// Runs trial `number`.
pub(crate) fn one(args: &Args, number: u64) -> Outcome {
    let trial = Trial::draw(args.seed, number, args.scene(number), args.resolution);
    let recording = trial.record();
    let bound = Bound::of(&recording.edges, trial.edge_noise());
    let verdict = match args.detector {
        Detector::Pulse => pulse(&recording),
        Detector::LeastSquares => informed(&trial, bound.nominal, bound.data),
        Detector::Interval => {
            let nominal = middle(&recording, Phase::Nominal);
            informed(&trial, nominal, middle(&recording, Phase::Data))
        }
    };
    let judgement = judge(&trial.truth(), &verdict, args.tolerance_ppm);
    Outcome { number, trial, recording, bound, verdict, judgement }
}

/// Runs trials 0 to `args.trials`.
pub(crate) fn all(args: &Args) -> Tally {
    let next = AtomicU64::new(0);
    let work = || {
        let mut tally = Tally::default();
        loop {
            let first = next.fetch_add(CHUNK, Ordering::Relaxed);
            if first >= args.trials {
                return tally;
            }
            for number in first..args.trials.min(first + CHUNK) {
                tally.add(&one(args, number), args);
            }
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..args.threads).map(|_| scope.spawn(work)).collect();
        let mut total = Tally::default();
        for thread in threads {
            match thread.join() {
                Ok(tally) => total.merge(tally, args),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        total
    })
}

/// The detector that this program measures.
fn pulse(recording: &Recording) -> Verdict {
    let mut detector = PulseDetector::<PULSES>::new();
    detector.begin(recording.begin, recording.initial);
    for edge in &recording.edges {
        detector.push(edge.at);
    }
    detector.finish(recording.finish);
    detector.verdict()
}

/// What somebody would say who knows the bit number of every edge.
fn informed(trial: &Trial, nominal: Option<Estimate>, data: Option<Estimate>) -> Verdict {
    let Truth::Bus { data: true_data, polarity, .. } = trial.truth() else {
        return Verdict::NoTraffic;
    };
    let Some(nominal) = nominal else {
        return Verdict::Undecided(Need::CleanFrame);
    };
    let data = match (true_data, data) {
        (TrueData::Classic, _) => DataPhase::NoFd,
        (TrueData::NeverSwitched, _) => DataPhase::NeverSwitched,
        (TrueData::Switched(_), Some(data)) => DataPhase::Switched(bit_time(data)),
        (TrueData::Switched(_), None) => return Verdict::Undecided(Need::CleanFrame),
    };
    let nominal = bit_time(nominal);
    Verdict::Found(Found { nominal, data, proven_frames: 1, proof_bits: 0, polarity })
}

/// The middle of the feasible bit times.
fn middle(recording: &Recording, phase: Phase) -> Option<Estimate> {
    let (least, greatest) = feasible(&recording.edges, phase)?;
    Some(Estimate { ticks: (least + greatest) / 2.0, sigma: (greatest - least) / 12_f64.sqrt() })
}

fn bit_time(estimate: Estimate) -> BitTime {
    BitTime {
        ticks_q20: (estimate.ticks * f64::from(1 << 20)).round() as u64,
        uncertainty_ppb: (estimate.sigma / estimate.ticks * 1e9) as u32,
    }
}
