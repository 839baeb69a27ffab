//! Bit times to try for one frame, one after the other.

use super::bit_times::BitTimes;
use super::coarse::Coarse;
use super::comb::{Comb, Slack};

/// Most bit times tried for one frame.
const PROPOSALS_MAX: usize = 48;

/// A way to find bit times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    Coarse,
    Comb(Slack),
}

/// A bit time that one of the methods found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proposal {
    /// In ticks times 2^20.
    pub(super) bit_q20: u64,
    /// Another one this near is the same.
    apart_q20: u64,
}

/// The bit times that one method finds.
#[derive(Debug, Clone)]
pub(super) enum Proposals<'a> {
    Coarse(Coarse<'a>),
    Comb(Comb<'a>),
}

impl<'a> Proposals<'a> {
    /// For the frame with these `runs`.
    pub(super) fn new(method: Method, runs: &'a [u32], bit_times: BitTimes) -> Self {
        match method {
            Method::Coarse => Self::Coarse(Coarse::new(runs, bit_times)),
            Method::Comb(slack) => Self::Comb(Comb::new(runs, slack, bit_times)),
        }
    }

    /// The next one.
    pub(super) fn next(&mut self) -> Option<Proposal> {
        match self {
            Self::Coarse(coarse) => {
                coarse.next().map(|bit_q20| Proposal { bit_q20, apart_q20: bit_q20 / 1000 })
            }
            Self::Comb(comb) => {
                comb.next().map(|bit_q20| Proposal { bit_q20, apart_q20: comb.apart_q20(bit_q20) })
            }
        }
    }
}

/// The bit times that were tried for a frame, each once.
#[derive(Debug, Clone)]
pub(super) struct Tried {
    bits_q20: [u64; PROPOSALS_MAX],
    /// CRCs that were compared for each.
    chances: [u32; PROPOSALS_MAX],
    len: usize,
}

impl Tried {
    pub(super) const fn new() -> Self {
        Self { bits_q20: [0; PROPOSALS_MAX], chances: [0; PROPOSALS_MAX], len: 0 }
    }

    /// Whether there is no room for more.
    pub(super) const fn is_full(&self) -> bool {
        self.len == PROPOSALS_MAX
    }

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    /// Enters one that is to be tried and gives its index; `None` if it was tried before.
    pub(super) fn enter(&mut self, proposal: Proposal) -> Option<usize> {
        let mut known = self.bits_q20.iter().take(self.len);
        if known.any(|known| known.abs_diff(proposal.bit_q20) <= proposal.apart_q20) {
            return None;
        }
        let index = self.len;
        *self.bits_q20.get_mut(index)? = proposal.bit_q20;
        self.len += 1;
        Some(index)
    }

    /// The bit time at `index`.
    pub(super) fn bit_q20(&self, index: usize) -> Option<u64> {
        self.bits_q20.get(index).copied()
    }

    /// Notes that so many CRCs were compared for the bit time at `index`.
    pub(super) fn add_chances(&mut self, index: usize, chances: u32) {
        if let Some(slot) = self.chances.get_mut(index) {
            *slot += chances;
        }
    }

    /// CRCs that were compared for bit times up to `apart_q20` from `bit_q20`.
    pub(super) fn chances_near(&self, bit_q20: u64, apart_q20: u64) -> u32 {
        let tried = self.bits_q20.iter().zip(&self.chances).take(self.len);
        let near = tried.filter(|(known, _)| known.abs_diff(bit_q20) <= apart_q20);
        near.map(|(_, chances)| chances).sum()
    }
}
