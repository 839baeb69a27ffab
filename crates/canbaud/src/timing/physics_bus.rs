//! The bus: propagation delay, longest bus, and the sample points that length and clock
//! tolerance leave.

use core::fmt;

use super::physics::classic_tolerance;
use super::{BitTiming, Limits, Ratio, Request, SjwPolicy, Solutions, SolveError, solutions_where};
use crate::units::{Bitrate, Hertz};

const PICOSECONDS_PER_SECOND: u128 = 1_000_000_000_000;

/// A bus: its length and its delays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bus {
    /// Longest distance between two nodes in metres.
    pub length_m: u32,
    /// Delay through one node, out and in (transmitter + receiver + isolation), in ns.
    pub node_delay_ns: u32,
    /// Delay of the cable in ps per metre.
    pub cable_delay_ps_per_m: u32,
}

impl Bus {
    /// A bus of this length with a node delay of 250 ns and 5 ns/m.
    #[must_use]
    pub const fn new(length_m: u32) -> Self {
        Self { length_m, node_delay_ns: 250, cable_delay_ps_per_m: 5_000 }
    }

    /// With this node delay in ns.
    #[must_use]
    pub const fn with_node_delay_ns(mut self, node_delay_ns: u32) -> Self {
        self.node_delay_ns = node_delay_ns;
        self
    }

    /// With this cable delay in ps per metre.
    #[must_use]
    pub const fn with_cable_delay_ps_per_m(mut self, cable_delay_ps_per_m: u32) -> Self {
        self.cable_delay_ps_per_m = cable_delay_ps_per_m;
        self
    }

    /// There and back: twice the delays of a node and of the cable, in ps.
    ///
    /// ```
    /// use canbaud::timing::physics_bus::Bus;
    /// // TI SPRUIN7: driver 90 ns, receiver 40 ns, 40 m at 5.5 ns/m.
    /// let bus = Bus::new(40).with_node_delay_ns(130).with_cable_delay_ps_per_m(5_500);
    /// assert_eq!(bus.propagation_ps(), 700_000);
    /// ```
    #[must_use]
    pub const fn propagation_ps(&self) -> u64 {
        let node = self.node_delay_ns as u64 * 1_000;
        let cable = self.length_m as u64 * self.cable_delay_ps_per_m as u64;
        2 * node.saturating_add(cable)
    }

    /// Time quanta that PROP_SEG needs, rounded up.
    ///
    /// `quantum_clocks` is prescaler times fixed divider.
    #[must_use]
    pub const fn prop_seg(&self, clock: Hertz, quantum_clocks: u32) -> u64 {
        let periods = self.propagation_ps() as u128 * clock.hertz() as u128;
        let quantum =
            PICOSECONDS_PER_SECOND * if quantum_clocks == 0 { 1 } else { quantum_clocks as u128 };
        let quanta = periods.div_ceil(quantum);
        if quanta > u64::MAX as u128 { u64::MAX } else { quanta as u64 }
    }
}

/// Longest bus in metres for which PROP_SEG covers the delay there and back, so that the whole
/// phase margin is left for the oscillators; `None` if the nodes alone take longer.
///
/// ```
/// use canbaud::timing::{physics_bus::{longest_bus_m, Bus}, BitTiming};
/// use canbaud::units::Hertz;
/// let timing = BitTiming { prescaler: 1, prop_seg: 7, phase_seg1: 1, phase_seg2: 1, sjw: 1 };
/// let bus = Bus::new(0).with_node_delay_ns(130).with_cable_delay_ps_per_m(5_500);
/// assert_eq!(longest_bus_m(&timing, Hertz::new(10_000_000).unwrap(), 1, &bus), Some(40));
/// ```
#[must_use]
pub const fn longest_bus_m(
    timing: &BitTiming,
    clock: Hertz,
    clock_divider: u16,
    bus: &Bus,
) -> Option<u32> {
    let clocks = timing.prop_seg as u64 * timing.prescaler as u64 * clock_divider as u64;
    longest_m(clocks, clock, bus)
}

