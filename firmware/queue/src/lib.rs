//! Times of edges from a capture interrupt to the main loop: one writes, one reads, nobody waits.
#![no_std]
#![forbid(unsafe_code)]

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_come_out_in_order_and_a_full_queue_says_so() {
        let queue = CaptureQueue::<4>::new();
        assert_eq!(queue.take(), Taken::Nothing);
        (1..=4).for_each(|stamp| queue.put(stamp));
        for stamp in 1..=4 {
            assert_eq!(queue.take(), Taken::Edge(stamp));
        }
        (5..=9).for_each(|stamp| queue.put(stamp));
        assert_eq!(queue.take(), Taken::Lost);
        assert_eq!(queue.take(), Taken::Nothing);
        queue.put(10);
        assert_eq!(queue.take(), Taken::Edge(10));
    }

    #[test]
    fn an_overrun_is_told_once() {
        let queue = CaptureQueue::<4>::new();
        queue.put(1);
        queue.note_overrun();
        assert_eq!(queue.take(), Taken::Lost);
        queue.put(2);
        assert_eq!(queue.take(), Taken::Edge(2));
    }
}
