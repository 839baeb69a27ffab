//! A sink that keeps everything and checks the contract of [`EdgeSink`] on the way.
#![allow(dead_code, reason = "each test file uses a part")]

use core::ops::ControlFlow;
use std::io::Cursor;
use std::path::PathBuf;

use canbaud::wire::Logic;
use canbaud_capture::{Capture, CaptureError, EdgeSink, OpenOptions, Summary, from_reader};

/// One unbroken recording of one channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Stretch {
    pub begin: u64,
    pub level: Logic,
    pub edges: Vec<u64>,
    pub end: Option<u64>,
}

/// Everything that was streamed, by channel.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    pub channels: Vec<Vec<Stretch>>,
    pub largest_block: usize,
    pub stop_after: Option<usize>,
    pub calls: usize,
}

impl Kept {
    fn open(&mut self, channel: usize) -> &mut Stretch {
        let stretch = self.channels.get_mut(channel).and_then(|c| c.last_mut());
        stretch.filter(|s| s.end.is_none()).expect("edges or end without begin")
    }

    /// All edges of a channel.
    pub fn edges(&self, channel: usize) -> Vec<u64> {
        self.channels.get(channel).into_iter().flatten().flat_map(|s| s.edges.clone()).collect()
    }
}

impl EdgeSink for Kept {
    fn begin(&mut self, channel: usize, at: u64, level: Logic) {
        if self.channels.len() <= channel {
            self.channels.resize(channel + 1, Vec::new());
        }
        let stretches = &mut self.channels[channel];
        if let Some(before) = stretches.last() {
            assert!(before.end.expect("begin twice") <= at, "begin before the last end");
        }
        stretches.push(Stretch { begin: at, level, edges: Vec::new(), end: None });
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        assert!(!times.is_empty());
        self.calls += 1;
        self.largest_block = self.largest_block.max(times.len());
        let stretch = self.open(channel);
        for &time in times {
            let last = stretch.edges.last().copied().unwrap_or(stretch.begin);
            assert!(time > last, "edge at {time} after {last}");
            stretch.edges.push(time);
        }
        match self.stop_after {
            Some(calls) if self.calls >= calls => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }

    fn end(&mut self, channel: usize, at: u64) {
        let stretch = self.open(channel);
        let last = stretch.edges.last().copied().unwrap_or(stretch.begin);
        assert!(at >= last, "end at {at} before {last}");
        stretch.end = Some(at);
    }

    fn progress(&mut self, done: u64, total: u64) {
        assert!(done <= total);
    }
}

/// Opens and streams bytes.
pub(crate) fn read(bytes: &[u8]) -> Result<(Capture, Kept, Summary), CaptureError> {
    read_with(bytes, &OpenOptions::default())
}

pub(crate) fn read_with(
    bytes: &[u8],
    options: &OpenOptions,
) -> Result<(Capture, Kept, Summary), CaptureError> {
    let mut capture = from_reader(Cursor::new(bytes.to_vec()), options)?;
    let mut kept = Kept::default();
    let summary = capture.stream(&mut kept)?;
    Ok((capture, kept, summary))
}

/// Opens bytes and streams them as far as they go.
pub(crate) fn read_damaged(bytes: &[u8]) -> (Kept, CaptureError) {
    let mut capture = from_reader(Cursor::new(bytes.to_vec()), &OpenOptions::default())
        .expect("the head is good");
    let mut kept = Kept::default();
    let error = capture.stream(&mut kept).expect_err("the file is damaged");
    (kept, error)
}

/// The shared recordings, or `None` with a word on stderr.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/captures")).join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("absent, not tested: ../shared/captures/{name}");
    None
}
