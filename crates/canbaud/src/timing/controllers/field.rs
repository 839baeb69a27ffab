//! A field of a register: where it is, what it holds, how the value is stored.

use super::Phase;

/// A named field of a register.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// Name in the data sheet's sense, lower case.
    pub name: &'static str,
    /// Lowest bit.
    pub lsb: u8,
    /// Number of bits.
    pub width: u8,
    /// What it holds.
    pub content: Content,
    /// How the value is stored.
    pub encoding: Encoding,
    /// Bits of the whole stored value; more than `width` where it is split over two fields.
    pub value_bits: u8,
    /// Lowest bit of the whole stored value that this field holds.
    pub shift: u8,
}

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// A part of the bit timing of a phase.
    Timing(Phase, Part),
    /// Transmitter delay compensation offset of a phase.
    TdcOffset(Phase),
    /// Says whether TDC is on.
    TdcMode {
        /// The phase.
        phase: Phase,
        /// Stored when it is on.
        on: u32,
        /// Stored when it is off.
        off: u32,
    },
    /// 1 when the phase is configured.
    Enable(Phase),
    /// A part of the PWM coding.
    Pwm(PwmPart),
    /// Must have this value.
    Constant(u32),
    /// No bit timing: packed as 0, anything accepted when unpacking.
    Other,
}

/// A part of a bit timing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Prescaler without its extra factor.
    Prescaler,
    /// Index of the extra factor of the prescaler.
    PrescalerScale,
    /// PROP_SEG.
    PropSeg,
    /// PHASE_SEG1.
    PhaseSeg1,
    /// PROP_SEG + PHASE_SEG1.
    Tseg1,
    /// PHASE_SEG2.
    Tseg2,
    /// SJW.
    Sjw,
}

/// A part of the PWM coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PwmPart {
    /// Short part.
    Short,
    /// Long part.
    Long,
    /// Offset.
    Offset,
}

/// How a value is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// As it is.
    Raw,
    /// Minus one.
    MinusOne,
    /// Minus two.
    MinusTwo,
    /// Half of it, minus one.
    HalfMinusOne,
    /// Two's complement in the width of the field.
    Signed,
}

impl Encoding {
    /// The stored form; `None` for a value that has none.
    pub(super) const fn encode(self, value: i32, width: u8) -> Option<u32> {
        let stored = match self {
            Self::Raw => value,
            Self::MinusOne => value - 1,
            Self::MinusTwo => value - 2,
            Self::HalfMinusOne if value % 2 != 0 => return None,
            Self::HalfMinusOne => value / 2 - 1,
            Self::Signed => {
                let (min, max) = signed_range(width);
                if value < min || value > max {
                    return None;
                }
                value & ones(width) as i32
            }
        };
        if stored < 0 { None } else { Some(stored as u32) }
    }

    /// The real value of a stored one.
    pub(super) const fn decode(self, stored: u32, width: u8) -> i32 {
        // No field is wider than 16 bits, so nothing here wraps.
        let stored = stored as i32;
        match self {
            Self::Raw => stored,
            Self::MinusOne => stored.wrapping_add(1),
            Self::MinusTwo => stored.wrapping_add(2),
            Self::HalfMinusOne => stored.wrapping_add(1).wrapping_mul(2),
            Self::Signed if stored > signed_range(width).1 => stored | !(ones(width) as i32),
            Self::Signed => stored,
        }
    }
}

impl Field {
    /// A field that holds a part of the bit timing of `phase`.
    #[must_use]
    pub const fn timing(
        name: &'static str,
        (lsb, width): (u8, u8),
        (phase, part): (Phase, Part),
        encoding: Encoding,
    ) -> Self {
        Self {
            name,
            lsb,
            width,
            content: Content::Timing(phase, part),
            encoding,
            value_bits: width,
            shift: 0,
        }
    }

    /// A field with other content, stored as it is.
    #[must_use]
    pub const fn other(name: &'static str, (lsb, width): (u8, u8), content: Content) -> Self {
        Self { name, lsb, width, content, encoding: Encoding::Raw, value_bits: width, shift: 0 }
    }

    /// With another encoding.
    #[must_use]
    pub const fn encoded(mut self, encoding: Encoding) -> Self {
        self.encoding = encoding;
        self
    }

    /// Holds the bits from `shift` on of a stored value of `value_bits` bits.
    #[must_use]
    pub const fn part_of(mut self, value_bits: u8, shift: u8) -> Self {
        self.value_bits = value_bits;
        self.shift = shift;
        self
    }

    /// The bits of this field in the register.
    #[must_use]
    pub const fn mask(&self) -> u32 {
        shifted(ones(self.width), self.lsb)
    }

    /// The stored value of this field in `word`.
    #[must_use]
    pub const fn stored(&self, word: u32) -> u32 {
        match (word & self.mask()).checked_shr(self.lsb as u32) {
            Some(stored) => stored,
            None => 0,
        }
    }

    /// The real value of this field in `word`; `None` where another field holds the rest of it.
    #[must_use]
    pub const fn value(&self, word: u32) -> Option<i32> {
        if self.value_bits > self.width {
            return None;
        }
        Some(self.encoding.decode(self.stored(word), self.width))
    }

    /// The phase that this field is about.
    #[must_use]
    pub const fn phase(&self) -> Option<Phase> {
        match self.content {
            Content::Timing(phase, _)
            | Content::TdcOffset(phase)
            | Content::TdcMode { phase, .. }
            | Content::Enable(phase) => Some(phase),
            Content::Pwm(_) => Some(Phase::Xl),
            Content::Constant(_) | Content::Other => None,
        }
    }
}

/// A word with the lowest `bits` bits set.
pub(super) const fn ones(bits: u8) -> u32 {
    match 1_u32.checked_shl(bits as u32) {
        Some(next) => next - 1,
        None => u32::MAX,
    }
}

/// `word << by`; nothing is left of it from 32 on.
pub(super) const fn shifted(word: u32, by: u8) -> u32 {
    match word.checked_shl(by as u32) {
        Some(shifted) => shifted,
        None => 0,
    }
}

/// Lowest and highest value in two's complement of `width` bits.
pub(super) const fn signed_range(width: u8) -> (i32, i32) {
    let max = (ones(width) >> 1) as i32;
    (-max - 1, max)
}
