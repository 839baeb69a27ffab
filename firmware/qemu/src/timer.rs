//! A model of a timer with input capture, and what its interrupt hands to the main loop.

pub use canbaud_capture_queue::{CaptureQueue, Taken};

/// The timer: a recording in place of the pin.
#[derive(Debug)]
pub struct CaptureTimer<'a> {
    edges: core::slice::Iter<'a, u32>,
}

impl<'a> CaptureTimer<'a> {
    /// A timer that will capture these edges.
    #[must_use]
    pub fn new(edges: &'a [u32]) -> Self {
        Self { edges: edges.iter() }
    }

    /// The interrupt, for up to `count` edges; `false` once there is none.
    pub fn interrupt<const N: usize>(&mut self, queue: &CaptureQueue<N>, count: usize) -> bool {
        let mut any = false;
        for &stamp in self.edges.by_ref().take(count) {
            queue.put(stamp);
            any = true;
        }
        any
    }
}
