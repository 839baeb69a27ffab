//! A configuration while it is read from registers.

use super::field::{ones, shifted};
use super::register::{Content, Field, Part, PwmPart, Scale};
use super::{Configuration, Phase, Pwm, RegisterError};
use crate::timing::{BitTiming, Limits};

/// What the registers said so far.
#[derive(Clone, Copy)]
pub(super) struct Draft {
    phases: [PhaseDraft; 3],
    pwm: Pwm,
}

#[derive(Clone, Copy)]
struct PhaseDraft {
    /// Stored prescaler and the field that says how; put together from one or two fields.
    prescaler: Option<(Field, u32)>,
    /// Bits of the stored prescaler still missing.
    prescaler_missing: u32,
    factor: u16,
    prop_seg: Option<u16>,
    phase_seg1: Option<u16>,
    tseg1: Option<u16>,
    tseg2: Option<u16>,
    sjw: Option<u16>,
    tdc_offset: i16,
    tdc: Tdc,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Tdc {
    /// No field says; an offset above 0 counts as on.
    Unsaid,
    On,
    Off,
}

impl Draft {
    pub(super) const fn new() -> Self {
        const EMPTY: PhaseDraft = PhaseDraft {
            prescaler: None,
            prescaler_missing: 0,
            factor: 1,
            prop_seg: None,
            phase_seg1: None,
            tseg1: None,
            tseg2: None,
            sjw: None,
            tdc_offset: 0,
            tdc: Tdc::Unsaid,
        };
        Self { phases: [EMPTY; 3], pwm: Pwm { short: 0, long: 0, offset: 0 } }
    }

    const fn phase(&mut self, phase: Phase) -> &mut PhaseDraft {
        let [nominal, data, xl] = &mut self.phases;
        match phase {
            Phase::Nominal => nominal,
            Phase::Data => data,
            Phase::Xl => xl,
        }
    }

    /// Takes one field.
    pub(super) const fn take(&mut self, field: &Field, stored: u32, scale: Scale) {
        let value = field.encoding.decode(stored, field.width);
        match field.content {
            Content::Timing(phase, part) => self.phase(phase).take(field, stored, part, scale),
            Content::TdcOffset(phase) => self.phase(phase).tdc_offset = value as i16,
            Content::TdcMode { phase, off, .. } => {
                self.phase(phase).tdc = if stored == off { Tdc::Off } else { Tdc::On };
            }
            Content::Pwm(PwmPart::Short) => self.pwm.short = value as u16,
            Content::Pwm(PwmPart::Long) => self.pwm.long = value as u16,
            Content::Pwm(PwmPart::Offset) => self.pwm.offset = value as u16,
            Content::Enable(_) | Content::Constant(_) | Content::Other => {}
        }
    }

    /// The configuration, once all registers are taken. A phase without any field is left out; a
    /// phase that shares the nominal prescaler gets it.
    pub(super) fn finish(
        mut self,
        limits: [Option<&Limits>; 3],
    ) -> Result<Configuration, RegisterError> {
        let [nominal, data, xl] = limits;
        let shared = self.phase(Phase::Nominal).prescaler();
        let nominal = self.timing(Phase::Nominal, nominal, None)?;
        let nominal = nominal.ok_or(RegisterError::Missing { what: "the nominal bit timing" })?;
        let data = self.timing(Phase::Data, data, shared)?;
        let xl = self.timing(Phase::Xl, xl, shared)?;
        Ok(Configuration {
            nominal,
            data,
            xl,
            data_tdc_offset: data.and(self.phase(Phase::Data).tdc()),
            xl_tdc_offset: xl.and(self.phase(Phase::Xl).tdc()),
            pwm: (xl.is_some() && self.pwm.long > 0).then_some(self.pwm),
        })
    }

    fn timing(
        &mut self,
        phase: Phase,
        limits: Option<&Limits>,
        shared: Option<u16>,
    ) -> Result<Option<BitTiming>, RegisterError> {
        let draft = self.phase(phase);
        let Some(limits) = limits else { return Ok(None) };
        if draft.is_empty() {
            return Ok(None);
        }
        let missing = |what| RegisterError::Missing { what };
        let prescaler = draft.prescaler().or(shared).ok_or(missing("the prescaler"))?;
        let phase_seg2 = draft.tseg2.ok_or(missing("TSEG2"))?;
        let sjw = draft.sjw.ok_or(missing("SJW"))?;
        let (prop_seg, phase_seg1) = match (draft.prop_seg, draft.phase_seg1, draft.tseg1) {
            (Some(prop_seg), Some(phase_seg1), _) => (prop_seg, phase_seg1),
            // A controller whose PROP_SEG is fixed has no field for it.
            (None, Some(phase_seg1), _) => (limits.prop_seg.min, phase_seg1),
            (prop_seg, None, Some(tseg1)) => {
                // PHASE_SEG1 of a controller without a field for it is a matter of view.
                let (split, phase_seg1) = limits.split(u32::from(tseg1), u32::from(phase_seg2));
                (prop_seg.unwrap_or(split), phase_seg1)
            }
            _ => return Err(missing("TSEG1")),
        };
        Ok(Some(BitTiming { prescaler, prop_seg, phase_seg1, phase_seg2, sjw }))
    }
}

impl PhaseDraft {
    const fn take(&mut self, field: &Field, stored: u32, part: Part, scale: Scale) {
        let value = field.encoding.decode(stored, field.width) as u16;
        match part {
            Part::Prescaler => {
                let (before, missing) = match self.prescaler {
                    Some((_, before)) => (before, self.prescaler_missing),
                    None => (0, ones(field.value_bits)),
                };
                let share = shifted(ones(field.width), field.shift);
                self.prescaler = Some((*field, before | shifted(stored, field.shift)));
                self.prescaler_missing = missing & !share;
            }
            Part::PrescalerScale => {
                let mut rest = scale.factors;
                let mut index = 0;
                while let Some((factor, others)) = rest.split_first() {
                    if index == stored {
                        self.factor = *factor;
                    }
                    index += 1;
                    rest = others;
                }
            }
            Part::PropSeg => self.prop_seg = Some(value),
            Part::PhaseSeg1 => self.phase_seg1 = Some(value),
            Part::Tseg1 => self.tseg1 = Some(value),
            Part::Tseg2 => self.tseg2 = Some(value),
            Part::Sjw => self.sjw = Some(value),
        }
    }

    /// The whole prescaler; `None` while a part of it is missing.
    fn prescaler(&self) -> Option<u16> {
        let (field, stored) = self.prescaler?;
        if self.prescaler_missing != 0 {
            return None;
        }
        let base = field.encoding.decode(stored, field.value_bits);
        u16::try_from(i64::from(base) * i64::from(self.factor)).ok()
    }

    const fn is_empty(&self) -> bool {
        self.tseg1.is_none() && self.phase_seg1.is_none() && self.tseg2.is_none()
    }

    fn tdc(&self) -> Option<i16> {
        let on = match self.tdc {
            Tdc::Unsaid => self.tdc_offset > 0,
            Tdc::On => true,
            Tdc::Off => false,
        };
        on.then_some(self.tdc_offset)
    }
}
