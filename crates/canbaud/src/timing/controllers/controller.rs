//! A controller: its limits, its registers, and what is known of it.

use core::fmt;

use super::draft::Draft;
use super::{Configuration, Register, RegisterError};
use crate::timing::{BitTiming, Limits};

/// The part of a frame that a bit timing is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Arbitration phase; the only one of classic CAN.
    Nominal,
    /// Data phase of CAN FD.
    Data,
    /// Data phase of CAN XL.
    Xl,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nominal => "nominal",
            Self::Data => "data",
            Self::Xl => "XL data",
        })
    }
}

/// Whether the phases have prescalers of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrescalerSharing {
    /// One for each phase.
    OnePerPhase,
    /// One for all phases.
    Shared,
}

/// A register with the word to write.
pub type Packed = (&'static Register, Result<u32, RegisterError>);

/// A CAN controller.
#[derive(Debug, Clone, Copy)]
pub struct Controller {
    /// Short name, lower case.
    pub name: &'static str,
    /// Other names: chips that contain it.
    pub aliases: &'static [&'static str],
    /// What it is.
    pub description: &'static str,
    /// Which clock the bit timing starts from.
    pub clock: &'static str,
    /// Limits of the nominal phase.
    pub nominal: Limits,
    /// Limits of the CAN FD data phase.
    pub data: Option<Limits>,
    /// Limits of the CAN XL data phase.
    pub xl: Option<Limits>,
    /// Whether the phases have prescalers of their own.
    pub prescalers: PrescalerSharing,
    /// Highest TDC offset in clock periods; 0: no TDC.
    pub tdc_offset_max: i16,
    /// Registers in the order in which words are given for unpacking.
    pub registers: &'static [Register],
    /// Where limits and layout come from.
    pub source: &'static str,
    /// What of it is not confirmed.
    pub unconfirmed: Option<&'static str>,
}

impl Controller {
    /// A classic controller; the rest by struct update.
    pub(super) const fn classic(name: &'static str, nominal: Limits) -> Self {
        Self {
            name,
            aliases: &[],
            description: "",
            clock: "",
            nominal,
            data: None,
            xl: None,
            prescalers: PrescalerSharing::OnePerPhase,
            tdc_offset_max: 0,
            registers: &[],
            source: "",
            unconfirmed: None,
        }
    }

    /// The limits of a phase.
    #[must_use]
    pub const fn limits(&self, phase: Phase) -> Option<&Limits> {
        match phase {
            Phase::Nominal => Some(&self.nominal),
            Phase::Data => self.data.as_ref(),
            Phase::Xl => self.xl.as_ref(),
        }
    }

    /// The same controller behind another fixed clock divider (CPS of the C167, CCD of the
    /// DS80C390).
    #[must_use]
    pub const fn with_clock_divider(mut self, clock_divider: u16) -> Self {
        self.nominal = self.nominal.with_clock_divider(clock_divider);
        if let Some(data) = self.data {
            self.data = Some(data.with_clock_divider(clock_divider));
        }
        if let Some(xl) = self.xl {
            self.xl = Some(xl.with_clock_divider(clock_divider));
        }
        self
    }

    /// Whether the configuration fits the controller.
    ///
    /// # Errors
    /// The first limit that is broken.
    pub const fn check(&self, configuration: &Configuration) -> Result<(), RegisterError> {
        let phases = [Phase::Nominal, Phase::Data, Phase::Xl];
        let mut rest: &[Phase] = &phases;
        while let Some((phase, others)) = rest.split_first() {
            if let Some(timing) = configuration.phase(*phase)
                && let Err(error) = self.check_phase(*phase, &timing, configuration)
            {
                return Err(error);
            }
            rest = others;
        }
        Ok(())
    }

    const fn check_phase(
        &self,
        phase: Phase,
        timing: &BitTiming,
        configuration: &Configuration,
    ) -> Result<(), RegisterError> {
        let Some(limits) = self.limits(phase) else { return Err(RegisterError::NoPhase(phase)) };
        if let Err(violation) = limits.check(timing) {
            return Err(RegisterError::Limits(violation));
        }
        let nominal = configuration.nominal.prescaler;
        if matches!(self.prescalers, PrescalerSharing::Shared) && timing.prescaler != nominal {
            return Err(RegisterError::SharedPrescaler { nominal, other: timing.prescaler });
        }
        let max = self.tdc_offset_max;
        match configuration.tdc_offset(phase) {
            Some(offset) if offset < 0 || offset > max => {
                Err(RegisterError::TdcOffset { offset, max })
            }
            _ => Ok(()),
        }
    }

    /// The registers that a configuration uses, with the words to write.
    ///
    /// ```
    /// use canbaud::timing::{controllers::{m_can, Configuration}, BitTiming};
    /// // The reset values of the SAM C21: 500 kbit/s at 8 MHz.
    /// let timing = BitTiming { prescaler: 1, prop_seg: 7, phase_seg1: 4, phase_seg2: 4, sjw: 4 };
    /// let configuration = Configuration::classic(timing);
    /// let words: Vec<_> = m_can::CONTROLLER.pack(&configuration).unwrap().collect();
    /// assert_eq!(words[0].1, Ok(0x0600_0A03));
    /// assert_eq!(words.len(), 1);
    /// ```
    ///
    /// # Errors
    /// The first limit that the configuration breaks, or [`RegisterError::NoRegisters`].
    pub fn pack(
        &self,
        configuration: &Configuration,
    ) -> Result<impl Iterator<Item = Packed> + use<>, RegisterError> {
        self.check(configuration)?;
        if self.registers.is_empty() {
            return Err(RegisterError::NoRegisters);
        }
        let configuration = *configuration;
        Ok(self
            .registers
            .iter()
            .filter(move |register| register.is_used_by(&configuration))
            .map(move |register| (register, register.pack(&configuration))))
    }

    /// Turns words back into the configuration; the reverse of [`Controller::pack`].
    ///
    /// Does not ask whether the limits are kept: a firmware may run outside them, and
    /// [`Controller::check`] then says so.
    ///
    /// ```
    /// use canbaud::timing::controllers::{c_can, RegisterError};
    /// let words = [(&c_can::BTR, 0x34C1), (&c_can::BRPE, 0)];
    /// let configuration = c_can::CONTROLLER.unpack(words).unwrap();
    /// assert_eq!((configuration.nominal.prescaler, configuration.nominal.sjw), (2, 4));
    /// assert_eq!(c_can::CONTROLLER.unpack([(&c_can::BTR, 0x8000)]),
    ///            Err(RegisterError::Reserved { register: "BTR", bits: 0x8000 }));
    /// ```
    ///
    /// # Errors
    /// A reserved bit that is set, or a part of the nominal bit timing that no word has.
    pub fn unpack<'a>(
        &self,
        words: impl IntoIterator<Item = (&'a Register, u32)>,
    ) -> Result<Configuration, RegisterError> {
        let mut draft = Draft::new();
        for (register, word) in words {
            register.unpack_into(word, &mut draft)?;
        }
        draft.finish([Some(&self.nominal), self.data.as_ref(), self.xl.as_ref()])
    }
}
