//! The CRC of a frame while its kind is still unknown.

use canbaud::wire::{FdCrc, Level};

/// Bits of one level that go into a register at once: stuffing allows no longer run.
pub(super) const RUN: u32 = 5;

/// A generator polynomial, its width, and what up to [`RUN`] bits add to an empty register that is
/// left-aligned to bit 31.
struct Generator {
    width: u32,
    table: [u32; 1 << RUN],
}

impl Generator {
    const fn new(polynomial: u32, width: u32) -> Self {
        let polynomial = polynomial << (32 - width);
        let mut table = [0; 1 << RUN];
        let mut bits = 0;
        while bits < table.len() {
            let mut value = (bits as u32) << (32 - RUN);
            let mut left = RUN;
            while left > 0 {
                let feedback = (value >> 31).wrapping_neg();
                value = (value << 1) ^ (polynomial & feedback);
                left -= 1;
            }
            table[bits] = value;
            bits += 1;
        }
        Self { width, table }
    }

    /// `value` after `count` (1 to [`RUN`]) bits, which are the lowest ones of `bits`.
    #[inline]
    const fn push(&self, value: u32, bits: u32, count: u32) -> u32 {
        let index = (value >> (32 - count)) ^ bits;
        (value << count) ^ self.table[index as usize % (1 << RUN)]
    }
}

static CRC15: Generator = Generator::new(0x4599, 15);
static CRC17: Generator = Generator::new(0x1_685B, 17);
static CRC21: Generator = Generator::new(0x10_2899, 21);

/// Bits from SOF on that wait until it is known which register they go into: up to 41 and the
/// stuff bits among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Waiting {
    bits: u64,
    count: u32,
}

impl Waiting {
    #[inline]
    const fn push(&mut self, bits: u32, count: u32) {
        self.bits = (self.bits << count) | bits as u64;
        self.count += count;
    }

    const fn go_into(self, generator: &Generator, start: u32) -> u32 {
        let mut value = start << (32 - generator.width);
        let mut left = self.count;
        while left > 0 {
            let count = if left < RUN { left } else { RUN };
            left -= count;
            let bits = (self.bits >> left) as u32 & ((1 << count) - 1);
            value = generator.push(value, bits, count);
        }
        value
    }
}

/// Which register runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Choice {
    /// Before FDF, and in CAN FD before the DLC.
    Open,
    Classic,
    Fd17,
    Fd21,
}

/// CRC-15 over the bits without stuff bits, CRC-17 and CRC-21 over the bits with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RunningCrc {
    choice: Choice,
    fd_crc: FdCrc,
    plain: Waiting,
    stuffed: Waiting,
    /// Left-aligned to bit 31.
    value: u32,
}

impl RunningCrc {
    pub(super) fn new(fd_crc: FdCrc) -> Self {
        let (plain, stuffed) = (Waiting::default(), Waiting::default());
        Self { choice: Choice::Open, fd_crc, plain, stuffed, value: 0 }
    }

    /// The frame is a classic one.
    pub(super) const fn choose_classic(&mut self) {
        self.choice = Choice::Classic;
        self.value = self.plain.go_into(&CRC15, 0);
    }

    /// The frame is a CAN FD frame with `length` data bytes.
    pub(super) const fn choose_fd(&mut self, length: usize) {
        self.choice = if length <= 16 { Choice::Fd17 } else { Choice::Fd21 };
        let generator = self.generator();
        let start = match self.fd_crc {
            FdCrc::Iso => 1 << (generator.width - 1),
            FdCrc::NonIso => 0,
        };
        self.value = self.stuffed.go_into(generator, start);
    }

    const fn generator(&self) -> &'static Generator {
        match self.choice {
            Choice::Open | Choice::Classic => &CRC15,
            Choice::Fd17 => &CRC17,
            Choice::Fd21 => &CRC21,
        }
    }

    /// Takes `count` (1 to [`RUN`]) bits of one level that are no stuff bits.
    #[inline]
    pub(super) const fn push_run(&mut self, level: Level, count: u32) {
        let bits = ones_if(level, count);
        match self.choice {
            Choice::Open => {
                self.plain.push(bits, count);
                self.stuffed.push(bits, count);
            }
            Choice::Classic | Choice::Fd17 | Choice::Fd21 => {
                self.value = self.generator().push(self.value, bits, count);
            }
        }
    }

    #[inline]
    pub(super) const fn push_stuff_bit(&mut self, level: Level) {
        let bit = ones_if(level, 1);
        match self.choice {
            Choice::Open => self.stuffed.push(bit, 1),
            Choice::Classic => {}
            Choice::Fd17 | Choice::Fd21 => {
                self.value = self.generator().push(self.value, bit, 1);
            }
        }
    }

    pub(super) const fn width(&self) -> u32 {
        self.generator().width
    }

    pub(super) const fn value(&self) -> u32 {
        self.value >> (32 - self.width())
    }
}

/// `count` bits of `level`, a 1 being recessive.
#[inline]
pub(super) const fn ones_if(level: Level, count: u32) -> u32 {
    match level {
        Level::Recessive => (1 << count) - 1,
        Level::Dominant => 0,
    }
}
