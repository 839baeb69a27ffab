//! The sample grid behind edge times, for files that do not say their sample rate.

use canbaud::units::Timebase;

use crate::number::gcd;

/// Fewer edges than this prove no grid.
const MIN_EDGES: usize = 16;

/// Sample rates of the common logic analysers whose period is no whole number of nanoseconds.
const RATES: [u64; 12] = [
    3_000_000,
    6_000_000,
    12_000_000,
    16_000_000,
    24_000_000,
    32_000_000,
    48_000_000,
    64_000_000,
    78_125_000,
    80_000_000,
    156_250_000,
    312_500_000,
];

/// The quantisation step of rising times in ticks, at least 1; `times` count from a sample.
///
/// The step must be at most half the shortest pulse: edges of a perfect bit clock would otherwise
/// pass the bit time itself off as the sample period.
pub(crate) fn step(times: &[u64], timebase: Timebase) -> u64 {
    let gaps = times.iter().zip(times.iter().skip(1)).map(|(a, b)| b.saturating_sub(*a));
    let Some(shortest) = gaps.filter(|&gap| gap > 0).min() else { return 1 };
    if times.len() < MIN_EDGES {
        return 1;
    }
    let common = times.iter().fold(0, |common, &t| gcd(common, u128::from(t)));
    if common > 1 {
        let common = u64::try_from(common).unwrap_or(1);
        return if common <= shortest / 2 { common } else { 1 };
    }
    let fits = |&rate: &u64| {
        let (ticks, seconds) = (u128::from(timebase.ticks()), u128::from(timebase.seconds()));
        let per_second = u128::from(rate) * seconds;
        // At two ticks a sample and less, rounded times lie on any grid.
        ticks >= 4 * per_second
            && times.iter().all(|&t| {
                let Some(scaled) = u128::from(t).checked_mul(per_second) else { return false };
                let off = scaled % ticks;
                off.min(ticks - off) <= per_second * 51 / 100
            })
    };
    let found = RATES.iter().find(|rate| fits(rate)).map(|rate| {
        let per_second = u128::from(*rate) * u128::from(timebase.seconds());
        u64::try_from(u128::from(timebase.ticks()) / per_second).unwrap_or(1)
    });
    found.filter(|&step| step <= shortest / 2 + 1).unwrap_or(1).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(rate: u128, per_second: u128, samples: &[u128]) -> Vec<u64> {
        samples.iter().map(|n| ((n * per_second * 2 + rate) / (2 * rate)) as u64).collect()
    }

    const SAMPLES: [u128; 20] = [
        100, 148, 199, 247, 301, 350, 402, 449, 500, 548, 601, 653, 701, 749, 850, 899, 1002, 1051,
        1100, 1203,
    ];

    #[test]
    fn whole_periods_are_found_by_their_common_divisor() {
        let ns = Timebase::new(1_000_000_000, 1).unwrap();
        assert_eq!(step(&rounded(8_000_000, 1_000_000_000, &SAMPLES), ns), 125);
    }

    #[test]
    fn rounded_periods_are_found_among_the_known_rates() {
        let ns = Timebase::new(1_000_000_000, 1).unwrap();
        assert_eq!(step(&rounded(24_000_000, 1_000_000_000, &SAMPLES), ns), 41);
        let tenth = Timebase::new(10_000_000_000, 1).unwrap();
        assert_eq!(step(&rounded(24_000_000, 10_000_000_000, &SAMPLES), tenth), 416);
    }

    #[test]
    fn a_perfect_bit_clock_is_no_sample_grid() {
        let ns = Timebase::new(1_000_000_000, 1).unwrap();
        let bits: Vec<u64> = (1..40).map(|n| n * 2000).collect();
        assert_eq!(step(&bits, ns), 1);
        assert_eq!(step(&[1000, 2000, 4000], ns), 1);
    }
}
