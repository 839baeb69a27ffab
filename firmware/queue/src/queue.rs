//! The ring between interrupt and main loop.

use crate::{Before, Edge};
use canbaud::wire::Logic;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// Marks of an edge: it is rising; edges are missing before it.
const RISING: u8 = 1;
const MISSING: u8 = 1 << 1;

/// Edges from an interrupt to the main loop of the same core: one writes, one reads, nobody waits.
///
/// `N` is a power of two; loads and stores are all it needs, so it works on a Cortex-M0.
#[derive(Debug)]
pub struct CaptureQueue<const N: usize> {
    stamps: [AtomicU32; N],
    marks: [AtomicU8; N],
    /// Edges written so far, by the interrupt only.
    written: AtomicU32,
    /// Edges taken so far, by the main loop only.
    taken: AtomicU32,
}

/// What the main loop gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// An edge.
    Edge(Edge),
    /// There is none at the moment.
    Nothing,
    /// The main loop was late, and edges were overwritten; the newer half of the queue comes next.
    Lost,
}

impl<const N: usize> CaptureQueue<N> {
    /// Without edges.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self {
            stamps: [const { AtomicU32::new(0) }; N],
            marks: [const { AtomicU8::new(0) }; N],
            written: AtomicU32::new(0),
            taken: AtomicU32::new(0),
        }
    }

    /// The interrupt: keeps an edge.
    #[inline]
    pub fn put(&self, edge: Edge) {
        let at = self.written.load(Ordering::Relaxed);
        let rising = if edge.level == Logic::High { RISING } else { 0 };
        let missing = if edge.before == Before::Missing { MISSING } else { 0 };
        let index = at as usize % N;
        if let (Some(stamp), Some(mark)) = (self.stamps.get(index), self.marks.get(index)) {
            stamp.store(edge.stamp, Ordering::Relaxed);
            mark.store(rising | missing, Ordering::Relaxed);
        }
        // The edge is there before it is counted.
        self.written.store(at.wrapping_add(1), Ordering::Release);
    }

    /// The main loop: the next edge.
    pub fn take(&self) -> Taken {
        self.take_around(|| ())
    }

    /// The main loop: forgets what it has not taken.
    pub fn clear(&self) {
        self.taken.store(self.written.load(Ordering::Acquire), Ordering::Relaxed);
    }

    /// The next edge; `interrupt` may come once it is known that there is one.
    fn take_around(&self, interrupt: impl FnOnce()) -> Taken {
        let taken = self.taken.load(Ordering::Relaxed);
        if self.written.load(Ordering::Acquire) == taken {
            return Taken::Nothing;
        }
        interrupt();
        let edge = self.edge(taken as usize % N);
        // Behind the edge: only now is it certain that it was not overwritten meanwhile.
        let written = self.written.load(Ordering::Acquire);
        if written.wrapping_sub(taken) as usize > N {
            // The newer half has time to be taken before it is overwritten, too.
            self.taken.store(written.wrapping_sub(N as u32 / 2), Ordering::Relaxed);
            return Taken::Lost;
        }
        self.taken.store(taken.wrapping_add(1), Ordering::Relaxed);
        Taken::Edge(edge)
    }

    fn edge(&self, index: usize) -> Edge {
        let stamp = self.stamps.get(index).map_or(0, |stamp| stamp.load(Ordering::Acquire));
        let mark = self.marks.get(index).map_or(0, |mark| mark.load(Ordering::Acquire));
        let level = if mark & RISING != 0 { Logic::High } else { Logic::Low };
        let before = if mark & MISSING != 0 { Before::Missing } else { Before::Complete };
        Edge { stamp, level, before }
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

    /// Even stamps fall, odd ones rise.
    fn edge(stamp: u32) -> Edge {
        Edge::new(stamp, if stamp.is_multiple_of(2) { Logic::Low } else { Logic::High })
    }

    fn queue_of(stamps: core::ops::RangeInclusive<u32>) -> CaptureQueue<4> {
        let queue = CaptureQueue::new();
        stamps.for_each(|stamp| queue.put(edge(stamp)));
        queue
    }

    #[test]
    fn edges_come_out_in_order_as_they_were_put() {
        let queue = queue_of(1..=3);
        queue.put(edge(4).behind_missing());
        for stamp in 1..=3 {
            assert_eq!(queue.take(), Taken::Edge(edge(stamp)));
        }
        assert_eq!(queue.take(), Taken::Edge(edge(4).behind_missing()));
        assert_eq!(queue.take(), Taken::Nothing);
        queue.put(edge(5));
        assert_eq!(queue.take(), Taken::Edge(edge(5)), "the mark of a slot is written anew");
    }

    #[test]
    fn a_queue_that_ran_over_says_so_and_goes_on_with_its_newer_half() {
        let queue = queue_of(1..=5);
        assert_eq!(queue.take(), Taken::Lost);
        assert_eq!(queue.take(), Taken::Edge(edge(4)));
        assert_eq!(queue.take(), Taken::Edge(edge(5)));
        assert_eq!(queue.take(), Taken::Nothing);
    }

    /// The interrupt comes between the count and the edge, into a full queue: the slot that is about
    /// to be read gets another edge.
    #[test]
    fn an_edge_that_is_overwritten_while_it_is_taken_is_lost() {
        let queue = queue_of(1..=4);
        assert_eq!(queue.take_around(|| queue.put(edge(5))), Taken::Lost);
        assert_eq!(queue.take(), Taken::Edge(edge(4)));
        assert_eq!(queue.take(), Taken::Edge(edge(5)));
        assert_eq!(queue.take(), Taken::Nothing);
    }

    #[test]
    fn an_interrupt_while_an_edge_is_taken_does_no_harm_where_there_is_room() {
        let queue = queue_of(1..=3);
        assert_eq!(queue.take_around(|| queue.put(edge(4))), Taken::Edge(edge(1)));
        assert_eq!(queue.take(), Taken::Edge(edge(2)));
    }

    #[test]
    fn nothing_of_before_is_left_in_a_queue_that_was_cleared() {
        let queue = queue_of(1..=5);
        queue.clear();
        assert_eq!(queue.take(), Taken::Nothing);
        queue.put(edge(6));
        assert_eq!(queue.take(), Taken::Edge(edge(6)));
    }
}
