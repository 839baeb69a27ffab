//! Bit timing at compile time.

use super::{BitTiming, Limits, Request, SamplePointPolicy, solve};
use crate::units::{Bitrate, Hertz, Permille};

/// Solves at compile time: `bit_timing!(clock_hz, bits_per_second, limits)` or, with a sample
/// point in thousandths, `bit_timing!(clock_hz, bits_per_second, limits, 800)`.
///
/// An impossible request does not compile; the error says why.
///
/// ```
/// use canbaud::{bit_timing, timing::{controllers::mcp2515, BitTiming}};
/// const TIMING: BitTiming = bit_timing!(16_000_000, 500_000, mcp2515::NOMINAL, 750);
/// assert_eq!((TIMING.prescaler, TIMING.tseg1(), TIMING.tseg2()), (1, 11, 4));
/// ```
///
/// ```compile_fail
/// use canbaud::{bit_timing, timing::{controllers::mcp2515, BitTiming}};
/// // 8 MHz / 2 / 6 quanta is the fastest: 666.667 kbit/s.
/// const TIMING: BitTiming = bit_timing!(8_000_000, 1_000_000, mcp2515::NOMINAL);
/// ```
#[macro_export]
macro_rules! bit_timing {
    ($clock:expr, $bitrate:expr, $limits:expr) => {
        $crate::bit_timing!(@ $clock, $bitrate, $limits, None)
    };
    ($clock:expr, $bitrate:expr, $limits:expr, $sample_point:expr) => {
        $crate::bit_timing!(@ $clock, $bitrate, $limits, Some($sample_point))
    };
    (@ $clock:expr, $bitrate:expr, $limits:expr, $sample_point:expr) => {
        const {
            match $crate::timing::solve_raw($clock, $bitrate, $sample_point, &$limits) {
                Ok(timing) => timing,
                Err(reason) => panic!("{}", reason),
            }
        }
    };
}

/// What [`bit_timing!`](crate::bit_timing) evaluates: plain numbers in, the reason as text out.
#[doc(hidden)]
pub const fn solve_raw(
    clock: u64,
    bitrate: u32,
    sample_point: Option<u16>,
    limits: &Limits,
) -> Result<BitTiming, &'static str> {
    let Some(clock) = Hertz::new(clock) else { return Err("bit timing: the clock is 0 Hz") };
    let Some(bitrate) = Bitrate::new(bitrate) else {
        return Err("bit timing: the bit rate is 0 bit/s");
    };
    let mut request = Request::new(clock, bitrate);
    if let Some(permille) = sample_point {
        let Some(point) = Permille::new(permille) else {
            return Err("bit timing: the sample point is above 1000 thousandths");
        };
        request = request.with_sample_point(point, SamplePointPolicy::Nearest);
    }
    match solve(&request, limits) {
        Ok(solution) => Ok(solution.timing),
        Err(error) => Err(error.reason()),
    }
}
