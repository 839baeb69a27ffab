//! Edges into a detector.

use crate::{Before, CaptureQueue, Edge, Taken};
use canbaud::detect::{CompactDetector, PulseDetector};
use canbaud::wire::Logic;

/// What takes edges: the detectors of canbaud.
pub trait Detector {
    /// Unbroken recording begins at this tick, with the line at `level`.
    fn begin(&mut self, at: u64, level: Logic);

    /// An edge at this tick, later than the one before.
    fn push(&mut self, at: u64);
}

impl<const N: usize> Detector for CompactDetector<N> {
    fn begin(&mut self, at: u64, level: Logic) {
        self.begin(at, level);
    }

    fn push(&mut self, at: u64) {
        self.push(at);
    }
}

impl<const N: usize> Detector for PulseDetector<N> {
    fn begin(&mut self, at: u64, level: Logic) {
        self.begin(at, level);
    }

    fn push(&mut self, at: u64) {
        self.push(at);
    }
}

/// Takes the edges of a queue into a detector, and begins anew by itself where one is missing.
///
/// The level comes from the edges alone, never from the pin, which is already further than they are:
/// a detector that once has the wrong level sees everything behind it inverted. A frame without all of
/// its edges is lost, and no other.
#[derive(Debug)]
pub struct Recorder {
    /// The last edge; before the first one, when captures began. The counter has 32 bits, this has
    /// 64.
    now: u64,
    line: Line,
}

/// What is known of the line at `Recorder::now`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Line {
    /// Every edge since will be told: the first one tells the level, too.
    FromHere,
    /// An edge led to this level.
    At(Logic),
    /// Edges are missing.
    Broken,
}

impl Recorder {
    /// Captures begin, with the counter at `now`; a queue with earlier ones has been cleared.
    #[must_use]
    pub const fn new(now: u32) -> Self {
        Self { now: now as u64, line: Line::FromHere }
    }

    /// Takes what is in the queue.
    pub fn take<const N: usize>(&mut self, queue: &CaptureQueue<N>, detector: &mut impl Detector) {
        loop {
            match queue.take() {
                Taken::Edge(edge) => self.edge(edge, detector),
                Taken::Lost => self.line = Line::Broken,
                Taken::Nothing => return,
            }
        }
    }

    fn edge(&mut self, edge: Edge, detector: &mut impl Detector) {
        let before = self.now;
        self.now += u64::from(edge.stamp.wrapping_sub(before as u32));
        let is_later = self.now > before;
        match (edge.before, self.line) {
            (Before::Complete, Line::FromHere) if is_later => {
                detector.begin(before, edge.level.toggled());
                detector.push(self.now);
            }
            (Before::Complete, Line::At(level)) if is_later && level != edge.level => {
                detector.push(self.now);
            }
            // Edges are missing, or two that lead to the same level say so.
            _ => detector.begin(self.now, edge.level),
        }
        self.line = Line::At(edge.level);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use Logic::{High, Low};
    use std::vec::Vec;

    /// What a detector was told.
    #[derive(Debug, Default)]
    struct Told(Vec<(u64, Option<Logic>)>);

    impl Detector for Told {
        fn begin(&mut self, at: u64, level: Logic) {
            self.0.push((at, Some(level)));
        }

        fn push(&mut self, at: u64) {
            self.0.push((at, None));
        }
    }

    fn told<const N: usize>(now: u32, edges: [Edge; N]) -> Vec<(u64, Option<Logic>)> {
        let queue = CaptureQueue::<8>::new();
        let (mut recorder, mut told) = (Recorder::new(now), Told::default());
        edges.into_iter().for_each(|edge| queue.put(edge));
        recorder.take(&queue, &mut told);
        told.0
    }

    #[test]
    fn the_first_edge_tells_the_level_since_the_beginning() {
        let falling = told(7, [Edge::new(90, Low), Edge::new(95, High)]);
        assert_eq!(falling, [(7, Some(High)), (90, None), (95, None)]);
        assert_eq!(told(7, [Edge::new(90, High)]), [(7, Some(Low)), (90, None)]);
        // Captured before the counter went on: there is no time before it.
        assert_eq!(told(0, [Edge::new(0, Low)]), [(0, Some(Low))]);
    }

    #[test]
    fn two_edges_to_the_same_level_begin_anew() {
        let edges = [Edge::new(10, Low), Edge::new(30, Low), Edge::new(35, High)];
        assert_eq!(told(0, edges), [(0, Some(High)), (10, None), (30, Some(Low)), (35, None)]);
    }

    #[test]
    fn an_edge_behind_missing_ones_begins_anew_though_its_level_fits() {
        let edges = [Edge::new(10, Low), Edge::new(40, High).behind_missing()];
        assert_eq!(told(0, edges), [(0, Some(High)), (10, None), (40, Some(High))]);
    }

    #[test]
    fn a_queue_that_ran_over_begins_anew_at_what_is_left() {
        let queue = CaptureQueue::<2>::new();
        let (mut recorder, mut told) = (Recorder::new(0), Told::default());
        queue.put(Edge::new(10, Low));
        recorder.take(&queue, &mut told);
        for (at, level) in [(12, High), (14, Low), (16, High)] {
            queue.put(Edge::new(at, level));
        }
        recorder.take(&queue, &mut told);
        queue.put(Edge::new(30, Low));
        recorder.take(&queue, &mut told);
        assert_eq!(told.0, [(0, Some(High)), (10, None), (16, Some(High)), (30, None)]);
    }

    #[test]
    fn ticks_go_on_where_the_counter_begins_again() {
        let edges = [Edge::new(u32::MAX - 3, Low), Edge::new(4, High)];
        let end = 1_u64 << 32;
        assert_eq!(told(0, edges), [(0, Some(High)), (end - 4, None), (end + 4, None)]);
    }
}
