//! A string of bits, long enough for the longest CAN FD frame with all its stuff bits.

use super::line::Level;

/// Words of a [`BitString`].
const WORDS: usize = 24;
/// Bits of a word.
const WORD_BITS: usize = 32;

/// Up to [`BitString::CAPACITY`] bits in wire order; a 1 is recessive.
///
/// Bits past the capacity are not stored but counted, so that a reader notices.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct BitString {
    words: [u32; WORDS],
    len: usize,
}

impl BitString {
    /// Bits that a string can hold. The longest frame, an extended CAN FD frame of 64 bytes,
    /// has at most 733 bits from SOF to EOF.
    pub const CAPACITY: usize = WORDS * WORD_BITS;

    /// A string without bits.
    #[must_use]
    pub const fn new() -> Self {
        Self { words: [0; WORDS], len: 0 }
    }

    /// Number of bits.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no bits.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all bits.
    pub fn clear(&mut self) {
        self.words = [0; WORDS];
        self.len = 0;
    }

    /// Appends the low `count` (at most 32) bits of `bits`, most significant first.
    #[inline]
    pub fn push(&mut self, bits: u32, count: u32) {
        let count = if count > 32 { 32 } else { count };
        if count == 0 {
            return;
        }
        // The bits at the top of a word, and how far down they belong.
        let aligned = bits << (32 - count);
        let used = self.len % WORD_BITS;
        let word = self.len / WORD_BITS;
        self.len = self.len.saturating_add(count as usize);
        if let Some(w) = self.words.get_mut(word) {
            *w |= aligned >> used;
        }
        if used + count as usize > WORD_BITS
            && let Some(w) = self.words.get_mut(word + 1)
        {
            *w |= aligned << (WORD_BITS - used);
        }
    }

    /// Appends `count` bits of one level.
    #[inline]
    pub fn push_run(&mut self, level: Level, count: u32) {
        match level {
            // What was never written is dominant.
            Level::Dominant => self.len = self.len.saturating_add(count as usize),
            Level::Recessive if count <= WORD_BITS as u32 => self.push(u32::MAX, count),
            Level::Recessive => self.push_long_run(count),
        }
    }

    #[inline(never)]
    fn push_long_run(&mut self, count: u32) {
        // More would not be stored; a reader notices from the length all the same.
        let stored = count.min(2 * Self::CAPACITY as u32);
        self.len = self.len.saturating_add((count - stored) as usize);
        let mut left = stored;
        while left > 0 {
            let step = left.min(WORD_BITS as u32);
            self.push(u32::MAX, step);
            left -= step;
        }
    }

    /// The bit at `index`; recessive past the end.
    #[must_use]
    pub fn level(&self, index: usize) -> Level {
        if index < self.len && self.bits(index, 1) == 0 {
            Level::Dominant
        } else {
            Level::Recessive
        }
    }

    /// `count` (at most 32) bits from `index`, most significant first; 0 past the capacity.
    #[must_use]
    #[inline]
    pub fn bits(&self, index: usize, count: u32) -> u32 {
        let count = if count > 32 { 32 } else { count };
        if count == 0 {
            return 0;
        }
        let word = index / WORD_BITS;
        let offset = index % WORD_BITS;
        let high = self.words.get(word).copied().unwrap_or(0) << offset;
        let low = match offset {
            0 => 0,
            _ => self.words.get(word + 1).copied().unwrap_or(0) >> (WORD_BITS - offset),
        };
        (high | low) >> (32 - count)
    }

    /// Makes the bit at `index` dominant.
    pub fn set_dominant(&mut self, index: usize) {
        if let Some(word) = self.words.get_mut(index / WORD_BITS) {
            *word &= !(1 << (WORD_BITS - 1 - index % WORD_BITS));
        }
    }

    /// The bits in wire order.
    pub fn iter(&self) -> impl Iterator<Item = Level> + '_ {
        (0..self.len.min(Self::CAPACITY)).map(|index| self.level(index))
    }
}

impl Default for BitString {
    fn default() -> Self {
        Self::new()
    }
}

impl core::fmt::Debug for BitString {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for level in self.iter() {
            f.write_str(match level {
                Level::Dominant => "0",
                Level::Recessive => "1",
            })?;
        }
        Ok(())
    }
}
