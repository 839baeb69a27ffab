//! The solver equals a brute force over all prescalers and segments. The whole grid:
//! `cargo run --release --example timing_grid`.

mod timing_reference;

use canbaud::timing::controllers::{ALL, Controller, Phase};
use canbaud::timing::{Limits, Prescalers, Request, SamplePointPolicy, SolveError, Span, solve};
use canbaud::units::{Bitrate, Hertz, Permille};
use timing_reference::{BITRATES, Best, CLOCKS, POINTS, Segments};

/// xorshift64: the seed makes the sample.
struct Seeded(u64);

impl Seeded {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }
}

fn phases(controller: &Controller) -> impl Iterator<Item = Phase> {
    let all = [Phase::Nominal, Phase::Data, Phase::Xl];
    all.into_iter().filter(|phase| controller.limits(*phase).is_some())
}

/// What the solver says, or the divisor of the nearest rate where none is in reach.
fn solved(request: &Request, limits: &Limits) -> Result<Best, Option<u64>> {
    match solve(request, limits) {
        Ok(solution) => {
            let timing = solution.timing;
            assert_eq!(limits.check(&timing), Ok(()), "{request:?}");
            Ok(Best {
                prescaler: timing.prescaler.into(),
                quanta: timing.quanta(),
                tseg2: timing.tseg2(),
            })
        }
        Err(SolveError::SamplePoint { .. }) => Err(None),
        Err(error) => Err(Some(error.nearest().unwrap().divisor())),
    }
}

fn request(clock: u64, bitrate: u32, point: u32, policy: SamplePointPolicy) -> Request {
    Request::new(Hertz::new(clock).unwrap(), Bitrate::new(bitrate).unwrap())
        .with_sample_point(Permille::new(point as u16).unwrap(), policy)
        .with_tolerance_ppm(u32::MAX)
}

#[test]
fn solve_equals_brute_force_on_a_sample_of_the_grid() {
    let seed = 0x5EED_0001;
    let mut random = Seeded(seed);
    let mut compared = 0;
    for controller in ALL {
        for phase in phases(controller) {
            let limits = controller.limits(phase).unwrap();
            let segments = Segments::new(limits);
            for _ in 0..4 {
                let clock = CLOCKS[random.below(30) as usize];
                let bitrate = BITRATES[random.below(25) as usize];
                let rates = segments.nearest_rates(clock, bitrate);
                for point in POINTS {
                    let request = request(clock, bitrate, point, SamplePointPolicy::Nearest);
                    let best = segments.best(&rates, point, SamplePointPolicy::Nearest).unwrap();
                    let expected = match solved(&request, limits) {
                        Ok(found) => {
                            assert_eq!(
                                found, best,
                                "seed {seed:#x} {} {phase:?} {request:?}",
                                controller.name
                            );
                            compared += 1;
                            continue;
                        }
                        Err(nearest) => nearest,
                    };
                    assert_eq!(expected, Some(segments.divisor(best)), "{request:?}");
                }
            }
        }
    }
    assert!(compared > 500, "only {compared} requests were reachable");
}

#[test]
fn solve_equals_brute_force_under_every_sample_point_policy() {
    let seed = 0x5EED_0002;
    let mut random = Seeded(seed);
    for controller in ALL.iter().filter(|c| c.nominal.prescalers.ends().max <= 1024) {
        let limits = &controller.nominal;
        let segments = Segments::new(limits);
        for _ in 0..6 {
            let clock = CLOCKS[random.below(30) as usize] + random.below(3);
            let bitrate = BITRATES[random.below(25) as usize];
            let point = 500 + random.below(480) as u32;
            let width = 1 + random.below(60) as u16;
            let earliest = Permille::new(point as u16 - width).unwrap();
            let latest = Permille::new((point as u16 + width / 2).min(1000)).unwrap();
            for policy in [
                SamplePointPolicy::NotLater,
                SamplePointPolicy::NotEarlier,
                SamplePointPolicy::Within { earliest, latest },
            ] {
                let request = request(clock, bitrate, point, policy);
                let best = segments.best_in_policy(clock, bitrate, point, policy);
                match (solved(&request, limits), best) {
                    (Ok(found), Some(best)) => {
                        assert_eq!(found, best, "seed {seed:#x} {} {request:?}", controller.name);
                    }
                    (Err(None), None) => {}
                    (Err(Some(divisor)), Some(best)) => {
                        assert_eq!(divisor, segments.divisor(best), "{request:?}");
                    }
                    (found, best) => panic!("{} {request:?}: {found:?} {best:?}", controller.name),
                }
            }
        }
    }
}

