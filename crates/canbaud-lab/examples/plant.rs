//! Networks of 20 devices, all automatic but one, from power-on to all operational.
//!
//! `cargo run --release -p canbaud-lab --example plant -- [SEEDS] [both|controllers|timers|any] [FIRST]`
#![allow(missing_docs, reason = "an example")]

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use canbaud_lab::{Mix, Outcome, Plant};
use canbaud_sim::Span;

fn main() {
    let mut args = std::env::args().skip(1);
    let seeds: u64 = args.next().and_then(|text| text.parse().ok()).unwrap_or(1_000);
    let mix = match args.next().as_deref() {
        Some("both") => Mix::Both,
        Some("controllers") => Mix::Controllers,
        Some("timers") => Mix::Timers,
        _ => Mix::Any,
    };
    let first: u64 = args.next().and_then(|text| text.parse().ok()).unwrap_or(0);
    let begin = Instant::now();
    let next = AtomicU64::new(first);
    let results: Mutex<Vec<(u64, Outcome)>> = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= first + seeds {
                        return;
                    }
                    let plant = Plant { nodes: 20, bitrate: 250_000, mix, seed };
                    let outcome = plant.run(Span::from_s(120));
                    results.lock().expect("no thread panics").push((seed, outcome));
                }
            });
        }
    });
    let results = results.into_inner().expect("no thread panics");
    let mut times: Vec<f64> =
        results.iter().filter_map(|(_, o)| Some(o.all_operational?.seconds())).collect();
    times.sort_by(f64::total_cmp);
    for (seed, outcome) in &results {
        let bad = outcome.broken_silence + outcome.wrong_joins > 0;
        if outcome.all_operational.is_none() || bad {
            println!("seed {seed}: {outcome:?}");
        }
    }
    let at = |part: f64| times.get(((times.len() - 1) as f64 * part) as usize).copied();
    println!(
        "{mix:?}: {} of {} networks operational; median {:.3} s, 99 % {:.3} s, last {:.3} s; {:.1} s wall",
        times.len(),
        results.len(),
        at(0.5).unwrap_or(0.0),
        at(0.99).unwrap_or(0.0),
        at(1.0).unwrap_or(0.0),
        begin.elapsed().as_secs_f64(),
    );
}
