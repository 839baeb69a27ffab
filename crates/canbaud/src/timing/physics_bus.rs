//! The bus: propagation delay, longest bus, and the sample points that length and clock
//! tolerance leave.
//!
//! Settings that suit a bus: `physics_fit`.

use super::{BitTiming, Ratio};
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
        let quanta = quotient(periods + quantum - 1, quantum);
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

/// Longest bus in metres on which a sample point exists at all, whatever the setting; `None` if
/// nodes and clocks alone leave none.
#[must_use]
pub const fn longest_possible_m(bitrate: Bitrate, bus: &Bus, tolerance_ppm: u32) -> Option<u32> {
    let (phase, whole) = phase_share(tolerance_ppm);
    let room = whole.saturating_sub(2 * phase) as u128 * PICOSECONDS_PER_SECOND;
    metres(quotient(room, whole as u128 * bitrate.bits_per_second() as u128), bus)
}

/// What a phase segment needs of the bit, `26 df / (1 + 2 df)`, as numerator and denominator.
const fn phase_share(tolerance_ppm: u32) -> (u64, u64) {
    let tolerance = if tolerance_ppm > 500_000 { 500_000 } else { tolerance_ppm as u64 };
    (26 * tolerance, 1_000_000 + 2 * tolerance)
}

const fn longest_m(clocks: u64, clock: Hertz, bus: &Bus) -> Option<u32> {
    metres(quotient(clocks as u128 * PICOSECONDS_PER_SECOND, clock.hertz() as u128), bus)
}

/// `a / b` without the panic of a division by 0, which none of the divisors here is.
const fn quotient(a: u128, b: u128) -> u128 {
    match a.checked_div(b) {
        Some(quotient) => quotient,
        None => u128::MAX,
    }
}

/// The cable that is left of a round trip.
const fn metres(round_trip_ps: u128, bus: &Bus) -> Option<u32> {
    let nodes_ps = 2 * bus.node_delay_ns as u128 * 1_000;
    if round_trip_ps < nodes_ps || bus.cable_delay_ps_per_m == 0 {
        return None;
    }
    let metres = quotient(round_trip_ps - nodes_ps, 2 * bus.cable_delay_ps_per_m as u128);
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
        let (phase, whole) = phase_share(tolerance_ppm);
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
