//! Binary export of Logic 1: no header, no sample rate.
//!
//! Source: Saleae support, "Binary data export format" of Logic 1.

use std::io::BufReader;

use canbaud::units::Hertz;
use canbaud::wire::Logic;

use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt};
use crate::input::{Fields, Input};
use crate::packed::{Packed, Packing};
use crate::sink::Output;
use crate::sr;
use crate::{Format, WordSize};

/// Rows that are looked at before a file without a header is believed to be changes.
const MIN_ROWS: usize = 8;

/// Whether a head is a list of changes: sample numbers that rise and words that differ.
///
/// Eight random rows pass with a probability below 10^-40: the upper two bytes of every number
/// must be 0, and every number above the one before.
pub(crate) fn sniff_changes(head: &[u8], len: u64) -> Option<WordSize> {
    WordSize::ALL.into_iter().find(|word| {
        let row = 8 + word.bytes();
        let mut rows = head.chunks_exact(row).map(|row| {
            let (number, word) = row.split_at(8);
            let number = number.iter().rev().fold(0_u64, |n, b| n << 8 | u64::from(*b));
            (number, word)
        });
        let Some(mut before) = rows.next() else { return false };
        len.is_multiple_of(row as u64)
            && head.len() / row >= MIN_ROWS
            && before.0 >> 48 == 0
            && rows.all(|now| {
                let rises = now.0 > before.0 && now.0 >> 48 == 0 && now.1 != before.1;
                before = now;
                rises
            })
    })
}

struct Logic1 {
    input: Input,
    format: Format,
    word: WordSize,
    changes: bool,
}

pub(crate) fn open(
    input: &Input,
    format: Format,
    options: &OpenOptions,
) -> Result<Capture, CaptureError> {
    let (word, changes) = match format {
        Format::Logic1Changes(word) => (word, true),
        Format::Logic1Samples(word) => (word, false),
        other => return Err(CaptureError::unsupported(other, "no Logic 1 binary export")),
    };
    let rate: Hertz = options.samplerate.ok_or(CaptureError::NoSamplerate(format))?;
    let (timebase, _) = sr::timebase(rate, false);
    let channels = (0..8 * word.bytes())
        .map(|bit| Channel::new(format!("Channel {bit}"), ChannelKind::Digital, 1))
        .collect();
    let reader = Logic1 { input: input.clone(), format, word, changes };
    Ok(Capture::new(format, timebase, Some(rate), channels, reader))
}

impl Reader for Logic1 {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        let lines: Vec<(u32, usize)> = (0..8 * self.word.bytes())
            .filter(|&channel| out.wants(channel))
            .map(|channel| (channel as u32, channel))
            .collect();
        for &(_, channel) in &lines {
            if let Some(signal) = report.signals.get_mut(channel) {
                *signal = Signal::Digital;
            }
        }
        if self.changes {
            self.stream_changes(&lines, out, report)
        } else {
            self.stream_samples(&lines, out, report)
        }
    }
}

impl Logic1 {
    fn stream_samples(
        &self,
        lines: &[(u32, usize)],
        out: &mut Output<'_>,
        report: &mut Report,
    ) -> Result<(), Halt> {
        let mut packed = Packed::new(Packing::Words(self.word.bytes()), lines, 1);
        let mut bytes = Fields::new(self.input.at(0), 0);
        let (mut done, total) = (0, self.input.len());
        let left = packed.pump(&mut bytes, out, |out, n| {
            done += n;
            out.progress(done, total);
        })?;
        self.note_rest(left, report);
        packed.end(out)
    }

    fn note_rest(&self, left: usize, report: &mut Report) {
        if left > 0 {
            let name = self.format.name();
            report.notes.push(format!("{name}: the last {left} bytes do not fill a sample"));
        }
    }

    fn stream_changes(
        &self,
        lines: &[(u32, usize)],
        out: &mut Output<'_>,
        report: &mut Report,
    ) -> Result<(), Halt> {
        let reader = BufReader::with_capacity(256 * 1024, self.input.at(0));
        let mut fields = Fields::new(reader, 0);
        let row = 8 + self.word.bytes();
        let mut now = 0;
        let mut before: Option<u64> = None;
        for number in 0..self.input.len() / row as u64 {
            let place = fields.place();
            let at = fields.u64()?;
            if before.is_some() && at <= now {
                let reason = format!("sample number {at} is not above {now}");
                return Err(CaptureError::damaged(place, reason).into());
            }
            now = at;
            let mut word = [0; 8];
            fields.block(word.get_mut(..self.word.bytes()).unwrap_or_default())?;
            let word = u64::from_le_bytes(word);
            for &(bit, channel) in lines {
                if before.is_none_or(|before| (word ^ before) >> bit & 1 == 1) {
                    let high = word >> bit & 1 == 1;
                    out.level(channel, at, if high { Logic::High } else { Logic::Low })?;
                }
            }
            before = Some(word);
            if number.is_multiple_of(16 * 1024) {
                out.progress(fields.at(), self.input.len());
            }
        }
        self.note_rest((self.input.len() % row as u64) as usize, report);
        lines.iter().try_for_each(|&(_, channel)| out.end(channel, now))
    }
}
