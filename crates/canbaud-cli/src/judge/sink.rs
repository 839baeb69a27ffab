//! How the edges of a capture reach the judges.

use std::ops::ControlFlow;

use canbaud::wire::{Item, Logic};
use canbaud_capture::EdgeSink;

use super::channel::ChannelJudge;

/// Frames that make a channel's claim clear.
const CLEAR_FRAMES: u64 = 16;

/// Nobody wants the items.
fn ignore(_: &Item) {}

/// Every channel to its judge.
pub(super) struct AllChannels<'a> {
    pub(super) judges: &'a mut [ChannelJudge],
    pub(super) progress: &'a mut dyn FnMut(u64, u64),
}

impl EdgeSink for AllChannels<'_> {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if let Some(judge) = self.judges.get_mut(channel) {
            judge.begin(at, level);
        }
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        if let Some(judge) = self.judges.get_mut(channel) {
            judge.edges(times, &mut ignore);
        }
        ControlFlow::Continue(())
    }

    fn end(&mut self, channel: usize, at: u64) {
        if let Some(judge) = self.judges.get_mut(channel) {
            judge.end(at, &mut ignore);
        }
    }

    fn progress(&mut self, done_bytes: u64, total_bytes: u64) {
        (self.progress)(done_bytes, total_bytes);
    }
}

/// Every channel to its judge, until one has shown enough frames.
pub(super) struct FirstFrames<'a> {
    pub(super) judges: &'a mut [ChannelJudge],
}

impl EdgeSink for FirstFrames<'_> {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if let Some(judge) = self.judges.get_mut(channel) {
            judge.begin(at, level);
        }
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        let Some(judge) = self.judges.get_mut(channel) else { return ControlFlow::Continue(()) };
        judge.edges(times, &mut ignore);
        if judge.frames_proven() >= CLEAR_FRAMES {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn end(&mut self, channel: usize, at: u64) {
        if let Some(judge) = self.judges.get_mut(channel) {
            judge.end(at, &mut ignore);
        }
    }
}

/// One channel to its judge, until the rate is known.
pub(super) struct Probe<'a> {
    index: usize,
    judge: &'a mut ChannelJudge,
}

impl<'a> Probe<'a> {
    pub(super) fn new(index: usize, judge: &'a mut ChannelJudge) -> Self {
        Self { index, judge }
    }
}

impl EdgeSink for Probe<'_> {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if channel == self.index {
            self.judge.begin(at, level);
        }
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        if channel == self.index {
            self.judge.edges(times, &mut ignore);
        }
        if self.judge.is_searching() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn end(&mut self, channel: usize, at: u64) {
        if channel == self.index {
            self.judge.end(at, &mut ignore);
        }
    }
}

/// One channel to its judge, its items to a sink.
pub(super) struct OneChannel<'a> {
    pub(super) index: usize,
    pub(super) judge: &'a mut ChannelJudge,
    pub(super) sink: &'a mut dyn FnMut(&Item) -> ControlFlow<()>,
    pub(super) flow: ControlFlow<()>,
}

impl OneChannel<'_> {
    /// The capture has ended.
    pub(super) fn conclude(&mut self) {
        let (sink, flow) = (&mut *self.sink, &mut self.flow);
        self.judge.conclude(&mut |item| pass(item, sink, flow));
    }
}

impl EdgeSink for OneChannel<'_> {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if channel == self.index {
            self.judge.begin(at, level);
        }
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        if channel == self.index {
            let (sink, flow) = (&mut *self.sink, &mut self.flow);
            self.judge.edges(times, &mut |item| pass(item, sink, flow));
        }
        self.flow
    }

    fn end(&mut self, channel: usize, at: u64) {
        if channel == self.index {
            let (sink, flow) = (&mut *self.sink, &mut self.flow);
            self.judge.end(at, &mut |item| pass(item, sink, flow));
        }
    }
}

/// Hands an item over unless the sink has had enough.
fn pass(item: &Item, sink: &mut dyn FnMut(&Item) -> ControlFlow<()>, flow: &mut ControlFlow<()>) {
    if flow.is_continue() {
        *flow = sink(item);
    }
}
