//! A solver that shares nothing with the one in the library: it tries every prescaler with every
//! pair of segments and compares fractions in 128 bits.

use canbaud::timing::{Limits, SamplePointPolicy};

/// What a brute force found best: prescaler, quanta and TSEG2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Best {
    pub(crate) prescaler: u32,
    pub(crate) quanta: u32,
    pub(crate) tseg2: u32,
}

/// Every pair of segments that the limits allow, grouped by the number of quanta.
pub(crate) struct Segments {
    by_quanta: Vec<(u32, Vec<u32>)>,
    prescalers: Vec<u32>,
    divider: u32,
}

impl Segments {
    pub(crate) fn new(limits: &Limits) -> Self {
        let mut by_quanta: Vec<(u32, Vec<u32>)> = Vec::new();
        for tseg2 in limits.tseg2.min..=limits.tseg2.max {
            for tseg1 in limits.tseg1.min..=limits.tseg1.max {
                if !is_allowed(limits, tseg1, tseg2) {
                    continue;
                }
                let (quanta, tseg2) = (1 + u32::from(tseg1) + u32::from(tseg2), u32::from(tseg2));
                match by_quanta.iter_mut().find(|(n, _)| *n == quanta) {
                    Some((_, list)) => list.push(tseg2),
                    None => by_quanta.push((quanta, vec![tseg2])),
                }
            }
        }
        let prescalers =
            (1..=u16::MAX).filter(|p| limits.prescalers.contains(*p)).map(u32::from).collect();
        Self { by_quanta, prescalers, divider: u32::from(limits.clock_divider) }
    }

    /// All pairs of prescaler and quanta with the smallest rate error.
    pub(crate) fn nearest_rates(&self, clock: u64, bitrate: u32) -> Vec<(u32, usize)> {
        let mut best: Vec<(u32, usize)> = Vec::new();
        let mut best_error = (u128::MAX, 1_u128);
        for &prescaler in &self.prescalers {
            for (index, (quanta, _)) in self.by_quanta.iter().enumerate() {
                let product = u128::from(prescaler) * u128::from(*quanta);
                let exact = u128::from(bitrate) * u128::from(self.divider) * product;
                let error = (u128::from(clock).abs_diff(exact), product);
                if best.is_empty() || error.0 * best_error.1 < best_error.0 * error.1 {
                    best_error = error;
                    best.clear();
                }
                if error.0 * best_error.1 == best_error.0 * error.1 {
                    best.push((prescaler, index));
                }
            }
        }
        best
    }

    /// The best of those: sample point error, more quanta, longer TSEG2, smaller prescaler.
    pub(crate) fn best(
        &self,
        rates: &[(u32, usize)],
        point: u32,
        policy: SamplePointPolicy,
    ) -> Option<Best> {
        let mut best: Option<Best> = None;
        for &(prescaler, index) in rates {
            let (quanta, list) = &self.by_quanta[index];
            for &tseg2 in list {
                let candidate = Best { prescaler, quanta: *quanta, tseg2 };
                if !is_in_policy(candidate, point, policy) {
                    continue;
                }
                if best.is_none_or(|b| is_better(candidate, b, point)) {
                    best = Some(candidate);
                }
            }
        }
        best
    }

    /// As `nearest_rates` with `best`, when the policy decides which rates are reachable at all.
    pub(crate) fn best_in_policy(
        &self,
        clock: u64,
        bitrate: u32,
        point: u32,
        policy: SamplePointPolicy,
    ) -> Option<Best> {
        let mut usable = Self {
            by_quanta: self.by_quanta.clone(),
            prescalers: self.prescalers.clone(),
            divider: self.divider,
        };
        for (quanta, list) in &mut usable.by_quanta {
            list.retain(|tseg2| {
                is_in_policy(Best { prescaler: 1, quanta: *quanta, tseg2: *tseg2 }, point, policy)
            });
        }
        usable.by_quanta.retain(|(_, list)| !list.is_empty());
        let rates = usable.nearest_rates(clock, bitrate);
        usable.best(&rates, point, policy)
    }

    /// Clock periods in a bit with this setting.
    pub(crate) fn divisor(&self, best: Best) -> u64 {
        u64::from(best.prescaler) * u64::from(best.quanta) * u64::from(self.divider)
    }
}

fn is_allowed(limits: &Limits, tseg1: u16, tseg2: u16) -> bool {
    let (tseg1, tseg2) = (i64::from(tseg1), i64::from(tseg2));
    let quanta = 1 + tseg1 + tseg2;
    let splits = (i64::from(limits.prop_seg.min)..=i64::from(limits.prop_seg.max).min(tseg1)).any(
        |prop_seg| {
            let phase_seg1 = tseg1 - prop_seg;
            phase_seg1 >= i64::from(limits.phase_seg1.min)
                && phase_seg1 <= i64::from(limits.phase_seg1.max)
        },
    );
    splits
        && quanta >= i64::from(limits.bit_quanta.min)
        && quanta <= i64::from(limits.bit_quanta.max)
        && limits.rules.tseg1_excess_min.is_none_or(|excess| tseg1 - tseg2 >= i64::from(excess))
}

fn is_in_policy(setting: Best, point: u32, policy: SamplePointPolicy) -> bool {
    let actual = 1000 * (setting.quanta - setting.tseg2);
    let at = |permille: u32| permille * setting.quanta;
    match policy {
        SamplePointPolicy::Nearest => true,
        SamplePointPolicy::NotLater => actual <= at(point),
        SamplePointPolicy::NotEarlier => actual >= at(point),
        SamplePointPolicy::Within { earliest, latest } => {
            actual >= at(u32::from(earliest.permille()))
                && actual <= at(u32::from(latest.permille()))
        }
    }
}

fn is_better(a: Best, b: Best, point: u32) -> bool {
    let error = |s: Best| u128::from((1000 * (s.quanta - s.tseg2)).abs_diff(point * s.quanta));
    let (left, right) = (error(a) * u128::from(b.quanta), error(b) * u128::from(a.quanta));
    (left, b.quanta, b.tseg2, a.prescaler) < (right, a.quanta, a.tseg2, b.prescaler)
}

/// 30 clocks from 4 MHz to 170 MHz: crystals, PLL outputs, and awkward ones.
#[rustfmt::skip]
pub(crate) const CLOCKS: [u64; 30] = [
    4_000_000, 5_000_000, 8_000_000, 10_000_000, 12_000_000, 16_000_000, 20_000_000, 24_000_000,
    25_000_000, 30_000_000, 32_000_000, 36_000_000, 40_000_000, 42_000_000, 45_000_000, 48_000_000,
    50_000_000, 54_000_000, 60_000_000, 64_000_000, 66_666_666, 72_000_000, 80_000_000, 83_368_421,
    100_000_000, 120_000_000, 125_000_000, 150_000_000, 160_000_000, 170_000_000,
];

/// 25 bit rates from 5 kbit/s to 8 Mbit/s, usual and odd.
#[rustfmt::skip]
pub(crate) const BITRATES: [u32; 25] = [
    5_000, 10_000, 20_000, 33_333, 40_000, 50_000, 62_500, 83_333, 95_238, 100_000, 125_000,
    200_000, 250_000, 400_000, 500_000, 615_384, 666_666, 800_000, 1_000_000, 1_500_000,
    2_000_000, 4_000_000, 5_000_000, 6_666_666, 8_000_000,
];

/// Four sample points in thousandths.
pub(crate) const POINTS: [u32; 4] = [600, 750, 800, 875];