/// Limits that no chip has, but that one could have: narrow ranges, rules, and prescaler sets put
/// together from two progressions.
fn random_limits(random: &mut Seeded) -> Limits {
    let mut span = |low: u64, width: u64| {
        let min = 1 + random.below(low) as u16;
        Span::new(min, min + random.below(width) as u16)
    };
    let (tseg1, tseg2) = (span(4, 20), span(3, 10));
    let (prop_seg, phase_seg1) = (span(3, 12), span(3, 12));
    let step = 1 + random.below(3) as u16;
    let low = 1 + random.below(4) as u16;
    let high = low + random.below(60) as u16;
    let mut prescalers = Prescalers::multiples(low, high, step);
    if random.below(2) == 0 {
        // The second begins inside the first, so that no bit rate falls far between them.
        let step = 1 + random.below(8) as u16;
        prescalers = prescalers.and(step.max(low), high * step, step);
    }
    let mut limits =
        Limits::new(tseg1, tseg2, 4, prescalers).with_clock_divider(1 + random.below(3) as u16);
    if random.below(2) == 0 {
        limits = limits.with_segments(prop_seg, phase_seg1);
    }
    if random.below(2) == 0 {
        limits = limits.with_tseg1_excess(random.below(7) as i16 - 2);
    }
    if random.below(3) == 0 {
        limits = limits.with_bit_quanta(Span::new(8, 25));
    }
    limits
}

#[test]
fn solve_equals_brute_force_on_limits_that_no_chip_has() {
    let seed = 0x5EED_0003;
    let mut random = Seeded(seed);
    let mut compared = 0;
    for round in 0..3_000 {
        let limits = random_limits(&mut random);
        let segments = Segments::new(&limits);
        let clock = 1_000_000 + random.below(120_000_000);
        let bitrate = [10_000, 83_333, 125_000, 500_000, 1_000_000][random.below(5) as usize];
        let point = 500 + random.below(480) as u32;
        let (earliest, latest) = (point as u16 - random.below(60) as u16, point as u16);
        let [earliest, latest] = [earliest, latest].map(|p| Permille::new(p).unwrap());
        let policy = [
            SamplePointPolicy::Nearest,
            SamplePointPolicy::NotLater,
            SamplePointPolicy::NotEarlier,
            SamplePointPolicy::Within { earliest, latest },
        ][random.below(4) as usize];
        let request = request(clock, bitrate, point, policy);
        let best = match solve(&request, &limits) {
            Err(SolveError::Limits) => continue,
            _ => segments.best_in_policy(clock, bitrate, point, policy),
        };
        match (solved(&request, &limits), best) {
            (Ok(found), Some(best)) => {
                assert_eq!(found, best, "seed {seed:#x} round {round} {limits:?} {request:?}");
                compared += 1;
            }
            (Err(None), None) => {}
            (Err(Some(divisor)), Some(best)) => {
                assert_eq!(divisor, segments.divisor(best), "round {round} {limits:?} {request:?}");
            }
            (found, best) => panic!("round {round} {limits:?} {request:?}: {found:?} {best:?}"),
        }
    }
    assert!(compared > 1_000, "only {compared} requests were reachable");
}
