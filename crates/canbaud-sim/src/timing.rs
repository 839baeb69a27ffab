//! The bit timing of a node, in real values [ISO 11898-1].

use canbaud::units::Permille;

/// Why a bit timing is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TimingError {
    /// A segment is out of range.
    #[error("{name} is {value}, allowed are {min} to {max}")]
    Range {
        /// Which.
        name: &'static str,
        /// The value given.
        value: u32,
        /// Lowest allowed.
        min: u32,
        /// Highest allowed.
        max: u32,
    },
    /// No prescaler and number of quanta give the bit rate.
    #[error(
        "a clock of {clock_hz} Hz cannot make {bitrate} bit/s with 4 to 200 quanta per bit \
         and less than 0.5 % error"
    )]
    Unreachable {
        /// The clock.
        clock_hz: u64,
        /// The bit rate asked for.
        bitrate: u32,
    },
}

/// One bit time: SYNC_SEG is one quantum.
///
/// ```
/// use canbaud_sim::BitTiming;
/// let timing = BitTiming::new(2, 6, 7, 2, 2).unwrap();
/// assert_eq!(timing.quanta(), 16);
/// assert_eq!(timing.sample_point().to_string(), "87.5%");
/// assert_eq!(BitTiming::new(2, 6, 7, 2, 3).unwrap_err().to_string(),
///            "sjw is 3, allowed are 1 to 2");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BitTiming {
    prescaler: u32,
    prop_seg: u32,
    phase_seg1: u32,
    phase_seg2: u32,
    sjw: u32,
}

const fn check(name: &'static str, value: u32, min: u32, max: u32) -> Result<(), TimingError> {
    if value < min || value > max {
        Err(TimingError::Range { name, value, min, max })
    } else {
        Ok(())
    }
}

impl BitTiming {
    /// `prescaler` clock periods per quantum (1 to 1024); PROP_SEG (0 to 255), PHASE_SEG1 and
    /// PHASE_SEG2 (1 to 128) and SJW (1 to the smaller phase segment) in quanta.
    ///
    /// # Errors
    /// [`TimingError::Range`] for the first value out of range.
    pub fn new(
        prescaler: u32,
        prop_seg: u32,
        phase_seg1: u32,
        phase_seg2: u32,
        sjw: u32,
    ) -> Result<Self, TimingError> {
        check("prescaler", prescaler, 1, 1024)?;
        check("prop_seg", prop_seg, 0, 255)?;
        check("phase_seg1", phase_seg1, 1, 128)?;
        check("phase_seg2", phase_seg2, 1, 128)?;
        check("sjw", sjw, 1, phase_seg1.min(phase_seg2))?;
        Ok(Self { prescaler, prop_seg, phase_seg1, phase_seg2, sjw })
    }

    /// A timing for `bitrate` from a clock of `clock_hz`: the exact rate if there is one, 16
    /// quanta or as near to that as can be, the sample point as near as can be, SJW half of
    /// PHASE_SEG2.
    ///
    /// # Errors
    /// [`TimingError::Unreachable`] if no setting comes within 0.5 %.
    pub fn find(clock_hz: u64, bitrate: u32, sample_point: Permille) -> Result<Self, TimingError> {
        let unreachable = TimingError::Unreachable { clock_hz, bitrate };
        let mut best: Option<((u64, u64), u32, u32)> = None;
        for quanta in 4..=200_u32 {
            let per_prescaler = u64::from(bitrate) * u64::from(quanta);
            let prescaler = ((clock_hz + per_prescaler / 2) / per_prescaler).clamp(1, 1024);
            // Error in ppb; anything that is no better than 10 ppb counts as the same.
            let made = clock_hz as f64 / (prescaler * u64::from(quanta)) as f64;
            let error = ((made / f64::from(bitrate) - 1.0).abs() * 1e8) as u64;
            let rank = (error, u64::from(quanta.abs_diff(16)));
            if error <= 500_000 && best.is_none_or(|(other, ..)| rank < other) {
                best = Some((rank, prescaler as u32, quanta));
            }
        }
        let (_, prescaler, quanta) = best.ok_or(unreachable)?;
        Self::split(prescaler, quanta, sample_point)
    }

    /// The same bit rate and sample point with quanta of `prescaler` clock periods, if that fits:
    /// in CAN FD a nominal quantum as short as a data quantum keeps the two phases together.
    #[must_use]
    pub fn with_prescaler(self, prescaler: u32) -> Option<Self> {
        let periods = self.prescaler * self.quanta();
        let fits = periods.is_multiple_of(prescaler) && (4..=385).contains(&(periods / prescaler));
        let split = || Self::split(prescaler, periods / prescaler, self.sample_point()).ok();
        fits.then(split).flatten()
    }

    fn split(prescaler: u32, quanta: u32, sample_point: Permille) -> Result<Self, TimingError> {
        let sample = (u32::from(sample_point.permille()) * quanta + 500) / 1000;
        let phase_seg2 = (quanta - sample.min(quanta)).clamp(1, quanta - 2);
        let before = quanta - 1 - phase_seg2;
        let phase_seg1 = phase_seg2.min(before);
        let sjw = (phase_seg2 / 2).clamp(1, phase_seg1);
        Self::new(prescaler, before - phase_seg1, phase_seg1, phase_seg2, sjw)
    }

    /// The same timing with another SJW.
    ///
    /// # Errors
    /// [`TimingError::Range`] if it is 0 or larger than a phase segment.
    pub fn with_sjw(self, sjw: u32) -> Result<Self, TimingError> {
        Self::new(self.prescaler, self.prop_seg, self.phase_seg1, self.phase_seg2, sjw)
    }

    /// Clock periods per quantum.
    #[must_use]
    pub const fn prescaler(&self) -> u32 {
        self.prescaler
    }

    /// PROP_SEG in quanta.
    #[must_use]
    pub const fn prop_seg(&self) -> u32 {
        self.prop_seg
    }

    /// PHASE_SEG1 in quanta.
    #[must_use]
    pub const fn phase_seg1(&self) -> u32 {
        self.phase_seg1
    }

    /// PHASE_SEG2 in quanta.
    #[must_use]
    pub const fn phase_seg2(&self) -> u32 {
        self.phase_seg2
    }

    /// SJW in quanta.
    #[must_use]
    pub const fn sjw(&self) -> u32 {
        self.sjw
    }

    /// Quanta of a bit.
    #[must_use]
    pub const fn quanta(&self) -> u32 {
        self.sample_quanta() + self.phase_seg2
    }

    /// Quanta from the start of the bit to its sample point.
    #[must_use]
    pub const fn sample_quanta(&self) -> u32 {
        1 + self.prop_seg + self.phase_seg1
    }

    /// The sample point as a share of the bit, rounded.
    #[must_use]
    pub fn sample_point(&self) -> Permille {
        let permille = (self.sample_quanta() * 1000 + self.quanta() / 2) / self.quanta();
        // A sample point lies inside its bit, so this is at most 1000.
        Permille::new(permille as u16).unwrap_or_default()
    }
}
