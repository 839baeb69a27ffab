//! Transmitter delay compensation: where the secondary sample point lies.

use super::BitTiming;

/// Transmitter delay compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tdc {
    /// There is no such phase, or the controller has no TDC.
    None,
    /// On, with the secondary sample point this many clock periods after the measured delay.
    Offset(i16),
    /// ISO 11898-1 allows TDC only with a prescaler of 1 or 2.
    PrescalerTooLarge {
        /// The prescaler.
        prescaler: u16,
    },
    /// The offset does not fit the controller.
    OffsetTooLarge {
        /// The offset that the sample point asks for.
        offset: u32,
        /// The highest that fits.
        max: i16,
    },
}

impl Tdc {
    /// The offset that puts the secondary sample point where the sample point is:
    /// `(1 + PROP_SEG + PHASE_SEG1) * prescaler`.
    ///
    /// ```
    /// use canbaud::timing::{tdc::Tdc, BitTiming};
    /// let data = BitTiming { prescaler: 1, prop_seg: 20, phase_seg1: 9, phase_seg2: 10, sjw: 10 };
    /// assert_eq!(Tdc::of(&data, 127), Tdc::Offset(30));
    /// assert_eq!(Tdc::of(&BitTiming { prescaler: 4, ..data }, 127),
    ///            Tdc::PrescalerTooLarge { prescaler: 4 });
    /// ```
    #[must_use]
    pub const fn of(timing: &BitTiming, max: i16) -> Self {
        if max <= 0 {
            return Self::None;
        }
        if timing.prescaler > 2 {
            return Self::PrescalerTooLarge { prescaler: timing.prescaler };
        }
        let offset = (1 + timing.tseg1()) * timing.prescaler as u32;
        if offset > max as u32 {
            return Self::OffsetTooLarge { offset, max };
        }
        Self::Offset(offset as i16)
    }

    /// The offset, when TDC is on.
    #[must_use]
    pub const fn offset(self) -> Option<i16> {
        match self {
            Self::Offset(offset) => Some(offset),
            Self::None | Self::PrescalerTooLarge { .. } | Self::OffsetTooLarge { .. } => None,
        }
    }
}
