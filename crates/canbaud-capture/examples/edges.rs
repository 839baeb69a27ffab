//! Counts the edges of a capture: `cargo run --release -p canbaud-capture --example edges FILE`.

use core::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use canbaud::wire::Logic;
use canbaud_capture::{CaptureError, EdgeSink, OpenOptions, open};

struct Ignore;

impl EdgeSink for Ignore {
    fn begin(&mut self, _: usize, _: u64, _: Logic) {}
    fn edges(&mut self, _: usize, _: &[u64]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    fn end(&mut self, _: usize, _: u64) {}
}

fn main() {
    for path in std::env::args_os().skip(1) {
        if let Err(error) = count(path.as_ref()) {
            eprintln!("{}: {error}", path.display());
        }
    }
}

fn count(path: &Path) -> Result<(), CaptureError> {
    let start = Instant::now();
    let mut capture = open(path, &OpenOptions::default())?;
    let summary = capture.stream(&mut Ignore)?;
    println!("{}: {}, {:?}", path.display(), capture.format(), start.elapsed());
    for (channel, summary) in capture.channels().iter().zip(&summary.channels) {
        println!("  {:20} {:>10} edges  {:?}", channel.name, summary.edges, summary.signal);
    }
    for note in summary.notes {
        println!("  note: {note}");
    }
    Ok(())
}
