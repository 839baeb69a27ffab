//! Rows to edges.

use canbaud::wire::Logic;

use super::clock::{self, Clock, Timed};
use super::header::{self, Content, Header};
use super::rows::{Cell, Row, Rows, Table};
use crate::Format;
use crate::analogue::{self, Chooser, Crossing, Histogram, Levels, candidates};
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt, Place};
use crate::input::Input;
use crate::sink::Output;

/// Rows between two words on the progress.
const PROGRESS: u64 = 16 * 1024;

/// Histograms kept at once: 4 MiB.
const HISTOGRAMS: usize = 8;

/// What a channel is made of.
#[derive(Debug, Clone, Copy)]
enum Wire {
    Digital { column: usize },
    Bit { column: usize, bit: u32 },
    Volts { column: usize },
    Difference { high: usize, low: usize },
}

struct Csv {
    input: Input,
    options: OpenOptions,
    table: Table,
    wires: Vec<Wire>,
    /// What is known of each channel.
    signals: Vec<Option<Signal>>,
}

pub(crate) fn open(
    input: &Input,
    format: Option<Format>,
    options: &OpenOptions,
) -> Result<Capture, CaptureError> {
    let header = header::sniff(input)?.ok_or_else(|| {
        CaptureError::Unrecognised("no row of numbers in the first 64 KiB".into())
    })?;
    let (mut channels, mut wires) = wires(&header);
    if channels.is_empty() {
        return Err(CaptureError::damaged(
            Place::Line(header.lines + 1),
            "no column holds levels or voltages",
        ));
    }
    let interpolated = channels.iter().any(|c| c.kind == ChannelKind::Analogue);
    let Timed { clock, timebase, samplerate, digital_step } =
        clock::find(&header, input, options, interpolated)?;
    for channel in &mut channels {
        let digital = channel.kind == ChannelKind::Digital;
        channel.resolution_ticks = if digital { digital_step } else { 1 };
    }
    for difference in analogue::differences(&channels) {
        if let ChannelKind::Difference(high, low) = difference.kind {
            wires.push(Wire::Difference { high, low });
            channels.push(difference);
        }
    }
    let reader = Csv {
        input: input.clone(),
        options: *options,
        table: Table {
            dialect: header.dialect,
            skip: header.lines,
            columns: header.columns.iter().map(|(_, content)| *content).collect(),
            clock,
        },
        signals: vec![None; wires.len()],
        wires,
    };
    let format = format.unwrap_or(header.format);
    Ok(Capture::new(format, timebase, samplerate, channels, reader))
}

fn wires(header: &Header) -> (Vec<Channel>, Vec<Wire>) {
    let mut channels = Vec::new();
    let mut wires = Vec::new();
    for (column, (name, content)) in header.columns.iter().enumerate() {
        match *content {
            Content::Ignored => {}
            Content::Digital => {
                channels.push(Channel::new(name, ChannelKind::Digital, 1));
                wires.push(Wire::Digital { column });
            }
            Content::Hex(bits) => {
                // `D15-D8` holds D8 and up.
                let digits = |n: &str| {
                    n.trim_start_matches(|c: char| !c.is_ascii_digit()).parse::<u32>().ok()
                };
                let base = name.rsplit_once('-').and_then(|(_, low)| digits(low));
                for bit in 0..bits {
                    let name = match base {
                        Some(base) => format!("D{}", base.saturating_add(bit)),
                        None => format!("{name}[{bit}]"),
                    };
                    channels.push(Channel::new(name, ChannelKind::Digital, 1));
                    wires.push(Wire::Bit { column, bit });
                }
            }
            Content::Volts(_) => {
                channels.push(Channel::new(name, ChannelKind::Analogue, 1));
                wires.push(Wire::Volts { column });
            }
        }
    }
    (channels, wires)
}

impl Reader for Csv {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        self.find_levels(out);
        let mut tracks = Vec::new();
        for (channel, (wire, signal)) in self.wires.iter().zip(&self.signals).enumerate() {
            if !out.wants(channel) {
                continue;
            }
            let signal = match wire {
                Wire::Digital { .. } | Wire::Bit { .. } => Signal::Digital,
                Wire::Volts { .. } | Wire::Difference { .. } => signal.unwrap_or(Signal::Flat),
            };
            if let Some(slot) = report.signals.get_mut(channel) {
                *slot = signal;
            }
            let crossing = match signal {
                Signal::TwoLevels(levels) => Some(Crossing::new(channel, levels.threshold)),
                _ => None,
            };
            tracks.push(Track { channel, wire: *wire, crossing });
        }
        let table = self.table(|channel| out.wants(channel));
        let mut rows = Rows::new(&table, &self.input)?;
        let mut row = Row { at: 0, cells: Vec::new() };
        while rows.next(&mut row)? {
            for track in &mut tracks {
                track.row(&row, &self.wires, out)?;
            }
            if rows.count().is_multiple_of(PROGRESS) {
                out.progress(rows.done(), self.input.len());
            }
        }
        // Rows are samples and last until the next one; stamps are instants.
        let end = match self.table.clock {
            Clock::Rows { step } | Clock::Sigrok { step, .. } => row.at.saturating_add(step),
            Clock::Stamps { .. } => row.at,
        };
        tracks.iter().try_for_each(|track| out.end(track.channel, end))?;
        out.progress(self.input.len(), self.input.len());
        Ok(())
    }
}

