//! What the capture targets share: a sink that checks the contract of `EdgeSink`.

use core::ops::ControlFlow;
use std::collections::HashMap;
use std::io::{Cursor, Write};

use canbaud::units::Hertz;
use canbaud::wire::Logic;
use canbaud_capture::{EdgeSink, Format, OpenOptions, from_reader};

/// The last tick of every channel that is being recorded.
#[derive(Default)]
struct Check(HashMap<usize, u64>);

impl EdgeSink for Check {
    fn begin(&mut self, channel: usize, at: u64, _: Logic) {
        assert!(self.0.insert(channel, at).is_none(), "begin twice");
    }

    fn edges(&mut self, channel: usize, times: &[u64]) -> ControlFlow<()> {
        let last = self.0.get_mut(&channel).expect("edges without begin");
        for &time in times {
            assert!(time > *last, "edges must rise");
            *last = time;
        }
        ControlFlow::Continue(())
    }

    fn end(&mut self, channel: usize, at: u64) {
        let last = self.0.remove(&channel).expect("end without begin");
        assert!(at >= last, "end before the last edge");
    }
}

/// Reads `data` as `format`, or as what it looks like.
pub fn stream(data: Vec<u8>, format: Option<Format>) {
    let needs_rate = matches!(format, Some(Format::Logic1Samples(_) | Format::Logic1Changes(_)));
    let options = OpenOptions {
        format,
        samplerate: if needs_rate { Hertz::new(24_000_000) } else { None },
        max_inflated: 1 << 22,
        ..OpenOptions::default()
    };
    let Ok(mut capture) = from_reader(Cursor::new(data), &options) else { return };
    let mut check = Check::default();
    let result = capture.stream(&mut check);
    assert!(check.0.is_empty(), "a recording did not end");
    if let Err(error) = result {
        assert!(!error.to_string().contains('\n'));
    }
}

/// A sound archive of members that may hold anything.
pub fn archive(members: &[(&str, &[u8])]) -> Option<Vec<u8>> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Stored);
    for (name, content) in members {
        writer.start_file(*name, options).ok()?;
        writer.write_all(content).ok()?;
    }
    Some(writer.finish().ok()?.into_inner())
}
