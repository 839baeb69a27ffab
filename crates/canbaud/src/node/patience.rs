//! How long a node waits: for a sign of life on a silent bus, and for a controller that refuses.

use super::settings::{Settings, Silence};
use crate::lss::RateSetting;
use crate::units::{Bitrate, Micros};

/// How long a device with a fixed rate that did not fit listens on a silent bus before it takes
/// part at that rate again, and how much longer at random.
const FIXED_SILENCE: Micros = Micros::from_ms(1000);
/// A wait doubles with each attempt in vain, up to 64 times.
const DOUBLINGS_MAX: u32 = 6;
/// How long after a refusal the controller is asked again.
const ASK_AGAIN: Micros = Micros::from_ms(50);
/// Refusals in a row after which a slave that was to take part, or to recover, detects instead.
const REFUSALS_MAX: u32 = 3;

fn doubled(wait: Micros, times: u32) -> Micros {
    wait.times(1 << times.min(DOUBLINGS_MAX))
}

/// When the silence of a bus is broken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    at: Option<Micros>,
    /// How often it was broken since a frame was received or sent.
    breaks: u32,
    random: u64,
}

impl Patience {
    pub(super) const fn new(seed: u64) -> Self {
        Self { at: None, breaks: 0, random: seed }
    }

    /// When the silence is to be broken if nothing is heard from `now` on.
    pub(super) fn plan(&mut self, now: Micros, settings: &Settings) {
        let (after, spread) = match (settings.rate, settings.silence) {
            (_, Silence::Break { after, spread, .. }) => (after, spread),
            (RateSetting::Fixed(_), Silence::Wait) => (FIXED_SILENCE, FIXED_SILENCE),
            (RateSetting::Automatic, Silence::Wait) => return,
        };
        // SplitMix64.
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.random;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^= mixed >> 31;
        let random = Micros(((u128::from(mixed) * u128::from(spread.0)) >> 64) as u64);
        self.at = Some(now + doubled(after + random, self.breaks));
    }

    /// Nothing is planned any more.
    pub(super) const fn cancel(&mut self) {
        self.at = None;
    }

    pub(super) const fn deadline(&self) -> Option<Micros> {
        self.at
    }

    /// Whether it is time. That counts until something good comes: whatever it ends with, the next
    /// wait is longer.
    pub(super) fn is_over(&mut self, now: Micros) -> bool {
        let over = self.at.is_some_and(|at| at <= now);
        self.breaks = self.breaks.saturating_add(u32::from(over));
        over
    }

    /// A frame was received or sent.
    pub(super) const fn renew(&mut self) {
        self.breaks = 0;
    }
}

/// What the controller refuses.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Refusal {
    /// In a row.
    times: u32,
    waits: Option<(Bitrate, Micros)>,
}

impl Refusal {
    /// It has refused `rate`; the first `at_once` times it is asked again without a wait.
    pub(super) fn note(&mut self, now: Micros, rate: Option<Bitrate>, at_once: u32) {
        self.times = self.times.saturating_add(1);
        let late = self.times.saturating_sub(at_once);
        self.waits = match (rate, late) {
            (Some(rate), 1..) => Some((rate, now + doubled(ASK_AGAIN, late - 1))),
            _ => None,
        };
    }

    /// Whether it goes on so long that the rate itself is in doubt.
    pub(super) const fn is_stubborn(&self) -> bool {
        self.times >= REFUSALS_MAX
    }

    /// What is refused and waits to be asked for again.
    pub(super) const fn rate(&self) -> Option<Bitrate> {
        match self.waits {
            Some((rate, _)) => Some(rate),
            None => None,
        }
    }

    /// When the controller may be asked again.
    pub(super) const fn over(&self) -> Micros {
        match self.waits {
            Some((_, again)) => again,
            None => Micros(0),
        }
    }
}
