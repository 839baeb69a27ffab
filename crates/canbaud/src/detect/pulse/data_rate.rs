//! The data bit time of a CAN FD frame whose nominal bit time is known.
//!
//! The data phase begins inside the BRS bit, at a sample point that nobody knows, and ends inside
//! the CRC delimiter. The edges in between lie on a grid of their own, anchored at the first edge
//! to dominant behind BRS; how many bits the recessive run with BRS holds is tried out.

use super::bit_times::BitTimes;
use super::comb::Slack;
use super::proposals::{Method, Proposals, Tried};
use super::prove::{Attempt, Proof};
use crate::wire::clock::BitClock;
use crate::wire::reader::{Activity, DataRate, Placement, Rates};
use crate::wire::{DataRateWanted, DataTiming, FdCrc};

/// Runs at the end of a frame that are nominal again: CRC delimiter, acknowledge.
const TAIL_RUNS: usize = 2;

/// Answers a decoder that asks for the data rate of a frame; proven by the frame's own CRC.
#[must_use]
pub fn find_data_rate(wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
    let mut compared = 0;
    let proof = prove(wanted.activity, &wanted.rates, wanted.brs_run, &mut compared)?;
    let data = proof.attempt.rates.data?;
    Some(DataTiming { ticks_q20: data.clock.ticks_q20(), brs_ticks_q20: data.brs_ticks_q20 })
}

/// Tries to prove a data bit time; BRS is in the run at `brs_run`.
pub(super) fn prove(
    activity: Activity<'_>,
    rates: &Rates,
    brs_run: usize,
    compared: &mut u32,
) -> Option<Proof> {
    let end = activity.runs.len().saturating_sub(TAIL_RUNS);
    // From the edge to dominant behind BRS on.
    let data_runs = activity.runs.get(brs_run + 1..end)?;
    let brs_ticks = *activity.runs.get(brs_run)?;
    // The data rate is never below the nominal one.
    let nominal_q20 = rates.nominal.ticks_q20();
    let bit_times = BitTimes { min_q20: 0, max_q20: nominal_q20 + nominal_q20 / 50 };
    let mut tried = Tried::new();
    for method in [Method::Coarse, Method::Comb(Slack::Loose)] {
        let mut proposals = Proposals::new(method, data_runs, bit_times);
        while !tried.is_full()
            && let Some(proposal) = proposals.next()
        {
            if tried.enter(proposal).is_none() || proposal.bit_q20 > bit_times.max_q20 {
                continue;
            }
            let Some(clock) = BitClock::new(on_ratio(proposal.bit_q20, nominal_q20)) else {
                continue;
            };
            if let Some(proof) = prove_at(activity, rates, clock, brs_ticks, compared) {
                return Some(proof);
            }
        }
    }
    None
}

/// One oscillator makes both bit times, nearly always in a whole ratio: take it if it is close.
fn on_ratio(data_q20: u64, nominal_q20: u64) -> u64 {
    let ratio = (nominal_q20 + data_q20 / 2) / data_q20.max(1);
    let exact = nominal_q20 / ratio.max(1);
    if exact.abs_diff(data_q20) <= data_q20 / 200 { exact } else { data_q20 }
}

/// Tries the possible numbers of data bits in the run with BRS.
fn prove_at(
    activity: Activity<'_>,
    rates: &Rates,
    clock: BitClock,
    brs_ticks: u32,
    compared: &mut u32,
) -> Option<Proof> {
    let nominal = rates.nominal.ticks_q20();
    let data = clock.ticks_q20();
    let run = u64::from(brs_ticks) << 20;
    // Sample points lie between 50 and 95 %: the BRS bit has at least half a nominal bit and
    // at most all of it but a twentieth, plus half a data bit.
    let shortest = nominal / 2 + data / 20;
    let longest = nominal - nominal / 20 + data / 2;
    let slack = 1 << 20;
    for bits in 0..5 {
        {
            let Some(brs) = run.checked_sub(bits * data) else { break };
            if brs + slack < shortest || brs > longest + slack {
                continue;
            }
            let rate = DataRate { clock, brs_ticks_q20: brs };
            for fd_crc in [FdCrc::Iso, FdCrc::NonIso] {
                for placement in Placement::FEW {
                    let rates = Rates { data: Some(rate), fd_crc, ..*rates };
                    let attempt = Attempt::new(activity, rates, placement);
                    if let Some(proof) = attempt.proof(activity, compared) {
                        return Some(proof);
                    }
                }
            }
        }
    }
    None
}