/// Longest bus in metres at which an answer just arrives before the sample point, with nothing
/// left for the oscillators: the rule of thumb of Siemens. An upper bound.
///
/// ```
/// use canbaud::timing::{physics_bus::{outer_bus_m, Bus}, BitTiming};
/// use canbaud::units::Hertz;
/// // MICROMASTER: sample point 85 %, 336 ns of node delays: 500 kbit/s reach 103 m.
/// let timing = BitTiming { prescaler: 1, prop_seg: 13, phase_seg1: 3, phase_seg2: 3, sjw: 1 };
/// let bus = Bus::new(0).with_node_delay_ns(336);
/// assert_eq!(outer_bus_m(&timing, Hertz::new(10_000_000).unwrap(), 1, &bus), Some(102));
/// ```
#[must_use]
pub const fn outer_bus_m(
    timing: &BitTiming,
    clock: Hertz,
    clock_divider: u16,
    bus: &Bus,
) -> Option<u32> {
    let quanta = 1 + timing.tseg1() as u64;
    longest_m(quanta * timing.prescaler as u64 * clock_divider as u64, clock, bus)
}

const fn longest_m(clocks: u64, clock: Hertz, bus: &Bus) -> Option<u32> {
    let round_trip_ps = clocks as u128 * PICOSECONDS_PER_SECOND / clock.hertz() as u128;
    let nodes_ps = 2 * bus.node_delay_ns as u128 * 1_000;
    if round_trip_ps < nodes_ps || bus.cable_delay_ps_per_m == 0 {
        return None;
    }
    let metres = (round_trip_ps - nodes_ps) / (2 * bus.cable_delay_ps_per_m as u128);
    Some(if metres > u32::MAX as u128 { u32::MAX } else { metres as u32 })
}

/// The sample points that a bus and a clock tolerance leave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Before this the bit has not settled on the whole bus.
    pub earliest: Ratio,
    /// After this PHASE_SEG2 is too short for the oscillators.
    pub latest: Ratio,
}

impl Window {
    /// The window in the limit of infinitely fine time quanta: delay and PHASE_SEG1 before the
    /// sample point, PHASE_SEG2 behind it, each phase segment `26 df / (1 + 2 df)` of the bit
    /// (the second oscillator condition with equal phase segments).
    ///
    /// ```
    /// use canbaud::timing::physics_bus::{Bus, Window};
    /// use canbaud::units::Bitrate;
    /// let window = Window::new(Bitrate::new(500_000).unwrap(), &Bus::new(40), 5_000);
    /// assert_eq!(window.earliest.to_string(), "57.8713%");
    /// assert_eq!(window.latest.to_string(), "87.1287%");
    /// assert!(!window.is_empty());
    /// ```
    #[must_use]
    pub const fn new(bitrate: Bitrate, bus: &Bus, tolerance_ppm: u32) -> Self {
        let tolerance = if tolerance_ppm > 500_000 { 500_000 } else { tolerance_ppm as u64 };
        let phase = 26 * tolerance;
        let whole = 1_000_000 + 2 * tolerance;
        let latest = Ratio::over(whole.saturating_sub(phase), whole);
        // Delay as a share of the bit in 10^-9: rounding up costs nothing that a quantum has not.
        let product = bus.propagation_ps() as u128 * bitrate.bits_per_second() as u128;
        let delay = product.div_ceil(1_000);
        let delay = if delay > 1_000_000_000_000 { 1_000_000_000_000 } else { delay as u64 };
        let earliest = Ratio::over(delay * whole + phase * 1_000_000_000, whole * 1_000_000_000);
        Self { earliest, latest }
    }

    /// Whether nothing is left.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.latest.is_below(self.earliest)
    }
}

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
            Self::Window { window } => write!(
                f,
                "bus length and clock tolerance leave no sample point: it would have to be after \
                 {} and before {}; shorten the bus, lower the bit rate, or use better clocks",
                window.earliest, window.latest
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

/// The `K` best settings that cover the delay of the bus with PROP_SEG and stand clocks that are
/// each off by `tolerance_ppm`; ranked as `solutions` ranks.
///
/// ```
/// use canbaud::timing::{controllers::m_can, physics_bus::{solutions_for_bus, Bus}, Request};
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
    let window = Window::new(request.bitrate, bus, tolerance_ppm);
    if window.is_empty() {
        return Err(BusError::Window { window });
    }
    let fit = |timing: &BitTiming| fit(timing, request, limits, bus, tolerance_ppm);
    let ranked = solutions_where::<K>(request, limits, |timing| fit(timing).is_some())
        .map_err(BusError::Solve)?
        .map_timing(|timing| fit(&timing).unwrap_or(timing));
    if ranked.iter().next().is_none() {
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
