//! Proof: a proposal counts only when the frame, read at it, has its CRC right.

use super::comb::Slack;
use super::data_rate;
use super::{coarse, comb};
use crate::wire::attempts::placements;
use crate::wire::clock::BitClock;
use crate::wire::reader::{Activity, Outcome, Placement, Rates, Reading, read};
use crate::wire::{FdCrc, Received};

/// Most bit times tried for one frame.
const PROPOSALS_MAX: usize = 48;

/// Bit times to try, in ticks times 2^20, in the order of trying.
#[derive(Debug, Clone)]
pub(super) struct Proposals {
    bits: [u64; PROPOSALS_MAX],
    len: usize,
}

impl Proposals {
    pub(super) const fn new() -> Self {
        Self { bits: [0; PROPOSALS_MAX], len: 0 }
    }

    /// Adds a bit time unless one within `apart` is there, or there is no room.
    pub(super) fn add(&mut self, bit_q20: u64, apart: u64) {
        let known = self.iter().any(|other| other.abs_diff(bit_q20) <= apart);
        if known {
            return;
        }
        if let Some(slot) = self.bits.get_mut(self.len) {
            *slot = bit_q20;
            self.len += 1;
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        self.bits.iter().take(self.len).copied()
    }
}

/// A frame that was read with its CRC right, and at which rates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proof {
    pub(super) rates: Rates,
    pub(super) received: Received,
    pub(super) reading: Reading,
    pub(super) placement: Placement,
    /// Readings whose CRC was compared until one was right.
    pub(super) compared: u32,
}

/// Tries to prove a bit time for `activity`; counts the comparisons of a CRC in `compared`.
pub(super) fn prove(activity: Activity<'_>, compared: &mut u32) -> Option<Proof> {
    let mut proposals = Proposals::new();
    coarse::propose(activity.runs, &mut proposals);
    if let Some(proof) = first_right(activity, &proposals, compared) {
        return Some(proof);
    }
    [Slack::Tight, Slack::Loose].into_iter().find_map(|slack| {
        let mut proposals = Proposals::new();
        comb::propose(activity.runs, slack, &mut proposals);
        first_right(activity, &proposals, compared)
    })
}

fn first_right(activity: Activity<'_>, proposals: &Proposals, compared: &mut u32) -> Option<Proof> {
    proposals.iter().find_map(|bit_q20| {
        let nominal = BitClock::new(bit_q20)?;
        let rates = Rates { nominal, data: None, fd_crc: FdCrc::Iso, late_ticks_q20: 0 };
        prove_at(activity, &rates, compared)
    })
}

/// Reads `activity` at `rates` in every placement; finds the data rate if the frame asks for it.
pub(super) fn prove_at(activity: Activity<'_>, rates: &Rates, compared: &mut u32) -> Option<Proof> {
    for placement in placements(activity, rates) {
        let reading = read(activity, rates, placement);
        *compared += u32::from(reading.crc_compared);
        match reading.outcome {
            Outcome::Frame { received, .. } | Outcome::Unacknowledged { received, .. } => {
                let (rates, compared) = (*rates, *compared);
                return Some(Proof { rates, received, reading, placement, compared });
            }
            Outcome::DataRateWanted { brs_run } => {
                if let Some(proof) = data_rate::prove(activity, rates, brs_run, compared) {
                    return Some(proof);
                }
            }
            Outcome::Failed(_) if reading.is_fd && rates.data.is_none() => {
                let rates = Rates { fd_crc: FdCrc::NonIso, ..*rates };
                let reading = read(activity, &rates, placement);
                *compared += u32::from(reading.crc_compared);
                if let Some(received) = reading.proven() {
                    let compared = *compared;
                    return Some(Proof { rates, received, reading, placement, compared });
                }
            }
            Outcome::Failed(_) => {}
        }
    }
    None
}
