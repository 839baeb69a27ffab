//! A verdict against the truth.

use canbaud::detect::{BitTime, DataPhase, Found, Need, Verdict};
use canbaud::wire::Polarity;

/// A measured bit time further than this from the truth is wrong, unless told otherwise: half the
/// distance of 615.385 and 625 kbit/s, the nearest rates in use.
pub const TOLERANCE_PPM: f64 = 8000.0;

/// What a recording shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Truth {
    /// A CAN bus.
    Bus {
        /// Nominal bit time in ticks.
        nominal: f64,
        /// The data phase of the frames that are there in full.
        data: TrueData,
        polarity: Polarity,
    },
    /// Some other line: every rate is wrong.
    Foreign,
}

/// The data phase of the frames that are there in full.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrueData {
    Classic,
    NeverSwitched,
    /// Data bit time in ticks.
    Switched(f64),
}

/// The sentence on a verdict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement {
    /// Errors of the bit times, in ticks.
    Right { nominal: f64, data: Option<f64> },
    /// A claim that is not true.
    Wrong(&'static str),
    /// No claim.
    Undecided(Need),
    /// A foreign line, and no claim about it.
    Rejected,
}

/// Ticks per bit as a number.
pub fn ticks(time: BitTime) -> f64 {
    time.ticks_q20 as f64 / (1_u64 << 20) as f64
}

/// Compares `verdict` with `truth`.
pub fn judge(truth: &Truth, verdict: &Verdict, tolerance_ppm: f64) -> Judgement {
    match (truth, verdict) {
        (Truth::Foreign, Verdict::Found(_) | Verdict::Conflict { .. }) => {
            Judgement::Wrong("a rate on a line that is no CAN bus")
        }
        (Truth::Foreign, _) => Judgement::Rejected,
        (Truth::Bus { nominal, data, polarity }, Verdict::Found(found)) => {
            if found.polarity == *polarity {
                judge_found(*nominal, *data, found, tolerance_ppm * 1e-6)
            } else {
                Judgement::Wrong("polarity")
            }
        }
        (Truth::Bus { .. }, Verdict::Undecided(need)) => Judgement::Undecided(*need),
        (Truth::Bus { .. }, Verdict::NoTraffic) => Judgement::Wrong("no traffic on a busy line"),
        (Truth::Bus { .. }, Verdict::Conflict { .. }) => {
            Judgement::Wrong("two rates on a bus that has one")
        }
    }
}

fn judge_found(nominal: f64, data: TrueData, found: &Found, tolerance: f64) -> Judgement {
    let error = ticks(found.nominal) - nominal;
    if error.abs() > nominal * tolerance {
        return Judgement::Wrong("nominal rate");
    }
    match (data, found.data) {
        (TrueData::Classic, DataPhase::NoFd)
        | (TrueData::NeverSwitched, DataPhase::NeverSwitched) => {
            Judgement::Right { nominal: error, data: None }
        }
        (TrueData::Switched(truth), DataPhase::Switched(measured)) => {
            let data_error = ticks(measured) - truth;
            if data_error.abs() > truth * tolerance {
                Judgement::Wrong("data rate")
            } else {
                Judgement::Right { nominal: error, data: Some(data_error) }
            }
        }
        _ => Judgement::Wrong("data phase"),
    }
}
