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

#[derive(Debug, Clone)]
enum Source<'a> {
    Coarse(Coarse<'a>),
    Comb(Comb<'a>),
    Exhausted,
}

/// A bit time that was tried.
#[derive(Debug, Clone, Copy)]
struct Tried {
    bit_q20: u64,
    /// CRCs that were compared for it.
    chances: u32,
}

/// The bit times that some methods find for a frame, each once.
#[derive(Debug, Clone)]
pub(super) struct Proposals<'a> {
    runs: &'a [u32],
    bit_times: BitTimes,
    /// The methods behind the current one.
    methods: &'static [Method],
    source: Source<'a>,
    tried: [Tried; PROPOSALS_MAX],
    len: usize,
}

impl<'a> Proposals<'a> {
    /// For the frame with these `runs`.
    pub(super) fn new(runs: &'a [u32], methods: &'static [Method], bit_times: BitTimes) -> Self {
        Self {
            runs,
            bit_times,
            methods,
            source: Source::Exhausted,
            tried: [Tried { bit_q20: 0, chances: 0 }; PROPOSALS_MAX],
            len: 0,
        }
    }

    /// The next bit time, in ticks times 2^20.
    pub(super) fn next(&mut self) -> Option<u64> {
        while self.len < PROPOSALS_MAX {
            let (bit_q20, apart) = match &mut self.source {
                Source::Coarse(coarse) => match coarse.next() {
                    Some(bit_q20) => (bit_q20, bit_q20 / 1000),
                    None => {
                        self.source = Source::Exhausted;
                        continue;
                    }
                },
                Source::Comb(comb) => match comb.next() {
                    Some(bit_q20) => (bit_q20, comb.apart_q20(bit_q20)),
                    None => {
                        self.source = Source::Exhausted;
                        continue;
                    }
                },
                Source::Exhausted => {
                    self.enter_method()?;
                    continue;
                }
            };
            let tried = self.tried.get(..self.len).unwrap_or(&[]);
            if tried.iter().any(|other| other.bit_q20.abs_diff(bit_q20) <= apart) {
                continue;
            }
            if let Some(slot) = self.tried.get_mut(self.len) {
                *slot = Tried { bit_q20, chances: 0 };
                self.len += 1;
            }
            if self.bit_times.allow(self.runs, bit_q20) {
                return Some(bit_q20);
            }
        }
        None
    }

    fn enter_method(&mut self) -> Option<()> {
        let (&method, rest) = self.methods.split_first()?;
        self.methods = rest;
        self.source = match method {
            Method::Coarse => Source::Coarse(Coarse::new(self.runs, self.bit_times)),
            Method::Comb(slack) => Source::Comb(Comb::new(self.runs, slack, self.bit_times)),
        };
        Some(())
    }

    /// Notes how many CRCs were compared for the bit time that came last.
    pub(super) fn note_chances(&mut self, chances: u32) {
        if let Some(last) = self.len.checked_sub(1).and_then(|last| self.tried.get_mut(last)) {
            last.chances = chances;
        }
    }

    /// CRCs that were compared for bit times up to `apart` from `bit_q20`.
    pub(super) fn chances_near(&self, bit_q20: u64, apart: u64) -> u32 {
        let tried = self.tried.get(..self.len).unwrap_or(&[]);
        let near = tried.iter().filter(|tried| tried.bit_q20.abs_diff(bit_q20) <= apart);
        near.map(|tried| tried.chances).sum()
    }
}
