//! A model of a timer with input capture, and what its interrupt hands to the main loop.

use canbaud::wire::Logic;
use canbaud_capture_queue::Edge;
pub use canbaud_capture_queue::{CaptureQueue, Recorder};

/// The timer: a recording in place of the pin.
#[derive(Debug)]
pub struct CaptureTimer<'a> {
    edges: core::slice::Iter<'a, u32>,
    /// Of the pin, as far as it was captured.
    level: Logic,
}

impl<'a> CaptureTimer<'a> {
    /// A timer that will capture these edges of a pin at `level`.
    #[must_use]
    pub fn new(level: Logic, edges: &'a [u32]) -> Self {
        Self { edges: edges.iter(), level }
    }

    /// The interrupt, for up to `count` edges; `false` once there is none.
    pub fn interrupt<const N: usize>(&mut self, queue: &CaptureQueue<N>, count: usize) -> bool {
        let mut any = false;
        for &stamp in self.edges.by_ref().take(count) {
            self.level = self.level.toggled();
            queue.put(Edge::new(stamp, self.level));
            any = true;
        }
        any
    }
}
