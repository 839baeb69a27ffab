//! Where the arrays of a channel are.

use super::numbers::Numbers;
use super::runs::{Runs, Step};
use crate::error::CaptureError;
use crate::input::Input;

/// Bytes of one element of each vector: four arrays of run lengths, and the index.
const SIZES: [u64; 5] = [1, 2, 4, 8, 32];
/// The longest vector head: five numbers of nine bytes.
const HEAD: usize = 45;
/// Bytes searched at once.
const WINDOW: usize = 64 * 1024;
/// Places that look like a block and are read to find out.
const MAX_TRIES: u32 = 20_000;
/// More than any Logic has.
const MAX_BLOCKS: usize = 64;

/// The arrays of one channel: offset and number of elements of each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub(super) arrays: [(u64, u64); 5],
    end: u64,
}

impl Block {
    /// The block that starts at byte `at`, if the sizes of its vectors make sense.
    fn parse(input: &Input, at: u64) -> Result<Option<Self>, CaptureError> {
        let mut arrays = [(0, 0); 5];
        let mut end = at;
        for (slot, size) in arrays.iter_mut().zip(SIZES) {
            let head = input.bytes(end, HEAD)?;
            let mut numbers = Numbers::new(&head);
            let Some(count) = numbers.size() else { return Ok(None) };
            let start = end + numbers.used() as u64;
            let Some(after) = count.checked_mul(size).and_then(|n| n.checked_add(start)) else {
                return Ok(None);
            };
            if after > input.len() {
                return Ok(None);
            }
            *slot = (start, count);
            end = after;
        }
        let [runs @ .., (_, records)] = arrays;
        let has_runs = runs.iter().any(|&(_, count)| count > 0);
        Ok((has_runs && records > 0).then_some(Self { arrays, end }))
    }

    /// Whether the index fits the runs all the way through.
    fn is_consistent(&self, input: &Input) -> bool {
        let mut runs = Runs::new(input, self);
        loop {
            match runs.step() {
                Ok(Step::Run { .. }) => {}
                Ok(Step::End) => return true,
                Err(_) => return false,
            }
        }
    }
}

/// The blocks of a file from byte `from` on.
///
/// What lies between the blocks is not known, so every byte is tried; that all index records fit
/// all run lengths is no accident.
pub(super) fn find(input: &Input, from: u64) -> Result<Vec<Block>, CaptureError> {
    let mut blocks = Vec::new();
    let mut at = from;
    let mut tries = 0;
    let mut window = Vec::new();
    let mut window_at = u64::MAX;
    while at < input.len() && blocks.len() < MAX_BLOCKS {
        let inside = at.checked_sub(window_at).and_then(|n| usize::try_from(n).ok());
        let rest = inside.and_then(|n| window.get(n..)).unwrap_or_default();
        if rest.len() < 2 * HEAD && window_at.saturating_add(WINDOW as u64) < input.len()
            || window_at == u64::MAX
        {
            window = input.bytes(at, WINDOW)?;
            window_at = at;
            continue;
        }
        // The first two vector heads follow one another where there are no 8-bit runs.
        let mut numbers = Numbers::new(rest);
        let plausible = match numbers.size() {
            None => false,
            Some(0) => (1..4)
                .find_map(|_| numbers.size().map_or(Some(false), |n| (n > 0).then_some(true)))
                .unwrap_or(false),
            Some(_) => true,
        };
        if plausible {
            tries += 1;
            if tries > MAX_TRIES {
                break;
            }
            if let Some(block) = Block::parse(input, at)?.filter(|b| b.is_consistent(input)) {
                at = block.end;
                blocks.push(block);
                continue;
            }
        }
        at += 1;
    }
    Ok(blocks)
}
