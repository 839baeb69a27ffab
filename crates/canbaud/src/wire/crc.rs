//! The three CRCs of CAN [ISO 11898-1]: CRC-15 classic, CRC-17 and CRC-21 for CAN FD.

/// A CRC polynomial with its width and start value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CrcKind {
    width: u32,
    polynomial: u32,
    /// The register before the first bit.
    start: u32,
}

impl CrcKind {
    /// Classic frames: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
    pub const CRC15: Self = Self { width: 15, polynomial: 0x4599, start: 0 };
    /// ISO CAN FD frames of up to 16 data bytes.
    pub const CRC17: Self = Self { width: 17, polynomial: 0x1_685B, start: 1 << 16 };
    /// ISO CAN FD frames of more than 16 data bytes.
    pub const CRC21: Self = Self { width: 21, polynomial: 0x10_2899, start: 1 << 20 };
    /// Non-ISO CAN FD frames of up to 16 data bytes.
    pub const CRC17_NON_ISO: Self = Self { start: 0, ..Self::CRC17 };
    /// Non-ISO CAN FD frames of more than 16 data bytes.
    pub const CRC21_NON_ISO: Self = Self { start: 0, ..Self::CRC21 };

    /// Bits of the CRC sequence.
    #[must_use]
    pub const fn width(self) -> u32 {
        self.width
    }
}

/// A running CRC.
///
/// ```
/// use canbaud::wire::{Crc, CrcKind};
/// let mut crc = Crc::new(CrcKind::CRC15);
/// crc.push_bits(0x31, 8); // the character '1'
/// assert_ne!(crc.value(), 0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crc {
    kind: CrcKind,
    /// The register, left-aligned to bit 31 so that one table serves every width.
    register: u32,
}

impl Crc {
    /// A CRC before its first bit.
    #[must_use]
    pub const fn new(kind: CrcKind) -> Self {
        Self { kind, register: kind.start << (32 - kind.width) }
    }

    /// Takes the low `count` (at most 32) bits of `bits`, most significant first.
    pub const fn push_bits(&mut self, bits: u32, count: u32) {
        let polynomial = self.kind.polynomial << (32 - self.kind.width);
        let mut left = if count > 32 { 32 } else { count };
        while left > 0 {
            left -= 1;
            let bit = (bits >> left) << 31;
            let feedback = (self.register ^ bit) >> 31;
            self.register = (self.register << 1) ^ (polynomial & feedback.wrapping_neg());
        }
    }

    /// The CRC sequence of the bits taken so far.
    #[must_use]
    pub const fn value(&self) -> u32 {
        self.register >> (32 - self.kind.width)
    }
}
