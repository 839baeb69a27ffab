//! The CRC of a frame while its kind is still unknown.

use canbaud::wire::{FdCrc, Level};

/// One CRC register, left-aligned to bit 31.
#[derive(Debug, Clone, Copy)]
struct Register {
    value: u32,
    polynomial: u32,
    width: u32,
}

impl Register {
    const fn new(polynomial: u32, width: u32, start: u32) -> Self {
        Self { value: start << (32 - width), polynomial: polynomial << (32 - width), width }
    }

    #[inline]
    const fn push(&mut self, bit: u32) {
        let feedback = ((self.value >> 31) ^ bit).wrapping_neg();
        self.value = (self.value << 1) ^ (self.polynomial & feedback);
    }
}

/// Which registers still run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Choice {
    /// Before FDF, and in CAN FD before the DLC.
    Open,
    Classic,
    Fd17,
    Fd21,
}

/// CRC-15 over the bits without stuff bits, CRC-17 and CRC-21 over the bits with them.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunningCrc {
    choice: Choice,
    crc15: Register,
    crc17: Register,
    crc21: Register,
}

impl RunningCrc {
    pub(super) const fn new(fd_crc: FdCrc) -> Self {
        let (start17, start21) = match fd_crc {
            FdCrc::Iso => (1 << 16, 1 << 20),
            FdCrc::NonIso => (0, 0),
        };
        Self {
            choice: Choice::Open,
            crc15: Register::new(0x4599, 15, 0),
            crc17: Register::new(0x1_685B, 17, start17),
            crc21: Register::new(0x10_2899, 21, start21),
        }
    }

    /// The frame is a classic one.
    pub(super) const fn choose_classic(&mut self) {
        self.choice = Choice::Classic;
    }

    /// The frame is a CAN FD frame with `length` data bytes.
    pub(super) const fn choose_fd(&mut self, length: usize) {
        self.choice = if length <= 16 { Choice::Fd17 } else { Choice::Fd21 };
    }

    #[inline]
    pub(super) fn push(&mut self, level: Level) {
        let bit = u32::from(level == Level::Recessive);
        match self.choice {
            Choice::Classic => self.crc15.push(bit),
            Choice::Fd17 => self.crc17.push(bit),
            Choice::Fd21 => self.crc21.push(bit),
            Choice::Open => {
                self.crc15.push(bit);
                self.crc17.push(bit);
                self.crc21.push(bit);
            }
        }
    }

    #[inline]
    pub(super) fn push_stuff_bit(&mut self, level: Level) {
        let bit = u32::from(level == Level::Recessive);
        match self.choice {
            Choice::Classic => {}
            Choice::Fd17 => self.crc17.push(bit),
            Choice::Fd21 => self.crc21.push(bit),
            Choice::Open => {
                self.crc17.push(bit);
                self.crc21.push(bit);
            }
        }
    }

    const fn chosen(&self) -> &Register {
        match self.choice {
            Choice::Open | Choice::Classic => &self.crc15,
            Choice::Fd17 => &self.crc17,
            Choice::Fd21 => &self.crc21,
        }
    }

    pub(super) const fn width(&self) -> u32 {
        self.chosen().width
    }

    pub(super) const fn value(&self) -> u32 {
        self.chosen().value >> (32 - self.chosen().width)
    }
}
