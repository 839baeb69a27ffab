//! A model of a timer with input capture, and what its interrupt hands to the main loop.

use core::sync::atomic::{AtomicU32, Ordering};

/// Times of edges from an interrupt to the main loop: one writes, one reads, nobody waits.
///
/// `N` is a power of two; loads and stores of words are all it needs, so it works on a Cortex-M0.
#[derive(Debug)]
pub struct CaptureQueue<const N: usize> {
    stamps: [AtomicU32; N],
    /// Edges written so far, by the interrupt only.
    written: AtomicU32,
    /// Edges taken so far, by the main loop only.
    taken: AtomicU32,
    /// Counts captures that were overwritten before they were read (overcapture).
    overruns: AtomicU32,
    seen: AtomicU32,
}

/// What the main loop gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// The time of an edge.
    Edge(u32),
    /// There is none at the moment.
    Nothing,
    /// Edges are missing: the detector has to begin anew.
    Lost,
}

impl<const N: usize> CaptureQueue<N> {
    /// Without edges.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self {
            stamps: [const { AtomicU32::new(0) }; N],
            written: AtomicU32::new(0),
            taken: AtomicU32::new(0),
            overruns: AtomicU32::new(0),
            seen: AtomicU32::new(0),
        }
    }

    /// The interrupt: keeps the time of an edge.
    #[inline]
    pub fn put(&self, stamp: u32) {
        let at = self.written.load(Ordering::Relaxed);
        if let Some(slot) = self.stamps.get(at as usize % N) {
            slot.store(stamp, Ordering::Relaxed);
        }
        // The edge is there before it is counted.
        self.written.store(at.wrapping_add(1), Ordering::Release);
    }

    /// The interrupt: the capture register was overwritten.
    pub fn note_overrun(&self) {
        self.overruns
            .store(self.overruns.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    }

    /// The main loop: the next edge.
    pub fn take(&self) -> Taken {
        let (written, taken) =
            (self.written.load(Ordering::Acquire), self.taken.load(Ordering::Relaxed));
        let overruns = self.overruns.load(Ordering::Relaxed);
        let pending = written.wrapping_sub(taken);
        if overruns != self.seen.load(Ordering::Relaxed) || pending as usize > N {
            self.seen.store(overruns, Ordering::Relaxed);
            self.taken.store(written, Ordering::Relaxed);
            return Taken::Lost;
        }
        if pending == 0 {
            return Taken::Nothing;
        }
        let stamp =
            self.stamps.get(taken as usize % N).map_or(0, |slot| slot.load(Ordering::Relaxed));
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Taken::Edge(stamp)
    }
}

impl<const N: usize> Default for CaptureQueue<N> {
    fn default() -> Self {
        Self::new()
    }
}

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
