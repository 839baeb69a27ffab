//! From a capture to reports: finds the channel and the rate, decodes, counts.
//!
//! `channel` follows one line: it feeds the edges to the detector until a rate is proven, then to
//! the decoder, without losing those in between. `evidence` counts what the decoder finds.
//! `rival` looks for a second rate on a line with many errors.
//! `conclude` turns all of it into a report, `caveats` adds what a person should know.

mod caveats;
mod channel;
mod conclude;
mod evidence;
mod known;
mod rival;
mod sink;

use std::cmp::Reverse;
use std::ops::ControlFlow;

use canbaud::units::Bitrate;
use canbaud::wire::{Item, Polarity};
use canbaud_capture::{Capture, CaptureError};

use crate::report::ChannelReport;
use channel::ChannelJudge;
use known::Grid;
use rival::{AllLines, RivalSeeker};
use sink::{AllChannels, OneChannel, Probe};

/// What the user knows already.
#[derive(Debug, Clone)]
pub(crate) struct JudgeOptions {
    pub(crate) channel: Option<String>,
    pub(crate) bitrate: Option<Bitrate>,
    pub(crate) data_bitrate: Option<Bitrate>,
    pub(crate) polarity: Option<Polarity>,
}

/// All channels, the one that carries the bus first.
pub(crate) fn detect(
    capture: &mut Capture,
    options: &JudgeOptions,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<ChannelReport>, CaptureError> {
    let wanted = select(capture, options)?;
    let mut judges = judges(capture, wanted.len(), options);
    let summary = capture.stream(&mut AllChannels { judges: &mut judges, progress })?;
    // A rate that was found only after the first edges were let go: those are read again.
    let again: Vec<usize> = wanted
        .iter()
        .copied()
        .filter(|&channel| judges.get(channel).is_some_and(ChannelJudge::missed_the_start))
        .collect();
    if !again.is_empty() {
        capture.select(&again);
        for &channel in &again {
            if let Some(judge) = judges.get_mut(channel) {
                judge.rewind();
            }
        }
        capture.stream(&mut AllChannels { judges: &mut judges, progress })?;
    }
    seek_rivals(capture, &wanted, &mut judges)?;
    let channels = capture.channels();
    let mut reports = Vec::new();
    for &index in &wanted {
        if let (Some(channel), Some(judge)) = (channels.get(index), judges.get_mut(index)) {
            let report = conclude::report(channel, judge, &summary.notes);
            reports.push((conclude::rank(&report, judge), report));
        }
    }
    // Stable: equal channels stay in the order of the file.
    reports.sort_by_key(|(rank, _)| Reverse(*rank));
    Ok(reports.into_iter().map(|(_, report)| report).collect())
}

/// Where many frames are destroyed at the rate found, another rate is sought on the same line.
fn seek_rivals(
    capture: &mut Capture,
    wanted: &[usize],
    judges: &mut [ChannelJudge],
) -> Result<(), CaptureError> {
    for judge in judges.iter_mut() {
        judge.conclude(&mut |_| {});
    }
    let suspects: Vec<usize> = wanted
        .iter()
        .copied()
        .filter(|&channel| judges.get(channel).is_some_and(ChannelJudge::has_many_errors))
        .collect();
    if suspects.is_empty() {
        return Ok(());
    }
    capture.select(&suspects);
    let mut seekers: Vec<RivalSeeker> =
        judges.iter().map(|judge| RivalSeeker::new(judge.grid())).collect();
    capture.stream(&mut AllLines { lines: &mut seekers })?;
    for (judge, seeker) in judges.iter_mut().zip(&seekers) {
        judge.note_rival(seeker.verdict());
    }
    Ok(())
}

/// Decodes the channel that carries the bus (or `options.channel`); items go to `sink` in time
/// order as they are decoded.
pub(crate) fn decode(
    capture: &mut Capture,
    options: &JudgeOptions,
    sink: &mut dyn FnMut(&Item) -> ControlFlow<()>,
) -> Result<ChannelReport, CaptureError> {
    let wanted = select(capture, options)?;
    let index = match wanted[..] {
        [only] => only,
        _ => busiest(capture, options, &wanted)?,
    };
    capture.select(&[index]);
    let Some(channel) = capture.channels().get(index).cloned() else {
        unreachable!("the channel was selected from this list")
    };
    let grid = Grid::new(capture.timebase(), channel.resolution_ticks);
    let mut judge = ChannelJudge::new(grid, 1, options);
    // The rate is found first, so that decoding starts with the first edge.
    {
        let mut probe = Probe::new(index, &mut judge);
        capture.stream(&mut probe)?;
        judge.conclude(&mut |_| {});
        judge.rewind();
    }
    let flow = ControlFlow::Continue(());
    let mut one = OneChannel { index, judge: &mut judge, sink, flow };
    let summary = capture.stream(&mut one)?;
    one.conclude();
    Ok(conclude::report(&channel, &mut judge, &summary.notes))
}

/// A judge for every channel of which `wanted` are judged.
fn judges(capture: &Capture, wanted: usize, options: &JudgeOptions) -> Vec<ChannelJudge> {
    let timebase = capture.timebase();
    let grids = capture.channels().iter().map(|c| Grid::new(timebase, c.resolution_ticks));
    grids.map(|grid| ChannelJudge::new(grid, wanted, options)).collect()
}

/// The channels that are judged.
fn select(capture: &mut Capture, options: &JudgeOptions) -> Result<Vec<usize>, CaptureError> {
    let names = capture.channels().iter().map(|channel| channel.name.as_str());
    let wanted: Vec<usize> = match &options.channel {
        None => (0..capture.channels().len()).collect(),
        Some(name) => names
            .enumerate()
            .filter(|(_, other)| other.eq_ignore_ascii_case(name))
            .map(|(index, _)| index)
            .collect(),
    };
    if let (true, Some(name)) = (wanted.is_empty(), &options.channel) {
        return Err(CaptureError::no_such_channel(name, capture.channels()));
    }
    capture.select(&wanted);
    Ok(wanted)
}

/// The channel whose first frames speak most clearly for it.
fn busiest(
    capture: &mut Capture,
    options: &JudgeOptions,
    wanted: &[usize],
) -> Result<usize, CaptureError> {
    let mut judges = judges(capture, wanted.len(), options);
    capture.stream(&mut sink::FirstFrames { judges: &mut judges })?;
    let channels = capture.channels();
    Ok(wanted
        .iter()
        .copied()
        .max_by_key(|&index| match (channels.get(index), judges.get_mut(index)) {
            (Some(channel), Some(judge)) => {
                let report = conclude::report(channel, judge, &[]);
                (conclude::rank(&report, judge), Reverse(index))
            }
            _ => unreachable!("indices come from the list of channels"),
        })
        .unwrap_or(0))
}