/// A selected channel on its way through the rows.
struct Track {
    channel: usize,
    wire: Wire,
    crossing: Option<Crossing>,
}

impl Track {
    fn row(&mut self, row: &Row, wires: &[Wire], out: &mut Output<'_>) -> Result<(), Halt> {
        let logic = |high| if high { Logic::High } else { Logic::Low };
        match self.wire {
            Wire::Digital { column } => match row.cells.get(column) {
                Some(Cell::Level(Some(high))) => out.level(self.channel, row.at, logic(*high)),
                Some(Cell::Level(None)) => out.end(self.channel, row.at),
                _ => Ok(()),
            },
            Wire::Bit { column, bit } => match row.cells.get(column) {
                Some(Cell::Word(word)) => {
                    out.level(self.channel, row.at, logic(word >> bit & 1 == 1))
                }
                _ => Ok(()),
            },
            Wire::Volts { .. } | Wire::Difference { .. } => {
                match (&mut self.crossing, volts(self.wire, wires, row)) {
                    (Some(crossing), Some(volts)) => crossing.sample(row.at, volts, out),
                    _ => Ok(()),
                }
            }
        }
    }
}

/// The voltage of an analogue channel in a row, if the row has one.
fn volts(wire: Wire, wires: &[Wire], row: &Row) -> Option<f64> {
    let single = |wire: Option<&Wire>| match wire {
        Some(Wire::Volts { column }) => match row.cells.get(*column) {
            Some(Cell::Volts(volts)) => Some(*volts),
            _ => None,
        },
        _ => None,
    };
    match wire {
        Wire::Difference { high, low } => Some(single(wires.get(high))? - single(wires.get(low))?),
        _ => single(Some(&wire)),
    }
}

impl Csv {
    /// The table with only those columns that the wanted channels need.
    fn table(&self, wants: impl Fn(usize) -> bool) -> Table {
        let mut needed = vec![false; self.table.columns.len()];
        let mut need = |wire: Option<&Wire>| {
            let column = match wire {
                Some(
                    Wire::Digital { column } | Wire::Bit { column, .. } | Wire::Volts { column },
                ) => *column,
                _ => return,
            };
            if let Some(slot) = needed.get_mut(column) {
                *slot = true;
            }
        };
        for (channel, wire) in self.wires.iter().enumerate().filter(|&(channel, _)| wants(channel))
        {
            if let Wire::Difference { high, low } = *wire {
                need(self.wires.get(high));
                need(self.wires.get(low));
            }
            need(self.wires.get(channel));
        }
        let mut table = self.table.clone();
        for (content, needed) in table.columns.iter_mut().zip(needed) {
            if !needed {
                *content = Content::Ignored;
            }
        }
        table
    }

    /// Finds the levels of the wanted analogue channels that are not known yet.
    fn find_levels(&mut self, out: &Output<'_>) {
        let unknown: Vec<usize> = self
            .wires
            .iter()
            .enumerate()
            .filter(|(_, wire)| matches!(wire, Wire::Volts { .. } | Wire::Difference { .. }))
            .map(|(channel, _)| channel)
            .filter(|&channel| out.wants(channel) && self.signals.get(channel) == Some(&None))
            .collect();
        for group in unknown.chunks(HISTOGRAMS) {
            for (&channel, levels) in group.iter().zip(self.levels(group)) {
                if let Some(slot) = self.signals.get_mut(channel) {
                    *slot = Some(levels.map_or(Signal::Flat, Signal::TwoLevels));
                }
            }
        }
    }

    fn levels(&self, channels: &[usize]) -> Vec<Option<Levels>> {
        if let Some(threshold) = self.options.threshold {
            return vec![Some(Crossing::levels(threshold)); channels.len()];
        }
        let mut histograms: Vec<Histogram> = channels.iter().map(|_| Histogram::new()).collect();
        self.scan(channels, |n, volts| {
            if let Some(histogram) = histograms.get_mut(n) {
                histogram.add(&[volts]);
            }
        });
        let found: Vec<Vec<Levels>> = histograms.iter().map(candidates).collect();
        drop(histograms);
        if found.iter().all(|candidates| candidates.len() < 2) {
            return found.iter().map(|candidates| candidates.first().copied()).collect();
        }
        let mut choosers: Vec<Chooser> = found.into_iter().map(Chooser::new).collect();
        self.scan(channels, |n, volts| {
            if let Some(chooser) = choosers.get_mut(n) {
                chooser.add(&[volts]);
            }
        });
        choosers.iter().map(Chooser::choice).collect()
    }

    /// Shows the voltages of `channels` up to the first damage, which the pass for the edges will
    /// report.
    fn scan(&self, channels: &[usize], mut take: impl FnMut(usize, f32)) {
        let table = self.table(|channel| channels.contains(&channel));
        let Ok(mut rows) = Rows::new(&table, &self.input) else { return };
        let mut row = Row { at: 0, cells: Vec::new() };
        while let Ok(true) = rows.next(&mut row) {
            for (n, &channel) in channels.iter().enumerate() {
                let wire = self.wires.get(channel);
                if let Some(volts) = wire.and_then(|&wire| volts(wire, &self.wires, &row)) {
                    take(n, volts as f32);
                }
            }
        }
    }
}
