//! Packed logic samples to edges, at memory bandwidth while nothing changes.

use canbaud::wire::Logic;

use crate::error::{CaptureError, Halt};
use crate::input::Bytes;
use crate::sink::Output;

/// Bytes read at once: fits the second-level cache.
const BUFFER: usize = 256 * 1024;

/// Bytes compared at once with the repeated last sample.
const BLOCK: usize = 128;

/// How samples lie in the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    /// Little-endian words of this many bytes, 1 to 8; bit n is line n.
    Words(usize),
    /// One line, a bit per sample, least significant bit first.
    Bits,
}

/// Turns packed samples into edges, whatever the size of the pieces they come in.
pub(crate) struct Packed {
    packing: Packing,
    /// Channel of each selected line.
    channels: Vec<(u32, usize)>,
    by_line: [usize; 64],
    mask: u64,
    ticks_per_sample: u64,
    /// Number of the next sample.
    position: u64,
    /// The last sample, once there is one.
    last: Option<u64>,
    /// Samples from this number on are padding.
    limit: u64,
}

impl Packed {
    /// `lines`: bit number and channel of every line that is wanted.
    pub(crate) fn new(packing: Packing, lines: &[(u32, usize)], ticks_per_sample: u64) -> Self {
        let mut by_line = [usize::MAX; 64];
        let mut mask = 0;
        for &(line, channel) in lines {
            if let Some(slot) = by_line.get_mut(line as usize) {
                *slot = channel;
                mask |= 1 << line;
            }
        }
        let channels = lines.to_vec();
        Self {
            packing,
            channels,
            by_line,
            mask,
            ticks_per_sample,
            position: 0,
            last: None,
            limit: u64::MAX,
        }
    }

    /// Ignores everything from sample number `limit` on.
    pub(crate) const fn limited_to(mut self, limit: u64) -> Self {
        self.limit = limit;
        self
    }

    /// Samples taken so far.
    pub(crate) fn position(&self) -> u64 {
        self.position.min(self.limit)
    }

