//! Oscillator tolerance of a setting.
//!
//! Classic: two conditions (Hartwich and Bassemir, "The Configuration of the CAN Bit Timing").
//! CAN FD: five (ISO 11898-1), in the numbering that Kvaser calls df1 to df5.

use super::{BitTiming, Ratio};

/// The tolerance that each condition leaves; the smallest counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tolerance {
    /// The conditions in order: two for classic CAN, five for CAN FD.
    conditions: [Option<Ratio>; 5],
}

impl Tolerance {
    /// Each condition's limit, in order.
    pub fn conditions(&self) -> impl Iterator<Item = Ratio> {
        self.conditions.iter().flatten().copied()
    }

    /// The oscillator of every node may be off by this much: the smallest of the conditions.
    #[must_use]
    pub fn limit(&self) -> Ratio {
        self.conditions().min().unwrap_or(Ratio::over(0, 1))
    }
}

/// Tolerance of classic CAN: a bit stuffing gap of 10 bits within SJW, and an error flag within
/// the phase segments.
///
/// ```
/// use canbaud::timing::{physics::classic_tolerance, BitTiming};
/// // TI SPRUIN7: 10 MHz, 1 Mbit/s, TSEG1 8, TSEG2 1, SJW 1
/// let timing = BitTiming { prescaler: 1, prop_seg: 7, phase_seg1: 1, phase_seg2: 1, sjw: 1 };
/// assert_eq!(classic_tolerance(&timing).limit().to_string(), "0.3876%");
/// ```
#[must_use]
pub const fn classic_tolerance(timing: &BitTiming) -> Tolerance {
    let (first, second) = two_conditions(timing);
    Tolerance { conditions: [Some(first), Some(second), None, None, None] }
}

const fn two_conditions(timing: &BitTiming) -> (Ratio, Ratio) {
    let bit = timing.quanta() as u64;
    let first = Ratio::over(timing.sjw as u64, 20 * bit);
    let second =
        Ratio::over(smaller_phase(timing), 2 * (13 * bit).saturating_sub(timing.phase_seg2 as u64));
    (first, second)
}

const fn smaller_phase(timing: &BitTiming) -> u64 {
    if timing.phase_seg1 < timing.phase_seg2 {
        timing.phase_seg1 as u64
    } else {
        timing.phase_seg2 as u64
    }
}

/// Tolerance of CAN FD with a bit rate switch: the two classic conditions, the resynchronization
/// in the data phase, and two across the switch.
///
/// ```
/// use canbaud::timing::{physics::fd_tolerance, BitTiming};
/// let nominal = BitTiming { prescaler: 1, prop_seg: 48, phase_seg1: 79, phase_seg2: 32, sjw: 32 };
/// let data = BitTiming { prescaler: 1, prop_seg: 19, phase_seg1: 10, phase_seg2: 10, sjw: 10 };
/// let tolerance = fd_tolerance(&nominal, &data);
/// let percent: Vec<String> = tolerance.conditions().map(|c| c.to_string()).collect();
/// assert_eq!(percent, ["1.0%", "0.7813%", "1.25%", "1.1852%", "1.0917%"]);
/// ```
#[must_use]
pub const fn fd_tolerance(nominal: &BitTiming, data: &BitTiming) -> Tolerance {
    let (first, second) = two_conditions(nominal);
    let (brp_n, brp_d) = (nominal.prescaler as u64, data.prescaler as u64);
    let (bit_n, bit_d) = (nominal.quanta() as u64, data.quanta() as u64);
    let (ps2_n, ps2_d) = (nominal.phase_seg2 as u64, data.phase_seg2 as u64);
    let third = Ratio::over(data.sjw as u64, 20 * bit_d);
    // Both sides are multiplied by a prescaler so that its ratio needs no division.
    let fourth = Ratio::over(
        smaller_phase(nominal) * brp_n,
        2 * ((6 * bit_d).saturating_sub(ps2_d) * brp_d + 7 * bit_n * brp_n),
    );
    let jump = (data.sjw as u64 * brp_d).saturating_sub(brp_n.saturating_sub(brp_d));
    let fifth = Ratio::over(
        jump,
        2 * ((2 * bit_n).saturating_sub(ps2_n) * brp_n + (ps2_d + 4 * bit_d) * brp_d),
    );
    let conditions = [Some(first), Some(second), Some(third), Some(fourth), Some(fifth)];
    Tolerance { conditions }
}
