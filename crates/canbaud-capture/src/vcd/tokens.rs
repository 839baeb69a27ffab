//! Words of a dump. Lines mean nothing: `#1014 0!` stands on one line.

use crate::error::{CaptureError, Place};
use crate::input::{Input, fill};

const BUFFER: usize = 256 * 1024;
/// The longest word: a value of a wide vector.
const MAX_WORD: usize = 64 * 1024;

/// Reads a file word by word.
pub(super) struct Tokens {
    input: Input,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    /// Offset of `buffer[0]` in the file.
    base: u64,
    /// Offset of the word handed out last.
    word: u64,
}

impl Tokens {
    pub(super) fn new(input: &Input) -> Self {
        let buffer = vec![0; BUFFER];
        Self { input: input.at(0), buffer, start: 0, end: 0, base: 0, word: 0 }
    }

    /// Where the word handed out last stands.
    pub(super) const fn place(&self) -> Place {
        Place::Byte(self.word)
    }

    pub(super) const fn done(&self) -> u64 {
        self.word
    }

    /// The next word; `None` at the end of the file.
    #[inline]
    pub(super) fn next(&mut self) -> Result<Option<&[u8]>, CaptureError> {
        let mut searched = 0;
        loop {
            let rest = self.buffer.get(self.start..self.end).unwrap_or_default();
            let gap = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
            self.start += gap;
            let rest = rest.get(gap..).unwrap_or_default();
            let after = rest.get(searched..).unwrap_or_default();
            let found = after.iter().position(u8::is_ascii_whitespace);
            searched = found.map_or(rest.len(), |len| searched + len);
            if searched > MAX_WORD {
                self.word = self.base + self.start as u64;
                let reason = format!("a word longer than {MAX_WORD} bytes");
                return Err(CaptureError::damaged(self.place(), reason));
            }
            if found.is_some() {
                return Ok(Some(self.take(searched)));
            }
            if !self.refill()? {
                return Ok((searched > 0).then(|| self.take(searched)));
            }
        }
    }

    fn take(&mut self, len: usize) -> &[u8] {
        let start = self.start;
        self.word = self.base + start as u64;
        self.start += len;
        self.buffer.get(start..start + len).unwrap_or_default()
    }

    /// Skips to the end of a `$command … $end`, and shows the words on the way.
    pub(super) fn until_end(&mut self, mut word: impl FnMut(&[u8])) -> Result<(), CaptureError> {
        let begin = self.place();
        loop {
            match self.next()? {
                Some(b"$end") => return Ok(()),
                Some(token) => word(token),
                None => return Err(CaptureError::damaged(begin, "has no $end")),
            }
        }
    }

    fn refill(&mut self) -> Result<bool, CaptureError> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.base += self.start as u64;
        self.end -= self.start;
        self.start = 0;
        let free = self.buffer.get_mut(self.end..).unwrap_or_default();
        let n = fill(&mut self.input, free)
            .map_err(|e| CaptureError::io(self.base + self.end as u64, e))?;
        self.end += n;
        Ok(n > 0)
    }
}
