//! One register: its fields, and the way between real values and the stored word.

use super::draft::Draft;
pub use super::field::{Content, Encoding, Field, Part, PwmPart};
use super::field::{ones, shifted, signed_range};
use super::{Configuration, RegisterError};
use crate::timing::BitTiming;

/// A register as the data sheet lays it out.
#[derive(Debug, Clone, Copy)]
pub struct Register {
    /// Name in the data sheet.
    pub name: &'static str,
    /// Offset or address; `None` where it depends on the channel or is not known.
    pub offset: Option<u32>,
    /// Width in bits: 8, 16 or 32.
    pub bits: u8,
    /// Fields; a bit in none of them is reserved and 0.
    pub fields: &'static [Field],
    /// Extra factors of the prescaler (DIV8 and the like), held in a field of their own.
    pub scale: Scale,
}

/// Factors by which a controller can multiply its prescaler field.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// The factors; the stored value is the index.
    pub factors: &'static [u16],
    /// Highest prescaler without a factor.
    pub base_max: u16,
}

impl Scale {
    /// No extra factor.
    pub const ONE: Self = Self { factors: &[1], base_max: u16::MAX };

    /// The prescaler without its factor, and the index of the smallest factor that makes it fit.
    const fn divide(&self, prescaler: u16) -> Option<(u16, u32)> {
        let mut index = 0;
        let mut rest = self.factors;
        while let Some((factor, others)) = rest.split_first() {
            if *factor != 0 && prescaler.is_multiple_of(*factor) {
                let base = prescaler / *factor;
                if base <= self.base_max {
                    return Some((base, index));
                }
            }
            index += 1;
            rest = others;
        }
        None
    }
}

impl Register {
    /// A register without an extra prescaler factor.
    #[must_use]
    pub const fn new(
        name: &'static str,
        offset: Option<u32>,
        bits: u8,
        fields: &'static [Field],
    ) -> Self {
        Self { name, offset, bits, fields, scale: Scale::ONE }
    }

    /// With extra prescaler factors.
    #[must_use]
    pub const fn with_scale(mut self, scale: Scale) -> Self {
        self.scale = scale;
        self
    }

    /// Whether a configuration puts anything into this register.
    #[must_use]
    pub const fn is_used_by(&self, configuration: &Configuration) -> bool {
        let mut rest = self.fields;
        while let Some((field, others)) = rest.split_first() {
            if let Some(phase) = field.phase()
                && configuration.phase(phase).is_some()
            {
                return true;
            }
            rest = others;
        }
        false
    }

    /// The word to write for a configuration. Bits that are not about timing are 0.
    ///
    /// ```
    /// use canbaud::timing::{controllers::{c167, Configuration}, BitTiming};
    /// let timing = BitTiming { prescaler: 1, prop_seg: 5, phase_seg1: 2, phase_seg2: 2, sjw: 1 };
    /// assert_eq!(c167::BTR.pack(&Configuration::classic(timing)), Ok(0x1600)); // [AP2925 table 1]
    /// ```
    ///
    /// # Errors
    /// [`RegisterError::Field`] names the field, the value and what fits; nothing is masked.
    pub const fn pack(&self, configuration: &Configuration) -> Result<u32, RegisterError> {
        let mut word = 0;
        let mut rest = self.fields;
        while let Some((field, others)) = rest.split_first() {
            match self.pack_field(field, configuration) {
                Ok(stored) => word |= shifted(stored, field.lsb),
                Err(error) => return Err(error),
            }
            rest = others;
        }
        Ok(word)
    }

    const fn pack_field(
        &self,
        field: &Field,
        configuration: &Configuration,
    ) -> Result<u32, RegisterError> {
        let value = match field.content {
            Content::Timing(phase, part) => match configuration.phase(phase) {
                Some(timing) => match self.part(&timing, part) {
                    Some(value) => value,
                    None => return Err(self.field_error(field, timing.prescaler as i32)),
                },
                None => return Ok(0),
            },
            Content::TdcOffset(phase) => match configuration.tdc_offset(phase) {
                Some(offset) => offset as i32,
                None => return Ok(0),
            },
            Content::TdcMode { phase, on, off } => {
                return Ok(if configuration.tdc_offset(phase).is_some() { on } else { off });
            }
            Content::Enable(phase) => configuration.phase(phase).is_some() as i32,
            Content::Pwm(part) => match (configuration.pwm, part) {
                (None, _) => return Ok(0),
                (Some(pwm), PwmPart::Short) => pwm.short as i32,
                (Some(pwm), PwmPart::Long) => pwm.long as i32,
                (Some(pwm), PwmPart::Offset) => pwm.offset as i32,
            },
            Content::Constant(value) => return Ok(value),
            Content::Other => return Ok(0),
        };
        match field.encoding.encode(value, field.value_bits) {
            Some(stored) if stored & !ones(field.value_bits) == 0 => {
                let part = shifted(ones(field.width), field.shift) & stored;
                Ok(part.wrapping_shr(field.shift as u32))
            }
            _ => Err(self.field_error(field, value)),
        }
    }

    const fn part(&self, timing: &BitTiming, part: Part) -> Option<i32> {
        Some(match part {
            Part::Prescaler => match self.scale.divide(timing.prescaler) {
                Some((base, _)) => base as i32,
                None => return None,
            },
            Part::PrescalerScale => match self.scale.divide(timing.prescaler) {
                Some((_, index)) => index as i32,
                None => return None,
            },
            Part::PropSeg => timing.prop_seg as i32,
            Part::PhaseSeg1 => timing.phase_seg1 as i32,
            Part::Tseg1 => timing.tseg1() as i32,
            Part::Tseg2 => timing.phase_seg2 as i32,
            Part::Sjw => timing.sjw as i32,
        })
    }

    pub(super) const fn field_error(&self, field: &Field, value: i32) -> RegisterError {
        let highest = ones(field.value_bits);
        let (min, max) = match field.encoding {
            Encoding::Signed => signed_range(field.width),
            encoding => (encoding.decode(0, field.width), encoding.decode(highest, field.width)),
        };
        RegisterError::Field { register: self.name, field: field.name, value, min, max }
    }

    /// Bits that belong to no field.
    #[must_use]
    pub const fn reserved(&self) -> u32 {
        let mut mask = ones(self.bits);
        let mut rest = self.fields;
        while let Some((field, others)) = rest.split_first() {
            mask &= !field.mask();
            rest = others;
        }
        mask
    }

    /// Takes the fields of `word` into a draft of the configuration.
    pub(super) const fn unpack_into(
        &self,
        word: u32,
        draft: &mut Draft,
    ) -> Result<(), RegisterError> {
        if word & !ones(self.bits) != 0 {
            return Err(RegisterError::TooWide { register: self.name, word, bits: self.bits });
        }
        let reserved = word & self.reserved();
        if reserved != 0 {
            return Err(RegisterError::Reserved { register: self.name, bits: reserved });
        }
        let mut rest = self.fields;
        while let Some((field, others)) = rest.split_first() {
            let stored = field.stored(word);
            if let Content::Constant(value) = field.content
                && stored != value
            {
                let (value, min) = (stored as i32, value as i32);
                let (register, field) = (self.name, field.name);
                return Err(RegisterError::Field { register, field, value, min, max: min });
            }
            draft.take(field, stored, self.scale);
            rest = others;
        }
        Ok(())
    }
}
