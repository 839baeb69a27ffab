//! The search for the best prescaler, quanta and sample point.
//!
//! Heads up: read "Why the search is exact and short" in `docs/timing.md` before a change here.

use super::limits::{Bounds, max, min};
use super::rank::Candidate;
use super::{Limits, PrescalerSpan, Request, SamplePointPolicy, Span};

/// Highest clock in Hz that the solver takes: with 31 bits no comparison leaves 64 bits.
pub const CLOCK_MAX: u32 = i32::MAX as u32;

/// The usable sample points: what the limits and the policy leave for each number of quanta.
#[derive(Clone, Copy)]
pub(super) struct Points {
    tseg1: Bounds,
    tseg2: Bounds,
    tseg1_excess_min: Option<i16>,
    /// 1000 - sample point asked for.
    rest: u32,
    window: Option<(u32, u32)>,
}

impl Points {
    pub(super) const fn new(request: &Request, limits: &Limits) -> Self {
        let (tseg1, tseg2) = limits.segments();
        let window = match request.policy {
            SamplePointPolicy::Nearest => None,
            _ => Some(request.window()),
        };
        Self {
            tseg1,
            tseg2,
            tseg1_excess_min: limits.rules.tseg1_excess_min,
            rest: 1000 - request.sample_point.permille() as u32,
            window,
        }
    }

    /// Lowest and highest TSEG2 for this number of quanta.
    pub(super) const fn tseg2_range(&self, quanta: u32) -> Bounds {
        let segments = quanta as i32 - 1;
        let mut low = max(self.tseg2.min, segments - self.tseg1.max);
        let mut high = min(self.tseg2.max, segments - self.tseg1.min);
        if let Some(excess) = self.tseg1_excess_min {
            high = min(high, (segments - excess as i32) >> 1);
        }
        if let Some((earliest, latest)) = self.window {
            low = max(low, (quanta * (1000 - latest)).div_ceil(1000) as i32);
            high = min(high, (quanta * (1000 - earliest) / 1000) as i32);
        }
        Bounds { min: low, max: high }
    }

    /// `|1000 * TSEG2 - quanta * (1000 - SP)|`.
    pub(super) const fn error(&self, quanta: u32, tseg2: u32) -> u32 {
        (1000 * tseg2).abs_diff(quanta * self.rest)
    }

    /// The best TSEG2 for this number of quanta, if there is one.
    pub(super) const fn best(&self, quanta: u32) -> Option<u32> {
        let range = self.tseg2_range(quanta);
        if range.min > range.max {
            return None;
        }
        let ideal = quanta * self.rest;
        let floor = ideal / 1000;
        // Exactly between two, the longer TSEG2 (the earlier sample point) wins.
        let nearest = if (ideal - floor * 1000) * 2 < 1000 { floor } else { floor + 1 };
        Some(max(range.min, min(range.max, nearest as i32)) as u32)
    }

    /// The quanta at both ends of what leaves a sample point; empty if none does.
    pub(super) const fn quanta(&self, limits: &Limits) -> Span {
        let mut quanta = limits.quanta();
        while quanta.min <= quanta.max && self.best(quanta.min as u32).is_none() {
            if quanta.min == quanta.max {
                return Span::new(1, 0);
            }
            quanta.min += 1;
        }
        while quanta.min < quanta.max && self.best(quanta.max as u32).is_none() {
            quanta.max -= 1;
        }
        quanta
    }

    /// Whether some numbers of quanta between the ends may be unusable: two rules pull TSEG2
    /// from both sides.
    const fn is_patchy(&self) -> bool {
        match self.window {
            None | Some((_, 1000)) => false,
            Some((0, _)) => self.tseg1_excess_min.is_some(),
            Some(_) => true,
        }
    }
}

/// The search over the prescalers of one controller phase.
pub(super) struct Search {
    clock: u32,
    /// Bit rate times fixed divider.
    unit: u64,
    pub(super) quanta: Span,
    points: Points,
    pub(super) best: Option<Candidate>,
}

/// One arithmetic progression of prescalers, as multiples `low..=high` of its step.
struct Progression {
    low: u32,
    high: u32,
    step: u32,
    /// Bit rate times fixed divider times step; at most 2/3 of the clock.
    unit: u32,
}

/// The two factors of a division of the clock.
#[derive(Clone, Copy)]
enum Factor {
    Prescaler,
    Quanta,
}

impl Factor {
    /// Prescaler and quanta from the value of this factor and of the other.
    const fn setting(self, step: u32, value: u32, other: u32) -> (u32, u32) {
        match self {
            Self::Prescaler => (value * step, other),
            Self::Quanta => (other * step, value),
        }
    }
}

impl Search {
    pub(super) const fn new(clock: u32, request: &Request, limits: &Limits) -> Self {
        let points = Points::new(request, limits);
        let divider = if limits.clock_divider == 0 { 1 } else { limits.clock_divider };
        Self {
            clock,
            unit: request.bitrate.bits_per_second() as u64 * divider as u64,
            quanta: points.quanta(limits),
            points,
            best: None,
        }
    }

