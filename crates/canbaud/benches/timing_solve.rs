//! Time of one bit timing solve over the grid of `examples/timing_grid.rs`, beside
//! `can-calc-bit-timing` (package can-utils) where it is installed.
//!
//! `cargo bench -p canbaud --bench timing_solve`

#[path = "../tests/timing_reference/mod.rs"]
#[expect(dead_code, reason = "shared with the tests, which need more of it")]
mod timing_reference;

use std::hint::black_box;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use canbaud::timing::controllers::{self, ALL, Phase};
use canbaud::timing::{Limits, Request, SamplePointPolicy, solve};
use canbaud::units::{Bitrate, Hertz, Permille};
use criterion::{Criterion, criterion_group, criterion_main};
use timing_reference::{BITRATES, CLOCKS, POINTS};

/// The controllers of can-utils 2020.11 by its names and ours, with our fixed clock divider:
/// it takes the clock after the divider.
const PEER_CONTROLLERS: [(&str, &str, u64); 7] = [
    ("sja1000", "sja1000", 2),
    ("mscan", "mscan", 1),
    ("at91", "at91", 1),
    ("flexcan", "flexcan_ctrl1", 1),
    ("mcp251x", "mcp2515", 2),
    ("ti_hecc", "ti_hecc", 1),
    ("rcar_can", "rcan", 1),
];

/// The bit rates that it solves when none is given.
const PEER_BITRATES: [u32; 7] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 100_000, 50_000];

fn grid() -> Vec<(Request, &'static Limits)> {
    let mut grid = Vec::new();
    for controller in ALL {
        for phase in [Phase::Nominal, Phase::Data, Phase::Xl] {
            let Some(limits) = controller.limits(phase) else { continue };
            for clock in CLOCKS {
                for bitrate in BITRATES {
                    for point in POINTS {
                        let request = request(clock, bitrate).with_sample_point(
                            Permille::new(point as u16).unwrap(),
                            SamplePointPolicy::Nearest,
                        );
                        grid.push((request, limits));
                    }
                }
            }
        }
    }
    grid
}

fn request(clock: u64, bitrate: u32) -> Request {
    Request::new(Hertz::new(clock).unwrap(), Bitrate::new(bitrate).unwrap())
}

/// Mean time of one solve, best of three passes.
fn mean_nanoseconds(grid: &[(Request, &Limits)]) -> f64 {
    let pass = || {
        let start = Instant::now();
        for (request, limits) in grid {
            let _ = black_box(solve(black_box(request), limits));
        }
        start.elapsed()
    };
    let best = (0..3).map(|_| pass()).min().unwrap_or(Duration::ZERO);
    best.as_nanos() as f64 / grid.len() as f64
}

fn peer(arguments: &[String]) -> Option<Duration> {
    let start = Instant::now();
    let status = Command::new("can-calc-bit-timing")
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .ok()?;
    status.success().then(|| start.elapsed())
}

/// One peer process solves 7 controllers x 7 rates, another one a single case; the difference
/// leaves 48 solves with the printing of their lines.
fn beside_peer() {
    let mut own = Vec::new();
    let mut spent = Duration::ZERO;
    let mut spent_on_one = Duration::ZERO;
    const ROUNDS: u32 = 20;
    for clock in CLOCKS {
        let hertz = clock.to_string();
        let all = ["-q", "-c", &hertz].map(str::to_string);
        let one = ["-q", "-c", &hertz, "-b", "500000", "sja1000"].map(str::to_string);
        for _ in 0..ROUNDS {
            let (Some(all), Some(one)) = (peer(&all), peer(&one)) else {
                eprintln!("can-calc-bit-timing (package can-utils) is not installed: not compared");
                return;
            };
            spent += all;
            spent_on_one += one;
        }
        for (_, name, divider) in PEER_CONTROLLERS {
            let limits = &controllers::find(name).unwrap().nominal;
            own.extend(PEER_BITRATES.map(|bitrate| (request(clock * divider, bitrate), limits)));
        }
    }
    let solves = f64::from(48 * ROUNDS) * CLOCKS.len() as f64;
    let peer = spent.saturating_sub(spent_on_one).as_nanos() as f64 / solves;
    println!(
        "its 7 controllers x 30 clocks x its 7 rates: canbaud {:.0} ns, can-calc-bit-timing {peer:.0} ns a solve \
         (its process start subtracted, its printing included)",
        mean_nanoseconds(&own)
    );
}

fn bench(criterion: &mut Criterion) {
    let grid = grid();
    println!("plain loop, {} requests: {:.0} ns a solve", grid.len(), mean_nanoseconds(&grid));
    beside_peer();
    let mut next = grid.iter().cycle();
    criterion.bench_function("solve, mean over the grid", |bencher| {
        bencher.iter(|| {
            let (request, limits) = next.next().unwrap();
            solve(black_box(request), limits)
        });
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