    /// Reads `bytes` to their end; `note` hears the bytes that were read. Returns the bytes at the
    /// end that do not fill a sample.
    pub(crate) fn pump(
        &mut self,
        bytes: &mut impl Bytes,
        out: &mut Output<'_>,
        mut note: impl FnMut(&mut Output<'_>, u64),
    ) -> Result<usize, Halt> {
        let unit = self.unit();
        let mut buffer = vec![0; BUFFER];
        let mut carry = 0;
        loop {
            let free = buffer.get_mut(carry..).unwrap_or_default();
            let read = bytes.read_some(free).inspect_err(|_| self.mark(out))?;
            if read == 0 {
                return Ok(carry);
            }
            let have = carry + read;
            let whole = have - have % unit;
            self.feed(buffer.get(..whole).unwrap_or_default(), out)?;
            buffer.copy_within(whole..have, 0);
            carry = have - whole;
            note(out, read as u64);
        }
    }

    /// Tells the output how far the recording has come.
    pub(crate) fn mark(&self, out: &mut Output<'_>) {
        let at = self.position().saturating_sub(1).saturating_mul(self.ticks_per_sample);
        for &(_, channel) in &self.channels {
            out.note_time(channel, at);
        }
    }

    /// Ends the recording of every line after the last sample.
    pub(crate) fn end(&self, out: &mut Output<'_>) -> Result<(), Halt> {
        let at = self.position().saturating_mul(self.ticks_per_sample);
        self.channels.iter().try_for_each(|&(_, channel)| out.end(channel, at))
    }

    const fn unit(&self) -> usize {
        match self.packing {
            Packing::Words(unit) => unit,
            Packing::Bits => 1,
        }
    }

    /// Takes whole samples.
    pub(crate) fn feed(&mut self, bytes: &[u8], out: &mut Output<'_>) -> Result<(), Halt> {
        if self.last.is_none() {
            self.start(bytes, out)?;
        }
        match self.packing {
            Packing::Words(1) => self.lanes::<8>(bytes, out),
            Packing::Words(2) => self.lanes::<16>(bytes, out),
            Packing::Words(4) => self.lanes::<32>(bytes, out),
            Packing::Words(8) => self.lanes::<64>(bytes, out),
            Packing::Words(unit) => self.words(bytes, unit, out),
            Packing::Bits => self.lanes::<1>(bytes, out),
        }
    }

    fn start(&mut self, bytes: &[u8], out: &mut Output<'_>) -> Result<(), Halt> {
        let Some(first) = bytes.get(..self.unit()) else { return Ok(()) };
        let word = match self.packing {
            Packing::Words(_) => little_endian(first),
            Packing::Bits => little_endian(first) & 1,
        };
        self.last = Some(word);
        for &(line, channel) in &self.channels {
            let level = if word >> line & 1 == 1 { Logic::High } else { Logic::Low };
            out.level(channel, self.tick(self.position)?, level)?;
        }
        Ok(())
    }

    /// Samples of `LANE` bits, 64 / `LANE` of them in a 64-bit word.
    fn lanes<const LANE: u32>(&mut self, bytes: &[u8], out: &mut Output<'_>) -> Result<(), Halt> {
        let lane_mask = u64::MAX >> (64 - LANE);
        let mask = repeat::<LANE>(self.mask & lane_mask);
        let per_word = u64::from(64 / LANE);
        let mut last = self.last.unwrap_or(0) & lane_mask;
        let (blocks, rest) = bytes.as_chunks::<BLOCK>();
        for block in blocks {
            let pattern = repeat::<LANE>(last);
            let (words, _) = block.as_chunks::<8>();
            let differs = words.iter().fold(0, |d, w| d | (u64::from_le_bytes(*w) ^ pattern));
            if differs & mask == 0 {
                self.position += per_word * (BLOCK as u64 / 8);
                continue;
            }
            for word in words {
                last = self.word::<LANE>(u64::from_le_bytes(*word), last, mask, out)?;
                self.position += per_word;
            }
        }
        let (words, tail) = rest.as_chunks::<8>();
        for word in words {
            last = self.word::<LANE>(u64::from_le_bytes(*word), last, mask, out)?;
            self.position += per_word;
        }
        if !tail.is_empty() {
            // The missing lanes repeat nothing: only those that exist may show a change.
            let bits = 8 * tail.len() as u32;
            let tail_mask = mask & (u64::MAX >> (64 - bits));
            self.word::<LANE>(little_endian(tail), last, tail_mask, out)?;
            last = little_endian(tail) >> (bits - LANE) & lane_mask;
            self.position += u64::from(bits / LANE);
        }
        self.last = Some(last);
        Ok(())
    }

    /// The edges within one word; the last lane of it.
    #[inline]
    fn word<const LANE: u32>(
        &self,
        word: u64,
        last: u64,
        mask: u64,
        out: &mut Output<'_>,
    ) -> Result<u64, Halt> {
        let before = if LANE == 64 { last } else { word << (LANE % 64) | last };
        let mut changed = (word ^ before) & mask;
        while changed != 0 {
            let lane = changed.trailing_zeros() / LANE;
            let lines = changed >> (lane * LANE) & (u64::MAX >> (64 - LANE));
            changed &= !(lines << (lane * LANE));
            self.report(lines, self.position + u64::from(lane), out)?;
        }
        Ok(word >> (64 - LANE))
    }

    /// Samples of an odd size.
    fn words(&mut self, bytes: &[u8], unit: usize, out: &mut Output<'_>) -> Result<(), Halt> {
        let mut last = self.last.unwrap_or(0);
        for sample in bytes.chunks_exact(unit) {
            let word = little_endian(sample);
            let changed = (word ^ last) & self.mask;
            if changed != 0 {
                self.report(changed, self.position, out)?;
            }
            last = word;
            self.position += 1;
        }
        self.last = Some(last);
        Ok(())
    }

    #[inline]
    fn report(&self, mut lines: u64, sample: u64, out: &mut Output<'_>) -> Result<(), Halt> {
        if sample >= self.limit {
            return Ok(());
        }
        let at = self.tick(sample)?;
        while lines != 0 {
            if let Some(&channel) = self.by_line.get(lines.trailing_zeros() as usize) {
                out.edge(channel, at)?;
            }
            lines &= lines - 1;
        }
        Ok(())
    }

    #[inline]
    fn tick(&self, sample: u64) -> Result<u64, Halt> {
        sample.checked_mul(self.ticks_per_sample).ok_or_else(|| {
            CaptureError::Limit { what: "sample number", value: sample, max: u64::MAX >> 16 }.into()
        })
    }
}

/// `lane` in every lane of a word.
const fn repeat<const LANE: u32>(lane: u64) -> u64 {
    (u64::MAX / (u64::MAX >> (64 - LANE))).wrapping_mul(lane)
}

/// Up to eight little-endian bytes.
fn little_endian(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
}
