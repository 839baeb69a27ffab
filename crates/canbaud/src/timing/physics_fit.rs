//! Settings that suit a bus: its length and the tolerance of its clocks.

use core::fmt;

use super::physics::classic_tolerance;
use super::physics_bus::{Bus, Window, longest_possible_m};
use super::{
    BitTiming, Limits, Ratio, Request, SamplePointPolicy, SjwPolicy, Solutions, SolveError,
    solutions_where,
};
use crate::units::{Bitrate, Permille};

/// Why no setting suits the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum BusError {
    /// There is no setting even without the bus.
    Solve(SolveError),
    /// Delay and clock tolerance together leave no room for a sample point.
    Window {
        /// The window, with its ends crossed.
        window: Window,
        /// Longest bus in metres that leaves one; `None` if even none does.
        longest_m: Option<u32>,
    },
    /// There is room, but no setting of the controller fits into it.
    NoSetting {
        /// The window.
        window: Window,
        /// Clock tolerance asked for in 10⁻⁶.
        tolerance_ppm: u32,
    },
}

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Solve(error) => write!(f, "{error}"),
            Self::Window { longest_m: Some(longest), .. } => write!(
                f,
                "the bus is too long for this bit rate and these clocks; the longest possible is \
                 {longest} m"
            ),
            Self::Window { longest_m: None, .. } => f.write_str(
                "node delay and clock tolerance leave no sample point on a bus of any length; lower \
                 the bit rate, or use faster transceivers or better clocks",
            ),
            Self::NoSetting { window, tolerance_ppm } => write!(
                f,
                "no setting of this controller has its sample point from {} to {} and stands \
                 {tolerance_ppm} ppm",
                window.earliest, window.latest
            ),
        }
    }
}

impl core::error::Error for BusError {}

/// The sample points that a bus and a clock tolerance leave, as a policy: the window with its ends
/// rounded inwards to thousandths. For the nominal phase of several that are solved together.
///
/// ```
/// use canbaud::timing::{physics_bus::Bus, physics_fit::sample_points_for_bus, SamplePointPolicy};
/// use canbaud::units::{Bitrate, Permille};
/// let point = |permille| Permille::new(permille).unwrap();
/// let policy = sample_points_for_bus(Bitrate::new(500_000).unwrap(), &Bus::new(40), 5_000);
/// assert_eq!(policy, Ok(SamplePointPolicy::Within { earliest: point(579), latest: point(871) }));
/// // 26 * 0.5 % of the bit before and behind: 1 Mbit/s has 743 ns for 500 ns of nodes and the cable.
/// let error = sample_points_for_bus(Bitrate::new(1_000_000).unwrap(), &Bus::new(40), 5_000);
/// assert!(error.unwrap_err().to_string().ends_with("the longest possible is 24 m"));
/// ```
///
/// # Errors
/// [`BusError::Window`] with the longest bus possible.
pub fn sample_points_for_bus(
    bitrate: Bitrate,
    bus: &Bus,
    tolerance_ppm: u32,
) -> Result<SamplePointPolicy, BusError> {
    let window = Window::new(bitrate, bus, tolerance_ppm);
    let (early, late) = (window.earliest, window.latest);
    let whole = |ratio: Ratio, round_up: u64| {
        let scaled = u128::from(ratio.numerator()) * 1_000 + u128::from(round_up);
        scaled.checked_div(u128::from(ratio.denominator())).unwrap_or(u128::MAX)
    };
    let (ceil, floor) = (whole(early, early.denominator() - 1), whole(late, 0));
    let point = |permille: u128| u16::try_from(permille).ok().and_then(Permille::new);
    match (point(ceil), point(floor)) {
        (Some(earliest), Some(latest)) if earliest <= latest => {
            Ok(SamplePointPolicy::Within { earliest, latest })
        }
        _ => {
            let longest_m = longest_possible_m(bitrate, bus, tolerance_ppm);
            Err(BusError::Window { window, longest_m })
        }
    }
}

/// The `K` best settings that cover the delay of the bus with PROP_SEG and stand clocks that are
/// each off by `tolerance_ppm`; ranked as `solutions` ranks.
///
/// ```
/// use canbaud::timing::{controllers::m_can, physics_bus::Bus, physics_fit::solutions_for_bus, Request};
/// use canbaud::units::{Bitrate, Hertz};
/// let request = Request::new(Hertz::new(80_000_000).unwrap(), Bitrate::new(500_000).unwrap());
/// let ranked = solutions_for_bus::<1>(&request, &m_can::NOMINAL, &Bus::new(40), 5_000).unwrap();
/// let best = ranked.iter().next().unwrap().timing;
/// // 87.5 % would leave the oscillators too little; 900 ns need 72 quanta of 12.5 ns.
/// assert_eq!(best.sample_point().permille(), 869);
/// assert!(best.prop_seg >= 72);
/// ```
///
/// # Errors
/// [`BusError`]: what stands in the way, with the window of sample points.
pub fn solutions_for_bus<const K: usize>(
    request: &Request,
    limits: &Limits,
    bus: &Bus,
    tolerance_ppm: u32,
) -> Result<Solutions<K>, BusError> {
    sample_points_for_bus(request.bitrate, bus, tolerance_ppm)?;
    let fit = |timing: &BitTiming| fit(timing, request, limits, bus, tolerance_ppm);
    let ranked = solutions_where::<K>(request, limits, |timing| fit(timing).is_some())
        .map_err(BusError::Solve)?
        .map_timing(|timing| fit(&timing).unwrap_or(timing));
    if ranked.iter().next().is_none() {
        let window = Window::new(request.bitrate, bus, tolerance_ppm);
        return Err(BusError::NoSetting { window, tolerance_ppm });
    }
    Ok(ranked)
}

/// The setting with PROP_SEG long enough for the bus, if it then still stands the tolerance.
fn fit(
    timing: &BitTiming,
    request: &Request,
    limits: &Limits,
    bus: &Bus,
    tolerance_ppm: u32,
) -> Option<BitTiming> {
    let quantum = u32::from(timing.prescaler) * u32::from(limits.clock_divider);
    let needed = u16::try_from(bus.prop_seg(request.clock, quantum)).ok()?;
    let prop_seg = timing.prop_seg.max(needed).max(limits.prop_seg.min);
    let phase_seg1 = u16::try_from(timing.tseg1()).ok()?.checked_sub(prop_seg)?;
    if phase_seg1 < limits.phase_seg1.min.max(1) || prop_seg > limits.prop_seg.max {
        return None;
    }
    let largest = limits.sjw_limit(phase_seg1, timing.phase_seg2);
    let sjw = match request.sjw {
        SjwPolicy::Largest => largest,
        SjwPolicy::AtMost(_) => timing.sjw.min(largest),
        SjwPolicy::Exactly(asked) if asked <= largest => asked,
        SjwPolicy::Exactly(_) => return None,
    };
    let fitted = BitTiming { prop_seg, phase_seg1, sjw, ..*timing };
    let needed = Ratio::over(u64::from(tolerance_ppm), 1_000_000);
    (classic_tolerance(&fitted).limit() >= needed).then_some(fitted)
}
