//! Stretches of runs that may be one frame, found without a bit time.
//!
//! Inside a frame no run is longer than six bits; before and behind it the line is recessive for
//! ten or more. So a frame begins and ends with runs of one level that are at least one and a
//! half times as long as any run of that level in between. A shorter pattern of that shape occurs inside
//! frames, too, so several beginnings are kept until a longer run refutes them.

use crate::wire::Logic;

/// Fewest runs of a frame: even with every bit stuffed, 34 bits have seven.
const RUNS_MIN: usize = 7;
/// Beginnings kept at a time.
const STARTS: usize = 4;

/// A run that may be the idle before a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Start {
    /// Index of the first run of the frame.
    at: usize,
    /// Length of the run before.
    before: u32,
    /// The longest run since at the level of the idle.
    longest_idle: u32,
    /// The longest run since at the other level.
    longest_other: u32,
}

/// A stretch that may be a frame: `runs[at..]`, with the level of the runs around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Candidate {
    pub(super) at: usize,
    pub(super) idle: Logic,
    /// The idle before; endless where the recording begins in it.
    pub(super) before: u32,
    /// The idle behind; endless where the recording ends in it.
    pub(super) behind: u32,
    pub(super) gap: u32,
}

/// What ended a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Edge,
    /// The recording, perhaps before the line had been idle for long.
    OfRecording,
}

/// The runs since the oldest possible beginning, at most `N`.
#[derive(Debug, Clone)]
pub(super) struct Segmenter<const N: usize> {
    runs: [u32; N],
    len: usize,
    starts: [Option<Start>; STARTS],
    /// Level of the run that comes next.
    level: Logic,
    began: Began,
}

/// What the run that comes next begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Began {
    /// With the recording: it may have been any longer.
    WithTheRecording,
    WithAnEdge,
}

impl Start {
    const fn new(at: usize, before: u32) -> Self {
        Self { at, before, longest_idle: 0, longest_other: 0 }
    }

    /// Whether a run of `run` ticks is idle beside the runs since.
    ///
    /// An error flag may be longer than the eleven bits of idle behind it, so less is asked
    /// against the other level.
    fn is_idle_beside(&self, run: u32) -> bool {
        let run = u64::from(run);
        run * 2 >= u64::from(self.longest_idle) * 3 && run * 4 >= u64::from(self.longest_other) * 3
    }
}

impl<const N: usize> Segmenter<N> {
    pub(super) const fn new() -> Self {
        Self {
            runs: [0; N],
            len: 0,
            starts: [None; STARTS],
            level: Logic::High,
            began: Began::WithTheRecording,
        }
    }

    /// Unbroken recording begins at `level`.
    pub(super) fn begin(&mut self, level: Logic) {
        self.len = 0;
        self.starts = [None; STARTS];
        self.level = level;
        self.began = Began::WithTheRecording;
    }

    pub(super) fn runs_from(&self, at: usize) -> &[u32] {
        self.runs.get(at..self.len).unwrap_or(&[])
    }

    /// The next stretch that the run of `run` ticks, which just ended, may be the end of.
    /// Ask again with `skip` raised by one until there is none; then [`Segmenter::store`] the run.
    pub(super) fn candidate(&self, run: u32, end: End, skip: usize) -> Option<Candidate> {
        self.starts
            .iter()
            .flatten()
            .filter(|start| {
                let count = self.len - start.at;
                // Two of three edges are done with here.
                count % 2 == 1
                    && count >= RUNS_MIN
                    && (end == End::OfRecording || start.is_idle_beside(run))
            })
            .nth(skip)
            .map(|start| Candidate {
                at: start.at,
                idle: self.level,
                before: start.before,
                behind: match end {
                    End::Edge => run,
                    End::OfRecording => u32::MAX,
                },
                gap: run,
            })
    }

    /// Goes on behind the run of `run` ticks.
    pub(super) fn store(&mut self, run: u32) {
        if self.len == N {
            self.make_room();
        }
        // The latest beginning, and the longest run since of the level of this one.
        let (mut latest, mut longest_since) = (0, 0);
        for slot in &mut self.starts {
            let Some(start) = slot else { continue };
            let longest = match (self.len - start.at) % 2 {
                0 => &mut start.longest_other,
                _ => &mut start.longest_idle,
            };
            let grew = run > *longest;
            *longest = run.max(*longest);
            let since = *longest;
            if grew && !start.is_idle_beside(start.before) {
                *slot = None;
            } else if start.at >= latest {
                (latest, longest_since) = (start.at, since);
            }
        }
        // The longest run of its level since the latest beginning may be idle itself.
        let is_start = run >= longest_since;
        if let Some(slot) = self.runs.get_mut(self.len) {
            *slot = run;
            self.len += 1;
        }
        if is_start {
            self.add(Start::new(self.len, self.idle_before(run)));
        }
        self.began = Began::WithAnEdge;
        self.level = self.level.toggled();
    }

    /// A frame ended with the run of `run` ticks: only what comes behind it matters.
    pub(super) fn restart(&mut self, run: u32) {
        self.len = 0;
        self.starts = [None; STARTS];
        self.add(Start::new(0, run));
        self.began = Began::WithAnEdge;
        self.level = self.level.toggled();
    }

    /// The recording has ended: nothing is kept.
    pub(super) fn stop(&mut self) {
        self.len = 0;
        self.starts = [None; STARTS];
        self.began = Began::WithTheRecording;
    }

    const fn idle_before(&self, run: u32) -> u32 {
        match self.began {
            Began::WithTheRecording => u32::MAX,
            Began::WithAnEdge => run,
        }
    }

    /// Adds a beginning; the one with the shortest run before it goes if there is no room.
    fn add(&mut self, start: Start) {
        let slot = match self.starts.iter().position(Option::is_none) {
            Some(free) => self.starts.get_mut(free),
            None => self.starts.iter_mut().min_by_key(|slot| slot.map_or(0, |s| s.before)),
        };
        if let Some(slot) = slot {
            *slot = Some(start);
        }
    }

    /// Drops the runs before the oldest beginning; the oldest beginning itself, if that is none.
    fn make_room(&mut self) {
        if let Some(slot) = self.starts.iter_mut().find(|slot| slot.is_some_and(|s| s.at == 0)) {
            *slot = None;
        }
        let oldest = self.starts.iter().flatten().map(|start| start.at).min().unwrap_or(self.len);
        for to in 0..self.len - oldest {
            let run = self.runs.get(oldest + to).copied().unwrap_or(0);
            if let Some(slot) = self.runs.get_mut(to) {
                *slot = run;
            }
        }
        self.len -= oldest;
        for start in self.starts.iter_mut().flatten() {
            start.at -= oldest;
        }
    }
}
