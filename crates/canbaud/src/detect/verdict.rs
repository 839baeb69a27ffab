//! What a detector answers: a proven rate, or exactly why there is none.

use crate::units::Timebase;

/// A measured bit time, in ticks, with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BitTime {
    /// Ticks per bit, times 2^20.
    pub ticks_q20: u64,
    /// One standard deviation, in parts per billion.
    pub uncertainty_ppb: u32,
}

impl BitTime {
    /// The bit rate in thousandths of a bit/s, rounded half up; `None` if it overflows or the
    /// bit time is 0.
    ///
    /// ```
    /// use canbaud::detect::BitTime;
    /// use canbaud::units::{Hertz, Timebase};
    /// let bit = BitTime { ticks_q20: 16 << 20, uncertainty_ppb: 0 };
    /// let timer = Timebase::from_frequency(Hertz::new(8_000_000).unwrap());
    /// assert_eq!(bit.millibits_per_second(timer), Some(500_000_000));
    /// ```
    #[must_use]
    pub const fn millibits_per_second(self, timebase: Timebase) -> Option<u64> {
        let numerator = (timebase.ticks() as u128) * 1000;
        let denominator = (self.ticks_q20 as u128) * (timebase.seconds() as u128);
        if denominator == 0 {
            return None;
        }
        // ticks and seconds are at most 10^15, so the shift by 20 cannot overflow.
        let rounded = ((numerator << 20) + denominator / 2) / denominator;
        if rounded > u64::MAX as u128 { None } else { Some(rounded as u64) }
    }
}

/// The data phase of a CAN FD bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataPhase {
    /// No CAN FD frame was proven.
    NoFd,
    /// CAN FD frames were proven, none switched its bit rate: the data rate cannot be known.
    NeverSwitched,
    /// CAN FD frames with a bit rate switch were proven.
    Switched(BitTime),
}

/// A proven rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// The nominal bit time.
    pub nominal: BitTime,
    /// The data phase.
    pub data: DataPhase,
    /// Frames whose CRC and form were right at this rate.
    pub proven_frames: u32,
    /// The probability that the rate is wrong is at most 2 to the power of minus this.
    pub proof_bits: u32,
    /// Whether the line was inverted: high is dominant.
    pub polarity: crate::wire::Polarity,
}

/// What a detector lacks for a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// There were edges, but no complete frame between two stretches of idle.
    CompleteFrame,
    /// The edges fit no bit time: noise, another bus, or too coarse a clock.
    CleanFrame,
    /// A bit has fewer ticks than the detector can resolve.
    FinerClock,
    /// A rate fits, but the proof is too weak; another, different frame decides.
    AnotherFrame,
}

/// A part of a frame with a bit time of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Arbitration, and all of a classic frame.
    Nominal,
    /// From the BRS bit to the CRC delimiter of a CAN FD frame.
    Data,
}

/// The answer of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The rate is proven.
    Found(Found),
    /// There is activity, but no proof.
    Undecided(Need),
    /// There is no activity.
    NoTraffic,
    /// Two rates are proven on one line.
    Conflict {
        /// Which bit times differ.
        phase: Phase,
        /// The rate that proved more frames.
        first: BitTime,
        /// The other one.
        second: BitTime,
    },
}
