//! Where edges go, and the bookkeeping that every reader shares.

use core::ops::ControlFlow;

use canbaud::wire::Logic;

use crate::error::Halt;

/// Takes the edges of a capture.
///
/// Calls for one channel come in the order `begin`, `edges`…, `end`, and again after a gap in the
/// recording. Channels come interleaved or one after the other, as the file holds them.
pub trait EdgeSink {
    /// An unbroken recording starts at tick `at` with `level`.
    fn begin(&mut self, channel: usize, at: u64, level: Logic);

    /// Edges at these ticks, strictly rising and after `begin`; each toggles the level.
    ///
    /// [`ControlFlow::Break`] ends the whole stream.
    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()>;

    /// The unbroken recording ends at tick `at`.
    fn end(&mut self, channel: usize, at: u64);

    /// How far the reader is; called about once per block read.
    fn progress(&mut self, done_bytes: u64, total_bytes: u64) {
        let _ = (done_bytes, total_bytes);
    }
}

/// Edges handed over at once: large enough that a call costs nothing per edge, and 128 KiB is
/// small enough for many channels.
const BLOCK: usize = 8192;

enum State {
    /// Nothing is recorded now.
    Gap,
    /// `begin` is not yet handed over: a change on the same tick replaces its level.
    Starting { at: u64, level: Logic },
    /// Handed over; `buffer` holds what is not.
    Running { level: Logic },
}

struct Track {
    state: State,
    buffer: Vec<u64>,
    edges: u64,
    /// The last tick heard of.
    last: u64,
}

/// The selected channels of a stream on their way to the sink.
pub(crate) struct Output<'a> {
    sink: &'a mut dyn EdgeSink,
    tracks: Vec<Option<Track>>,
}

impl<'a> Output<'a> {
    pub(crate) fn new(sink: &'a mut dyn EdgeSink, selected: &[bool]) -> Self {
        let tracks = selected
            .iter()
            .map(|&on| {
                on.then(|| Track { state: State::Gap, buffer: Vec::new(), edges: 0, last: 0 })
            })
            .collect();
        Self { sink, tracks }
    }

    pub(crate) fn wants(&self, channel: usize) -> bool {
        matches!(self.tracks.get(channel), Some(Some(_)))
    }

    /// Edges of a channel handed over so far.
    pub(crate) fn edge_count(&self, channel: usize) -> u64 {
        self.tracks.get(channel).and_then(Option::as_ref).map_or(0, |track| track.edges)
    }

    pub(crate) fn progress(&mut self, done: u64, total: u64) {
        self.sink.progress(done.min(total), total);
    }

    /// The channel has `level` from tick `at` on; `at` never falls.
    pub(crate) fn level(&mut self, channel: usize, at: u64, level: Logic) -> Result<(), Halt> {
        let Some(Some(track)) = self.tracks.get_mut(channel) else { return Ok(()) };
        track.last = at;
        match &mut track.state {
            State::Gap => {
                track.state = State::Starting { at, level };
                Ok(())
            }
            State::Starting { at: begin, level: first } if *begin == at => {
                *first = level;
                Ok(())
            }
            State::Starting { level: now, .. } | State::Running { level: now } => {
                if *now == level {
                    Ok(())
                } else {
                    self.edge(channel, at)
                }
            }
        }
    }

    /// The level of a running channel toggles at tick `at`; two edges on one tick cancel out.
    pub(crate) fn edge(&mut self, channel: usize, at: u64) -> Result<(), Halt> {
        let Some(Some(track)) = self.tracks.get_mut(channel) else { return Ok(()) };
        track.last = at;
        if let State::Starting { at: begin, level } = track.state {
            if begin == at {
                track.state = State::Starting { at, level: level.toggled() };
                return Ok(());
            }
            self.sink.begin(channel, begin, level);
            track.state = State::Running { level };
        }
        let State::Running { level } = &mut track.state else { return Ok(()) };
        *level = level.toggled();
        if track.buffer.last() == Some(&at) {
            track.buffer.pop();
            return Ok(());
        }
        if track.buffer.len() >= BLOCK {
            // The last edge stays back: one on the same tick may still cancel it.
            let held = track.buffer.pop();
            track.edges += track.buffer.len() as u64;
            let flow = self.sink.edges(channel, &track.buffer);
            track.buffer.clear();
            track.buffer.extend(held);
            if flow.is_break() {
                return Err(Halt::Stopped);
            }
        }
        track.buffer.push(at);
        Ok(())
    }

    /// The unbroken recording of a channel ends at tick `at`, if one runs.
    pub(crate) fn end(&mut self, channel: usize, at: u64) -> Result<(), Halt> {
        let Some(Some(track)) = self.tracks.get_mut(channel) else { return Ok(()) };
        match track.state {
            State::Gap => return Ok(()),
            State::Starting { at: begin, level } => self.sink.begin(channel, begin, level),
            State::Running { .. } => {}
        }
        track.state = State::Gap;
        let at = at.max(track.last);
        track.last = at;
        track.edges += track.buffer.len() as u64;
        let flow = if track.buffer.is_empty() {
            ControlFlow::Continue(())
        } else {
            self.sink.edges(channel, &track.buffer)
        };
        track.buffer.clear();
        self.sink.end(channel, at);
        if flow.is_break() { Err(Halt::Stopped) } else { Ok(()) }
    }

    /// Ends every running channel where it was last heard of: what precedes damage is delivered.
    pub(crate) fn end_all(&mut self) {
        for channel in 0..self.tracks.len() {
            let last = self.tracks.get(channel).and_then(Option::as_ref).map_or(0, |t| t.last);
            // Nothing follows that a stop could prevent.
            let _ = self.end(channel, last);
        }
    }

    /// The last tick heard of on a channel.
    pub(crate) fn note_time(&mut self, channel: usize, at: u64) {
        if let Some(Some(track)) = self.tracks.get_mut(channel) {
            track.last = track.last.max(at);
        }
    }
}
