//! A day in a plant, with everything that can happen.
//!
//! `cargo run --release -p canbaud-lab --example day -- [MINUTES] [NODES] [SEED]`
#![allow(missing_docs, reason = "an example")]

use canbaud_lab::{Memory, Report, Shift};
use canbaud_sim::Span;

/// A simulation is five hours long at most.
const SHIFT_MINUTES: u64 = 240;

fn main() {
    let number = |place| std::env::args().nth(place).and_then(|text| text.parse::<u64>().ok());
    let minutes = number(1).unwrap_or(24 * 60);
    let nodes = number(2).and_then(|n| u8::try_from(n).ok()).unwrap_or(10);
    let seed = number(3).unwrap_or(1);
    let begin = std::time::Instant::now();
    let mut memories: Vec<Memory> = Vec::new();
    let mut total = Report::default();
    for shift in 0..minutes.div_ceil(SHIFT_MINUTES) {
        let left = (minutes - shift * SHIFT_MINUTES).min(SHIFT_MINUTES);
        let span = Span::from_s(60 * left);
        let shift = Shift { nodes, seed: seed + shift, span, pause: Span::from_s(10) };
        let report = shift.run(&mut memories);
        println!("{shift:?}\n  {report:?}");
        total = total.and(report);
    }
    println!("total: {total:#?}\n{:.1} s wall", begin.elapsed().as_secs_f64());
}
