//! Proof: a proposal counts only when the frame, read at it, has its CRC right.

use super::bit_times::BitTimes;
use super::comb::Slack;
use super::data_rate;
use super::interval::{self, Interval};
use super::lattice::Stray;
use super::places::Places;
use super::proposals::{Method, Proposals, Tried};
use crate::fixed::div_small;
use crate::wire::attempts::placements;
use crate::wire::clock::BitClock;
use crate::wire::reader::{Activity, Outcome, Placement, Rates, Reading, read};
use crate::wire::{FdCrc, Fit, Received};

/// Two bit times closer than this share of one another are the same rate: 1/64.
pub(super) const SAME_RATE_SHIFT: u32 = 6;

/// The idle around a frame, in ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Idle {
    pub(super) before: u32,
    pub(super) behind: u32,
}

impl Idle {
    /// Whether a frame with `bit_q20` ticks a bit (times 2^20) can stand here.
    pub(super) fn suits(self, bit_q20: u64) -> bool {
        bit_q20 <= self.bit_max_q20()
    }

    /// The longest bit time of a frame here: ten bits are sure before it, rounding may take one;
    /// eight behind it, where an overload flag may follow.
    fn bit_max_q20(self) -> u64 {
        let before = div_small(u64::from(self.before) << 21, 18);
        before.min(div_small(u64::from(self.behind) << 21, 15))
    }
}

/// A frame that was read with its CRC right and its edges on the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proof {
    pub(super) attempt: Attempt,
    pub(super) received: Received,
    /// The nominal edges.
    pub(super) fit: Fit,
    /// Their variance about the grid, in ticks squared times 2^20.
    pub(super) noise_q20: u64,
    /// The bit times that the nominal edges allow.
    pub(super) interval: Option<Interval>,
    /// Readings whose CRC was compared until one was right.
    pub(super) compared: u32,
}

/// One reading, and how it was made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attempt {
    pub(super) rates: Rates,
    pub(super) placement: Placement,
    pub(super) reading: Reading,
}

impl Attempt {
    pub(super) fn new(activity: Activity<'_>, rates: Rates, placement: Placement) -> Self {
        Self { rates, placement, reading: read(activity, &rates, placement) }
    }

    /// The proof, if the edges lie on the grid and the CRC is right.
    ///
    /// Each CRC compared where the edges lie on the grid was one chance to be right by accident.
    pub(super) fn proof(&self, activity: Activity<'_>, compared: &mut u32) -> Option<Proof> {
        if !self.reading.crc_compared {
            return None;
        }
        // The fitted bit time, because the proposed one may drift off over the frame.
        let fit = self.reading.nominal.fit();
        let ticks_q20 = fit.ticks_q20().unwrap_or(self.rates.nominal.ticks_q20());
        let places = Places::nominal(activity, self);
        let stray = Stray::of(&places, ticks_q20);
        if !stray.is_of_a_bus(ticks_q20) {
            return None;
        }
        *compared += 1;
        let received = self.reading.proven()?;
        Some(Proof {
            attempt: *self,
            received,
            fit,
            noise_q20: stray.variance_q20,
            interval: interval::of(&places),
            compared: *compared,
        })
    }
}

/// Tries to prove a bit time for `activity`; counts the comparisons of a CRC in `compared`.
///
/// A frame has its idle around it, so bit times that the idle is too short for are not tried.
pub(super) fn prove(activity: Activity<'_>, idle: Idle, compared: &mut u32) -> Option<Proof> {
    const METHODS: [Method; 3] =
        [Method::Coarse, Method::Comb(Slack::Tight), Method::Comb(Slack::Loose)];
    let bit_times = BitTimes::of(activity.runs, idle.bit_max_q20())?;
    METHODS.into_iter().find_map(|method| first_right(activity, method, bit_times, compared))
}

fn first_right(
    activity: Activity<'_>,
    method: Method,
    bit_times: BitTimes,
    compared: &mut u32,
) -> Option<Proof> {
    let mut proposals = Proposals::new(method, activity.runs, bit_times);
    let mut proposal = proposals.next();
    proposal?;
    let mut tried = Tried::new();
    // The right one is nearly always right at the first placement: that of all comes before the
    // others of any.
    while let Some(next) = proposal
        && !tried.is_full()
    {
        if bit_times.allow(activity.runs, next.bit_q20)
            && let Some(index) = tried.enter(next)
            && let Some(proof) = try_at(activity, Tries::First, &mut tried, index, compared)
        {
            return Some(proof);
        }
        proposal = proposals.next();
    }
    (0..tried.len()).find_map(|index| try_at(activity, Tries::Others, &mut tried, index, compared))
}

/// Tries to prove the bit time at `index` of those `tried`.
fn try_at(
    activity: Activity<'_>,
    tries: Tries,
    tried: &mut Tried,
    index: usize,
    compared: &mut u32,
) -> Option<Proof> {
    let bit_q20 = tried.bit_q20(index)?;
    let rates = Rates {
        nominal: BitClock::new(bit_q20)?,
        data: None,
        fd_crc: FdCrc::Iso,
        late_ticks_q20: 0,
    };
    let before = *compared;
    let mut proof = prove_at(activity, &rates, tries, compared);
    tried.add_chances(index, *compared - before);
    if let Some(proof) = &mut proof {
        // An accident at nearly the same bit time would be no wrong rate.
        let harmless = tried.chances_near(bit_q20, bit_q20 >> SAME_RATE_SHIFT);
        proof.compared = *compared + 1 - harmless;
    }
    proof
}

/// Which placements of the grid to try.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tries {
    First,
    Others,
    All,
}

/// Reads `activity` at `rates` in these placements; finds the data rate if the frame asks for it.
pub(super) fn prove_at(
    activity: Activity<'_>,
    rates: &Rates,
    tries: Tries,
    compared: &mut u32,
) -> Option<Proof> {
    let (skip, take) = match tries {
        Tries::First => (0, 1),
        Tries::Others => (1, usize::MAX),
        Tries::All => (0, usize::MAX),
    };
    for placement in placements(activity, rates).skip(skip).take(take) {
        let attempt = Attempt::new(activity, *rates, placement);
        if let Some(proof) = attempt.proof(activity, compared) {
            return Some(proof);
        }
        if let Outcome::DataRateWanted { brs_run } = attempt.reading.outcome {
            // Another placement would hardly move BRS.
            return data_rate::prove(activity, rates, brs_run, compared);
        } else if attempt.reading.is_fd && rates.data.is_none() {
            let rates = Rates { fd_crc: FdCrc::NonIso, ..*rates };
            let attempt = Attempt::new(activity, rates, placement);
            if let Some(proof) = attempt.proof(activity, compared) {
                return Some(proof);
            }
        }
    }
    None
}
