//! From a request to the one best setting.

use super::rank::Candidate;
use super::search::{CLOCK_MAX, Search};
use super::{BitTiming, Limits, Rate, Request, SjwPolicy, SolveError};
use crate::units::{Bitrate, Permille};

/// A setting and what it makes of the request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Solution {
    /// The setting.
    pub timing: BitTiming,
    /// The bit rate that it gives, exactly.
    pub rate: Rate,
    /// The bit rate asked for.
    pub bitrate: Bitrate,
}

impl Solution {
    /// Bit rate error in 10⁻⁹, positive if too fast.
    #[must_use]
    pub const fn bitrate_error_ppb(&self) -> i64 {
        self.rate.error_ppb(self.bitrate)
    }
}

/// Finds the exact optimum: smallest bit rate error, then smallest sample point error, then most
/// time quanta, then the earlier sample point, then the smaller prescaler.
///
/// Takes about `2 * sqrt(clock / bit rate)` divisions of 32 bits.
///
/// ```
/// use canbaud::timing::{controllers::m_can, solve, Request, SolveError};
/// use canbaud::units::{Bitrate, Hertz};
/// let clock = Hertz::new(40_000_000).unwrap();
/// let fast = Request::new(clock, Bitrate::new(8_000_000).unwrap());
/// let solution = solve(&fast, &m_can::DATA).unwrap();
/// assert_eq!((solution.timing.tseg1(), solution.timing.tseg2()), (3, 1)); // 80 %, not 60 %
///
/// let impossible = Request::new(clock, Bitrate::new(12_000_000).unwrap());
/// let error = solve(&impossible, &m_can::DATA).unwrap_err();
/// assert!(matches!(error, SolveError::TooFast { divisor_min: 4, .. }));
/// assert_eq!(error.nearest().unwrap().to_string(), "10M");
/// ```
///
/// # Errors
/// [`SolveError`] names the limit that stands in the way and the nearest reachable rate.
pub const fn solve(request: &Request, limits: &Limits) -> Result<Solution, SolveError> {
    if request.clock.hertz() > CLOCK_MAX as u64 {
        return Err(SolveError::Clock { clock: request.clock, max: CLOCK_MAX });
    }
    let clock = request.clock.hertz() as u32;
    let mut search = Search::new(clock, request, limits);
    search.run(limits);
    match search.best {
        Some(best) if is_close(&best, request, limits) => finish(&best, request, limits),
        best => Err(explain(&search, best, request, limits)),
    }
}

/// Whether the rate error is within the tolerance.
pub(super) const fn is_close(best: &Candidate, request: &Request, limits: &Limits) -> bool {
    let exact = request.bitrate.bits_per_second() as u64 * limits.clock_divider as u64;
    let allowed = exact.saturating_mul(best.product as u64);
    let allowed = allowed.saturating_mul(request.tolerance_ppm as u64);
    best.rate_error as u64 * 1_000_000 <= allowed
}

/// Splits TSEG1 and chooses SJW.
pub(super) const fn finish(
    best: &Candidate,
    request: &Request,
    limits: &Limits,
) -> Result<Solution, SolveError> {
    let tseg1 = best.quanta - 1 - best.tseg2;
    let (prop_seg, phase_seg1) = limits.split(tseg1, best.tseg2);
    let phase_seg2 = best.tseg2 as u16;
    let max = limits.sjw_limit(phase_seg1, phase_seg2);
    let sjw = match request.sjw {
        SjwPolicy::Largest => max,
        SjwPolicy::AtMost(asked) => {
            if asked == 0 {
                1
            } else if asked < max {
                asked
            } else {
                max
            }
        }
        SjwPolicy::Exactly(asked) => {
            if asked == 0 || asked > max {
                return Err(SolveError::Sjw { asked, max });
            }
            asked
        }
    };
    let prescaler = best.prescaler as u16;
    let timing = BitTiming { prescaler, prop_seg, phase_seg1, phase_seg2, sjw };
    let rate = Rate::over(request.clock.hertz(), timing.clocks_per_bit(limits.clock_divider));
    Ok(Solution { timing, rate, bitrate: request.bitrate })
}

/// Names the limit that stands in the way.
const fn explain(
    search: &Search,
    best: Option<Candidate>,
    request: &Request,
    limits: &Limits,
) -> SolveError {
    let all = limits.quanta();
    let prescalers = limits.prescalers.ends();
    if all.min > all.max || prescalers.min > prescalers.max || prescalers.min == 0 {
        return SolveError::Limits;
    }
    if search.quanta.min > search.quanta.max {
        let (earliest, latest) = request.window();
        return SolveError::SamplePoint { earliest: point(earliest), latest: point(latest) };
    }
    let bitrate = request.bitrate;
    let divider = limits.clock_divider as u64;
    let divisor_min = prescalers.min as u64 * search.quanta.min as u64 * divider;
    let divisor_max = prescalers.max as u64 * search.quanta.max as u64 * divider;
    let clock = request.clock.hertz();
    let asked = bitrate.bits_per_second() as u64;
    // Below: 2^32 bit/s times at most 2^49 clocks may leave 64 bits; saturated it is still above.
    if asked.saturating_mul(divisor_min) > clock {
        return SolveError::TooFast {
            bitrate,
            divisor_min,
            nearest: Rate::over(clock, divisor_min),
        };
    }
    if asked.saturating_mul(divisor_max) < clock {
        return SolveError::TooSlow {
            bitrate,
            divisor_max,
            nearest: Rate::over(clock, divisor_max),
        };
    }
    let divisor = match best {
        Some(best) => best.product as u64 * divider,
        None => divisor_max,
    };
    let tolerance_ppm = request.tolerance_ppm;
    SolveError::NotClose { bitrate, nearest: Rate::over(clock, divisor), tolerance_ppm }
}

/// Thousandths that came from a [`Permille`].
const fn point(permille: u32) -> Permille {
    match Permille::new(permille as u16) {
        Some(point) => point,
        None => Permille::ZERO,
    }
}
