//! Compares the solver with a brute force over the whole grid: every controller, both or all
//! three phases, 30 clocks x 25 bit rates x 4 sample points.
//!
//! `cargo run --release --example timing_grid [controller ...]`; without names, every controller.

#[path = "../tests/timing_reference/mod.rs"]
#[expect(dead_code, reason = "shared with the tests, which need more of it")]
mod timing_reference;

use std::process::ExitCode;

use canbaud::timing::controllers::{self, ALL, Controller, Phase};
use canbaud::timing::{Limits, Request, SamplePointPolicy, solve};
use canbaud::units::{Bitrate, Hertz, Permille};
use timing_reference::{BITRATES, Best, CLOCKS, POINTS, Segments};

/// How many requests were compared, and how many answers were different.
#[derive(Default)]
struct Count {
    compared: u32,
    reachable: u32,
    different: u32,
}

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let chosen: Vec<&Controller> = if names.is_empty() {
        ALL.to_vec()
    } else {
        names.iter().map(|name| controllers::find(name).expect("unknown controller")).collect()
    };
    let mut total = Count::default();
    for controller in chosen {
        for phase in [Phase::Nominal, Phase::Data, Phase::Xl] {
            let Some(limits) = controller.limits(phase) else { continue };
            let count = compare(controller.name, limits);
            println!(
                "{:22} {:8} {} requests, {} reachable within a factor of two, {} different",
                controller.name,
                phase.to_string(),
                count.compared,
                count.reachable,
                count.different
            );
            total.compared += count.compared;
            total.reachable += count.reachable;
            total.different += count.different;
        }
    }
    println!(
        "total: {} requests, {} reachable, {} different",
        total.compared, total.reachable, total.different
    );
    if total.different == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn compare(name: &str, limits: &Limits) -> Count {
    let segments = Segments::new(limits);
    let mut count = Count::default();
    for clock in CLOCKS {
        for bitrate in BITRATES {
            let rates = segments.nearest_rates(clock, bitrate);
            for point in POINTS {
                let best = segments.best(&rates, point, SamplePointPolicy::Nearest).unwrap();
                let request =
                    Request::new(Hertz::new(clock).unwrap(), Bitrate::new(bitrate).unwrap())
                        .with_sample_point(
                            Permille::new(point as u16).unwrap(),
                            SamplePointPolicy::Nearest,
                        )
                        .with_tolerance_ppm(u32::MAX);
                let same = match solve(&request, limits) {
                    Ok(solution) => {
                        count.reachable += 1;
                        let timing = solution.timing;
                        limits.check(&timing) == Ok(())
                            && best
                                == Best {
                                    prescaler: timing.prescaler.into(),
                                    quanta: timing.quanta(),
                                    tseg2: timing.tseg2(),
                                }
                    }
                    Err(error) => {
                        error.nearest().map(|rate| rate.divisor()) == Some(segments.divisor(best))
                    }
                };
                count.compared += 1;
                if !same {
                    count.different += 1;
                    println!(
                        "{name}: {request:?} is {:?}, should be {best:?}",
                        solve(&request, limits)
                    );
                }
            }
        }
    }
    count
}
