//! The run lengths of a channel in the order of time.

use std::io::BufReader;

use super::block::Block;
use crate::error::{CaptureError, Place};
use crate::input::{Fields, Input};

type Array = Fields<BufReader<Input>>;

/// What comes next.
pub(super) enum Step {
    /// So many samples of one level.
    Run { high: bool, samples: u64 },
    /// The recording is over.
    End,
}

/// An index record: from sample `position` on, runs lie in array `kind` from `start` on.
#[derive(Debug, Clone, Copy)]
struct Record {
    position: u64,
    start: u64,
    /// The last run used of the array before, or -1.
    before: u64,
    kind: usize,
}

/// Walks index and arrays side by side, each once from front to back.
pub(super) struct Runs {
    arrays: [(Array, u64); 4],
    /// Runs taken of each array.
    taken: [u64; 4],
    index: Array,
    records_left: u64,
    /// The array in use, and up to which run; none before the first record.
    current: Option<(usize, u64)>,
    next: Option<Record>,
    position: u64,
}

impl Runs {
    pub(super) fn new(input: &Input, block: &Block) -> Self {
        let open = |at| Fields::new(BufReader::with_capacity(16 * 1024, input.at(at)), at);
        let [a, b, c, d, (index, records)] = block.arrays;
        Self {
            arrays: [a, b, c, d].map(|(at, count)| (open(at), count)),
            taken: [0; 4],
            index: open(index),
            records_left: records,
            current: None,
            next: None,
            position: 0,
        }
    }

    /// Samples so far.
    pub(super) const fn position(&self) -> u64 {
        self.position
    }

    fn damaged(&self, reason: &str) -> CaptureError {
        CaptureError::damaged(self.index.place(), reason)
    }

    fn record(&mut self) -> Result<Option<Record>, CaptureError> {
        let Some(left) = self.records_left.checked_sub(1) else { return Ok(None) };
        self.records_left = left;
        let (position, start, before) = (self.index.u64()?, self.index.u64()?, self.index.u64()?);
        let kind = self.index.u32()?;
        // Padding that was never set.
        self.index.u32()?;
        match kind {
            1..=4 => Ok(Some(Record { position, start, before, kind: kind as usize - 1 })),
            _ => Err(self.damaged("an index record names no array")),
        }
    }

    pub(super) fn step(&mut self) -> Result<Step, CaptureError> {
        loop {
            if let Some((kind, end)) = self.current
                && let Some(taken) = self.taken.get(kind)
                && *taken < end
            {
                return self.run(kind);
            }
            let record = match (self.next.take(), self.current) {
                (Some(record), _) => record,
                (None, None) => match self.record()? {
                    Some(first) => first,
                    None => return Err(self.damaged("no index record")),
                },
                (None, Some(_)) => {
                    let all = self.arrays.iter().zip(self.taken).all(|((_, n), taken)| *n == taken);
                    if !all {
                        return Err(self.damaged("run lengths that no index record names"));
                    }
                    return Ok(Step::End);
                }
            };
            self.enter(record)?;
        }
    }

    /// Goes on with the array of `record`, up to where the next record takes over.
    fn enter(&mut self, record: Record) -> Result<(), CaptureError> {
        let taken = self.taken.get(record.kind).copied();
        let fits = taken == Some(record.start)
            && (self.current.is_none() || record.position == self.position);
        if !fits {
            return Err(self.damaged("an index record that does not fit the run lengths"));
        }
        if self.current.is_none() {
            self.position = record.position;
        }
        self.next = self.record()?;
        let all = self.arrays.get(record.kind).map_or(0, |(_, count)| *count);
        let end = match self.next {
            None => all,
            Some(next) if next.kind == record.kind => next.start,
            Some(next) => next.before.wrapping_add(1),
        };
        if end > all || end <= record.start {
            return Err(self.damaged("an index record of an impossible run"));
        }
        self.current = Some((record.kind, end));
        Ok(())
    }

    fn run(&mut self, kind: usize) -> Result<Step, CaptureError> {
        let (Some((array, _)), Some(taken)) = (self.arrays.get_mut(kind), self.taken.get_mut(kind))
        else {
            return Ok(Step::End);
        };
        *taken += 1;
        let (value, bits) = match kind {
            0 => (u64::from(array.u8()?), 8),
            1 => (u64::from(u16::from_le_bytes(array.array()?)), 16),
            2 => (u64::from(array.u32()?), 32),
            _ => (array.u64()?, 64),
        };
        let top = 1 << (bits - 1);
        let samples = value & (top - 1);
        self.position = self.position.checked_add(samples).ok_or_else(|| {
            CaptureError::damaged(Place::Byte(self.index.at()), "more samples than 64 bits count")
        })?;
        Ok(Step::Run { high: value & top != 0, samples })
    }
}
