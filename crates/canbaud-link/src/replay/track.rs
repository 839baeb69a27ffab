//! The edges of one channel.

use std::ops::ControlFlow;
use std::path::Path;

use canbaud::units::{Micros, Timebase};
use canbaud::wire::{Level, Logic, Polarity};
use canbaud_capture::{EdgeSink, OpenOptions, open};

use crate::LinkError;

/// Edges that are kept: 32 MB; what comes behind is not replayed.
const EDGES: usize = 1 << 22;

/// One unbroken recording, its edges in ticks since its beginning.
#[derive(Debug)]
pub(super) struct Track {
    pub(super) edges: Vec<u64>,
    pub(super) end: u64,
    pub(super) level: Level,
    pub(super) timebase: Timebase,
}

/// Keeps the first unbroken recording of one channel.
struct Keeper {
    channel: usize,
    begin: Option<(u64, Logic)>,
    edges: Vec<u64>,
    end: Option<u64>,
}

impl EdgeSink for Keeper {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if channel == self.channel && self.begin.is_none() {
            self.begin = Some((at, level));
        }
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        if channel != self.channel {
            return ControlFlow::Continue(());
        }
        let room = EDGES - self.edges.len();
        self.edges.extend(times.iter().take(room));
        if self.end.is_some() || room <= times.len() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn end(&mut self, channel: usize, at: u64) {
        if channel == self.channel {
            self.end.get_or_insert(at);
        }
    }
}

impl Track {
    /// Reads channel `name` of the file, or the first one; high is recessive.
    pub(super) fn read(path: &Path, name: Option<&str>) -> Result<Self, LinkError> {
        let wrong = |reason: String| {
            let path = path.display().to_string();
            LinkError::Recording { path, reason }
        };
        let cannot = |error: canbaud_capture::CaptureError| wrong(error.to_string());
        let mut capture = open(path, &OpenOptions::default()).map_err(cannot)?;
        let names: Vec<_> = capture.channels().iter().map(|one| one.name.clone()).collect();
        let channel = match name {
            None => 0,
            Some(name) => names.iter().position(|one| one == name).ok_or_else(|| {
                wrong(format!("no channel \"{name}\"; there are {}", names.join(", ")))
            })?,
        };
        capture.select(&[channel]);
        let mut keeper = Keeper { channel, begin: None, edges: Vec::new(), end: None };
        capture.stream(&mut keeper).map_err(cannot)?;
        let (begin, logic) =
            keeper.begin.ok_or_else(|| wrong("there is nothing in it".to_owned()))?;
        let last = keeper.edges.last().copied().unwrap_or(begin);
        let end = keeper.end.filter(|end| *end >= last).unwrap_or(last);
        for edge in &mut keeper.edges {
            *edge = edge.saturating_sub(begin);
        }
        Ok(Self {
            edges: keeper.edges,
            end: (end - begin).max(1),
            level: Polarity::Normal.level(logic),
            timebase: capture.timebase(),
        })
    }

    /// Ticks in `time`.
    pub(super) fn ticks(&self, time: Micros) -> u64 {
        let ticks = u128::from(time.0) * u128::from(self.timebase.ticks());
        let ticks = ticks / (u128::from(self.timebase.seconds()) * 1_000_000);
        u64::try_from(ticks).unwrap_or(u64::MAX)
    }

    /// How long it takes once, with a pause behind it that ends every frame.
    pub(super) fn length(&self) -> Micros {
        let us = u128::from(self.end) * u128::from(self.timebase.seconds()) * 1_000_000;
        let us = us / u128::from(self.timebase.ticks()).max(1);
        Micros(u64::try_from(us).unwrap_or(u64::MAX)) + Micros::from_ms(2)
    }
}