    pub(super) const fn run(&mut self, limits: &Limits) {
        let mut rest: &[PrescalerSpan] = limits.prescalers.spans();
        while let Some((span, others)) = rest.split_first() {
            if let Some(progression) = self.progression(*span) {
                self.search(&progression);
            }
            rest = others;
        }
    }

    /// The progression, unless it is empty or off by more than a factor of two.
    const fn progression(&self, span: PrescalerSpan) -> Option<Progression> {
        let Some((low, high)) = span.multiples() else { return None };
        if self.quanta.min > self.quanta.max {
            return None;
        }
        let unit = self.unit * span.step as u64;
        let smallest = unit.saturating_mul(low as u64).saturating_mul(self.quanta.min as u64);
        let largest = unit.saturating_mul(high as u64).saturating_mul(self.quanta.max as u64);
        let clock = self.clock as u64;
        if smallest > 2 * clock || largest < clock / 2 {
            return None;
        }
        let step = span.step as u32;
        Some(Progression { low: low as u32, high: high as u32, step, unit: unit as u32 })
    }

    /// Finds the best of a progression: small prescalers one by one, for the others small
    /// quanta one by one.
    const fn search(&mut self, progression: &Progression) {
        let ratio = quotient(self.clock, progression.unit);
        let (n_min, n_max) = (self.quanta.min as u32, self.quanta.max as u32);
        if self.points.is_patchy() {
            let useful = quotient(2 * self.clock, progression.unit * progression.low);
            self.scan(progression, Factor::Quanta, n_min, clamp(useful, n_min, n_max));
            return;
        }
        let k_low = clamp(quotient(ratio, n_max), progression.low, progression.high);
        let k_high = clamp(quotient(ratio, n_min) + 1, progression.low, progression.high);
        let n_low = clamp(quotient(ratio, progression.high), n_min, n_max);
        let n_high = clamp(quotient(ratio, progression.low) + 1, n_min, n_max);
        let root = 1_u32 << ((32 - ratio.leading_zeros()) / 2);
        // Whatever has a larger prescaler than `root` has at most this many quanta.
        let n_split = quotient(ratio, root) + 1;
        let (k_split, n_split) = if root >= k_high {
            (k_high, 0)
        } else if root < k_low {
            (0, n_high)
        } else {
            (root, if n_split < n_high { n_split } else { n_high })
        };
        if !self.scan(progression, Factor::Prescaler, k_low, k_split) {
            self.scan(progression, Factor::Quanta, n_low, n_split);
        }
    }

    /// Tries the values of one factor from the finest time quantum on, for each the two values of
    /// the other around the right one. True if a setting was found that nothing else can beat.
    const fn scan(
        &mut self,
        progression: &Progression,
        outer: Factor,
        low: u32,
        high: u32,
    ) -> bool {
        let (inner_min, inner_max) = match outer {
            Factor::Prescaler => (self.quanta.min as u32, self.quanta.max as u32),
            Factor::Quanta => (progression.low, progression.high),
        };
        let mut tried = 0;
        while low + tried <= high {
            let value = match outer {
                Factor::Prescaler => low + tried,
                Factor::Quanta => high - tried,
            };
            let divisor = progression.unit * value;
            let inner = quotient(self.clock, divisor);
            let exact = inner * divisor == self.clock;
            if exact || !self.has_exact() {
                if inner >= inner_min {
                    let inner = if inner < inner_max { inner } else { inner_max };
                    let clocks = inner as u64 * divisor as u64;
                    if self.consider(outer.setting(progression.step, value, inner), clocks) {
                        return true;
                    }
                }
                if inner < inner_max && !exact {
                    let inner = if inner + 1 > inner_min { inner + 1 } else { inner_min };
                    let clocks = inner as u64 * divisor as u64;
                    self.consider(outer.setting(progression.step, value, inner), clocks);
                }
            }
            tried += 1;
        }
        false
    }

    /// Takes the setting if it is better; `clocks` is the clock that would make its rate exact.
    /// True if rate and sample point are exact: what follows in this progression is coarser.
    #[inline]
    const fn consider(&mut self, (prescaler, quanta): (u32, u32), clocks: u64) -> bool {
        if clocks > 2 * self.clock as u64 {
            return false;
        }
        let rate_error = (clocks as u32).abs_diff(self.clock);
        let product = prescaler * quanta;
        if let Some(best) = &self.best
            && rate_error as u64 * best.product as u64 > best.rate_error as u64 * product as u64
        {
            return false;
        }
        let Some(tseg2) = self.points.best(quanta) else { return false };
        let point_error = self.points.error(quanta, tseg2);
        let candidate = Candidate { rate_error, product, point_error, quanta, tseg2, prescaler };
        match &self.best {
            Some(best) if !candidate.beats(best) => {}
            _ => self.best = Some(candidate),
        }
        candidate.is_perfect()
    }

    const fn has_exact(&self) -> bool {
        matches!(&self.best, Some(best) if best.rate_error == 0)
    }
}

/// `a / b` without the panic of a division by 0, which none of the divisors here is.
const fn quotient(a: u32, b: u32) -> u32 {
    match a.checked_div(b) {
        Some(quotient) => quotient,
        None => u32::MAX,
    }
}

const fn clamp(value: u32, low: u32, high: u32) -> u32 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}
