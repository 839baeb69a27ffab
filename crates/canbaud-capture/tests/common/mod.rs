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
    pub(crate) begin: u64,
    pub(crate) level: Logic,
    pub(crate) edges: Vec<u64>,
    pub(crate) end: Option<u64>,
}

/// Everything that was streamed, by channel.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    pub(crate) channels: Vec<Vec<Stretch>>,
    pub(crate) largest_block: usize,
    pub(crate) stop_after: Option<usize>,
    pub(crate) calls: usize,
}

impl Kept {
    fn open(&mut self, channel: usize) -> &mut Stretch {
        let stretch = self.channels.get_mut(channel).and_then(|c| c.last_mut());
        stretch.filter(|s| s.end.is_none()).expect("edges or end without begin")
    }

    /// All edges of a channel.
    pub(crate) fn edges(&self, channel: usize) -> Vec<u64> {
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

/// xorshift64*: repeatable noise.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// Roughly normal: mean 0, standard deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        let sum: f64 = (0..12).map(|_| self.next() as f64 / u64::MAX as f64).sum();
        sum - 6.0
    }
}

/// A zip archive of these members, deflated.
pub(crate) fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
    archive_with(members, zip::CompressionMethod::Deflated)
}

pub(crate) fn archive_with(members: &[(&str, &[u8])], method: zip::CompressionMethod) -> Vec<u8> {
    use std::io::Write;
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, content) in members {
        writer.start_file(*name, options).unwrap();
        writer.write_all(content).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// Edges of one line of packed samples, found one sample at a time.
pub(crate) fn naive(samples: &[u64], bit: u32) -> Vec<u64> {
    let line: Vec<u64> = samples.iter().map(|s| s >> bit & 1).collect();
    (1..line.len()).filter(|&n| line[n] != line[n - 1]).map(|n| n as u64).collect()
}

/// Samples that change now and then on some of the lines.
pub(crate) fn samples(random: &mut Random, count: usize, bits: u32) -> Vec<u64> {
    let mut word = random.next();
    let mut left = 0;
    (0..count)
        .map(|_| {
            if left == 0 {
                left = if random.below(4) == 0 { random.below(600) } else { random.below(12) };
                word ^= random.next() & random.next() & random.next();
            }
            left = left.saturating_sub(1);
            if bits == 64 { word } else { word & ((1 << bits) - 1) }
        })
        .collect()
}

/// Little-endian words of `bytes` bytes.
pub(crate) fn pack(samples: &[u64], bytes: usize) -> Vec<u8> {
    samples.iter().flat_map(|s| s.to_le_bytes()[..bytes].to_vec()).collect()
}
