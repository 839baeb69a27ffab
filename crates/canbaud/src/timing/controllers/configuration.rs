//! Everything about time that a controller is programmed with.

use super::Phase;
use crate::timing::BitTiming;

/// The bit timing of all phases, the transmitter delay compensation and the PWM coding.
///
/// ```
/// use canbaud::timing::{controllers::Configuration, BitTiming};
/// let timing = BitTiming { prescaler: 1, prop_seg: 10, phase_seg1: 2, phase_seg2: 3, sjw: 1 };
/// assert_eq!(Configuration::classic(timing).data, None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Configuration {
    /// Arbitration phase.
    pub nominal: BitTiming,
    /// CAN FD data phase.
    pub data: Option<BitTiming>,
    /// CAN XL data phase.
    pub xl: Option<BitTiming>,
    /// Secondary sample point offset of the FD data phase in clock periods; `None`: TDC off.
    pub data_tdc_offset: Option<i16>,
    /// Secondary sample point offset of the XL data phase in clock periods; `None`: TDC off.
    pub xl_tdc_offset: Option<i16>,
    /// PWM coding of the XL data phase.
    pub pwm: Option<Pwm>,
}

impl Configuration {
    /// One bit rate only.
    #[must_use]
    pub const fn classic(nominal: BitTiming) -> Self {
        Self {
            nominal,
            data: None,
            xl: None,
            data_tdc_offset: None,
            xl_tdc_offset: None,
            pwm: None,
        }
    }

    /// With a CAN FD data phase and its TDC offset.
    #[must_use]
    pub const fn with_data(mut self, data: BitTiming, tdc_offset: Option<i16>) -> Self {
        self.data = Some(data);
        self.data_tdc_offset = tdc_offset;
        self
    }

    /// The timing of a phase, if it is configured.
    #[must_use]
    pub const fn phase(&self, phase: Phase) -> Option<BitTiming> {
        match phase {
            Phase::Nominal => Some(self.nominal),
            Phase::Data => self.data,
            Phase::Xl => self.xl,
        }
    }

    pub(super) const fn tdc_offset(&self, phase: Phase) -> Option<i16> {
        match phase {
            Phase::Nominal => None,
            Phase::Data => self.data_tdc_offset,
            Phase::Xl => self.xl_tdc_offset,
        }
    }
}

/// PWM coding of the CAN XL data phase, in clock periods (CiA 612-1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Pwm {
    /// Short part of a symbol.
    pub short: u16,
    /// Long part of a symbol.
    pub long: u16,
    /// Offset: nominal bit time modulo the symbol.
    pub offset: u16,
}
