//! One analogue channel of a binary file, from samples to edges.

use super::{Chooser, Crossing, Histogram, Levels, Threshold, candidates};
use crate::capture::{Report, Signal};
use crate::error::{CaptureError, Halt};
use crate::input::Bytes;
use crate::sink::Output;

/// Samples read at once.
const BLOCK: usize = 16 * 1024;

/// Samples of one channel, block by block.
pub(crate) trait Blocks {
    /// Replaces `samples` by the next ones; none is the end.
    fn next(&mut self, samples: &mut Vec<f32>) -> Result<(), CaptureError>;
}

/// Little-endian `f32` samples.
pub(crate) struct Floats<B> {
    bytes: B,
    buffer: Vec<u8>,
    have: usize,
}

impl<B: Bytes> Floats<B> {
    pub(crate) fn new(bytes: B) -> Self {
        Self { bytes, buffer: vec![0; 4 * BLOCK], have: 0 }
    }
}

impl<B: Bytes> Blocks for Floats<B> {
    fn next(&mut self, samples: &mut Vec<f32>) -> Result<(), CaptureError> {
        samples.clear();
        while self.have < self.buffer.len() {
            let free = self.buffer.get_mut(self.have..).unwrap_or_default();
            let n = match self.bytes.read_some(free) {
                Ok(n) => n,
                // What precedes the damage is delivered first; the next call fails again.
                Err(_) if self.have >= 4 => break,
                Err(e) => return Err(e),
            };
            if n == 0 {
                break;
            }
            self.have += n;
        }
        let (whole, _) = self.buffer.get(..self.have).unwrap_or_default().as_chunks::<4>();
        samples.extend(whole.iter().map(|bytes| f32::from_le_bytes(*bytes)));
        let used = 4 * samples.len();
        self.buffer.copy_within(used..self.have, 0);
        self.have -= used;
        Ok(())
    }
}

/// One channel minus another, as long as both have samples.
pub(crate) struct Difference<B> {
    high: Floats<B>,
    low: Floats<B>,
    second: Vec<f32>,
}

impl<B: Bytes> Difference<B> {
    pub(crate) fn new(high: B, low: B) -> Self {
        Self { high: Floats::new(high), low: Floats::new(low), second: Vec::new() }
    }
}

impl<B: Bytes> Blocks for Difference<B> {
    fn next(&mut self, samples: &mut Vec<f32>) -> Result<(), CaptureError> {
        self.high.next(samples)?;
        self.low.next(&mut self.second)?;
        samples.truncate(self.second.len());
        for (a, b) in samples.iter_mut().zip(&self.second) {
            *a -= b;
        }
        Ok(())
    }
}

/// A stretch of unbroken samples: the tick of the first one, and the samples.
pub(crate) type Segment<'b> = (u64, Box<dyn Blocks + 'b>);

/// One channel to be read: it may be opened several times.
pub(crate) struct Job<'a> {
    pub(crate) channel: usize,
    /// Ticks per sample.
    pub(crate) step: u64,
    pub(crate) threshold: Option<Threshold>,
    /// Bytes read before this channel, and bytes of everything.
    pub(crate) progress: (u64, u64),
    /// Opens the segment of this number, if there is one.
    pub(crate) open: &'a dyn Fn(usize) -> Result<Option<Segment<'a>>, CaptureError>,
}

impl Job<'_> {
    /// Streams the channel; `signal` remembers what was found out about it for the next time.
    pub(crate) fn stream(
        &self,
        signal: &mut Option<Signal>,
        out: &mut Output<'_>,
        report: &mut Report,
    ) -> Result<(), Halt> {
        let found = *signal.get_or_insert_with(|| match self.levels() {
            Some(levels) => Signal::TwoLevels(levels),
            None => Signal::Flat,
        });
        if let Some(slot) = report.signals.get_mut(self.channel) {
            *slot = found;
        }
        // A flat channel is read all the same: damage must be reported, whatever the signal.
        let mut crossing = match found {
            Signal::TwoLevels(levels) => Some(Crossing::new(self.channel, levels.threshold)),
            _ => None,
        };
        let mut samples = Vec::new();
        let (mut done, total) = self.progress;
        for number in 0.. {
            let Some((mut at, mut blocks)) = (self.open)(number)? else { break };
            loop {
                blocks.next(&mut samples)?;
                if samples.is_empty() {
                    break;
                }
                if let Some(crossing) = &mut crossing {
                    crossing.block(at, self.step, &samples, out)?;
                }
                at = at.saturating_add(self.step.saturating_mul(samples.len() as u64));
                out.note_time(self.channel, at);
                done = done.saturating_add(4 * samples.len() as u64);
                out.progress(done, total);
            }
            if let Some(crossing) = &mut crossing {
                crossing.end(at, out)?;
            }
        }
        Ok(())
    }

    fn levels(&self) -> Option<Levels> {
        if let Some(threshold) = self.threshold {
            return Some(Crossing::levels(threshold));
        }
        let mut histogram = Histogram::new();
        self.scan(|samples| histogram.add(samples));
        let found = candidates(&histogram);
        if found.len() < 2 {
            return found.first().copied();
        }
        let mut chooser = Chooser::new(found);
        self.scan(|samples| chooser.add(samples));
        chooser.choice()
    }

    /// Shows every sample up to the first damage, which the pass for the edges will report.
    fn scan(&self, mut take: impl FnMut(&[f32])) {
        let mut samples = Vec::new();
        for number in 0.. {
            let Ok(Some((_, mut blocks))) = (self.open)(number) else { return };
            loop {
                if blocks.next(&mut samples).is_err() {
                    return;
                }
                if samples.is_empty() {
                    break;
                }
                take(&samples);
            }
        }
    }
}
