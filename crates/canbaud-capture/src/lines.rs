//! Lines of a text file, with a bound on their length.

use crate::error::{CaptureError, Place};
use crate::input::{Input, fill};

/// Bytes read at once.
const BUFFER: usize = 256 * 1024;
/// No capture has longer lines.
pub(crate) const MAX_LINE: usize = 64 * 1024;

/// Reads a text file line by line.
pub(crate) struct Lines {
    input: Input,
    buffer: Vec<u8>,
    /// The bytes of the buffer that are not yet handed out.
    start: usize,
    end: usize,
    /// Lines handed out.
    number: u64,
    /// Bytes handed out.
    done: u64,
}

impl Lines {
    pub(crate) fn new(input: &Input) -> Self {
        Self { input: input.at(0), buffer: vec![0; BUFFER], start: 0, end: 0, number: 0, done: 0 }
    }

    /// The line handed out last.
    pub(crate) const fn place(&self) -> Place {
        Place::Line(self.number)
    }

    /// Bytes handed out so far.
    pub(crate) const fn done(&self) -> u64 {
        self.done
    }

    /// The next line without its end; `None` at the end of the file.
    pub(crate) fn next(&mut self) -> Result<Option<&[u8]>, CaptureError> {
        let mut searched = 0;
        let (len, used) = loop {
            let rest = self.buffer.get(self.start + searched..self.end).unwrap_or_default();
            if let Some(at) = memchr::memchr(b'\n', rest) {
                break (searched + at, searched + at + 1);
            }
            searched = self.end - self.start;
            if searched > MAX_LINE {
                break (searched, searched);
            }
            if !self.refill()? {
                break (searched, searched);
            }
        };
        if used == 0 {
            return Ok(None);
        }
        self.number += 1;
        self.done += used as u64;
        if len > MAX_LINE {
            let reason = format!("is longer than {MAX_LINE} bytes");
            return Err(CaptureError::damaged(self.place(), reason));
        }
        let line = self.buffer.get(self.start..self.start + len).unwrap_or_default();
        self.start += used;
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let bom = b"\xef\xbb\xbf";
        Ok(Some(if self.number == 1 { line.strip_prefix(bom).unwrap_or(line) } else { line }))
    }

    /// Moves what is left to the front and reads more; false at the end of the file.
    fn refill(&mut self) -> Result<bool, CaptureError> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        let free = self.buffer.get_mut(self.end..).unwrap_or_default();
        let n = fill(&mut self.input, free)
            .map_err(|source| CaptureError::Read { place: Place::Line(self.number), source })?;
        self.end += n;
        Ok(n > 0)
    }
}

/// Lines in the whole file that are not empty, and the last of them.
pub(crate) fn count(input: &Input) -> Result<(u64, Vec<u8>), CaptureError> {
    let mut lines = Lines::new(input);
    let mut count = 0;
    let mut last = Vec::new();
    while let Some(line) = lines.next()? {
        if !line.trim_ascii().is_empty() {
            count += 1;
            last.clear();
            last.extend_from_slice(line);
        }
    }
    Ok((count, last))
}
