//! Value changes to edges.

use super::changes::{Changes, stamp};
use super::header::{self, Header};
use super::tokens::Tokens;
use super::voltages::{Emit, Scan, Study};
use crate::Format;
use crate::analogue::{self, Chooser, Crossing, Histogram, Levels, TICKS_PER_SAMPLE, candidates};
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt};
use crate::grid;
use crate::input::Input;
use crate::sink::Output;

/// Stamps that the sample period is looked for in.
const STAMPS: usize = 1024;
/// Histograms kept at once: 4 MiB.
const HISTOGRAMS: usize = 8;

struct Vcd {
    input: Input,
    options: OpenOptions,
    header: Header,
    channels: Vec<Channel>,
    /// The sample period in ticks: a voltage held longer than that did not rise all the while.
    period: Option<u64>,
    signals: Vec<Option<Signal>>,
}

pub(crate) fn open(input: &Input, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let mut tokens = Tokens::new(input);
    let mut header = header::read(&mut tokens)?;
    let begin = tokens.place();
    let mut channels: Vec<Channel> = header
        .channels
        .iter()
        .map(|(name, real)| {
            let kind = if *real { ChannelKind::Analogue } else { ChannelKind::Digital };
            Channel::new(name, kind, 1)
        })
        .collect();
    if channels.is_empty() {
        return Err(CaptureError::damaged(begin, "no wire and no voltage is declared"));
    }
    header.samplerate = options.samplerate.or(header.samplerate);
    let timebase = header.timebase;
    let period = header.samplerate.map(|rate| {
        let (ticks, seconds) = (u128::from(timebase.ticks()), u128::from(timebase.seconds()));
        let per_second = u128::from(rate.hertz()) * seconds;
        u64::try_from((ticks + per_second / 2) / per_second).unwrap_or(u64::MAX).max(1)
    });
    let resolution = match period {
        Some(period) => period,
        None => grid::step(&stamps(tokens), timebase),
    };
    for channel in &mut channels {
        channel.resolution_ticks = match channel.kind {
            ChannelKind::Digital => resolution,
            _ => period.map_or(resolution, |period| (period / TICKS_PER_SAMPLE).max(1)),
        };
    }
    channels.extend(analogue::differences(&channels));
    let reader = Vcd {
        input: input.clone(),
        options: *options,
        period,
        signals: vec![None; channels.len()],
        channels: channels.clone(),
        header,
    };
    let samplerate = reader.header.samplerate;
    Ok(Capture::new(Format::Vcd, timebase, samplerate, channels, reader))
}

/// The first time stamps; what is wrong with them is found when they are streamed.
fn stamps(mut tokens: Tokens) -> Vec<u64> {
    let mut stamps = Vec::new();
    while stamps.len() < STAMPS {
        match tokens.next() {
            Ok(Some([b'#', digits @ ..])) => stamps.extend(stamp(digits)),
            Ok(Some(_)) => {}
            Ok(None) | Err(_) => break,
        }
    }
    stamps
}

impl Reader for Vcd {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        self.find_levels(out);
        let mut levels = Vec::new();
        for (channel, (kind, signal)) in self.channels.iter().zip(&self.signals).enumerate() {
            let signal = match kind.kind {
                ChannelKind::Digital => Signal::Digital,
                _ => signal.unwrap_or(Signal::Flat),
            };
            levels.push(match signal {
                Signal::TwoLevels(levels) if out.wants(channel) => Some(levels),
                _ => None,
            });
            if let (true, Some(slot)) = (out.wants(channel), report.signals.get_mut(channel)) {
                *slot = signal;
            }
        }
        if self.header.left_out > 0 {
            let left_out = self.header.left_out;
            report.notes.push(format!("{left_out} wires beyond the first 1024 are not read"));
        }
        let (total, period) = (self.input.len(), self.period.unwrap_or(0));
        let mut emit = Emit::new(out, &self.channels, &levels, period, total);
        let end = self.changes().pass(&mut emit)?;
        (0..self.channels.len()).try_for_each(|channel| out.end(channel, end))?;
        out.progress(total, total);
        Ok(())
    }
}

impl Vcd {
    const fn changes(&self) -> Changes<'_> {
        Changes { input: &self.input, variables: &self.header.variables }
    }

    /// Finds the levels of the wanted voltages that are not known yet.
    fn find_levels(&mut self, out: &Output<'_>) {
        let unknown: Vec<usize> = (0..self.channels.len())
            .filter(|&n| out.wants(n) && self.signals.get(n) == Some(&None))
            .filter(|&n| self.channels.get(n).is_some_and(|c| c.kind != ChannelKind::Digital))
            .collect();
        for group in unknown.chunks(HISTOGRAMS) {
            for (channel, levels) in self.levels(group) {
                if let Some(slot) = self.signals.get_mut(channel) {
                    *slot = Some(levels.map_or(Signal::Flat, Signal::TwoLevels));
                }
            }
        }
    }

    fn levels(&self, group: &[usize]) -> Vec<(usize, Option<Levels>)> {
        if let Some(threshold) = self.options.threshold {
            let levels = Some(Crossing::levels(threshold));
            return group.iter().map(|&channel| (channel, levels)).collect();
        }
        let count = group.iter().map(|&n| (n, Study::Count(Histogram::new()))).collect();
        let counted = self.study(count);
        let cross = counted.into_iter().map(|(n, study)| match study {
            Study::Count(histogram) => (n, Study::Cross(Chooser::new(candidates(&histogram)))),
            other => (n, other),
        });
        let crossed = self.study(cross.collect());
        let choice = |(n, study): (usize, Study)| match study {
            Study::Cross(chooser) => (n, chooser.choice()),
            Study::Count(_) => (n, None),
        };
        crossed.into_iter().map(choice).collect()
    }

    /// Studies the voltages up to the first damage, which the pass for the edges will report.
    fn study(&self, studies: Vec<(usize, Study)>) -> Vec<(usize, Study)> {
        let mut scan = Scan::new(&self.channels, studies);
        let _ = self.changes().pass(&mut scan);
        scan.studies
    }
}
