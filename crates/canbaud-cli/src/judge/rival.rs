//! A second bit rate on one line: two recordings in one file, a bus that changed its rate, a node
//! that talks at another.

use std::ops::ControlFlow;

use canbaud::detect::{PulseDetector, Verdict};
use canbaud::wire::Logic;
use canbaud_capture::EdgeSink;

use super::channel::RUNS;
use super::known::Grid;

/// Runs the detector over a whole line.
pub(super) struct RivalSeeker {
    detector: Box<PulseDetector<RUNS>>,
    grid: Grid,
}

impl RivalSeeker {
    pub(super) fn new(grid: Grid) -> Self {
        Self { detector: Box::new(PulseDetector::new()), grid }
    }

    pub(super) fn verdict(&self) -> Verdict {
        self.detector.verdict()
    }
}

/// Every channel to its seeker.
pub(super) struct AllLines<'a> {
    pub(super) lines: &'a mut [RivalSeeker],
}

impl EdgeSink for AllLines<'_> {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if let Some(line) = self.lines.get_mut(channel) {
            line.detector.begin(line.grid.of(at), level);
        }
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        if let Some(line) = self.lines.get_mut(channel) {
            for at in line.grid.of_edges(times) {
                line.detector.push(at);
            }
        }
        ControlFlow::Continue(())
    }

    fn end(&mut self, channel: usize, at: u64) {
        if let Some(line) = self.lines.get_mut(channel) {
            line.detector.finish(line.grid.of(at));
        }
    }
}
