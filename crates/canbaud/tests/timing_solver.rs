//! What holds for any request and any limits, and the phases solved together.

use canbaud::timing::controllers::{self, ALL, Controller, Phase};
use canbaud::timing::fd::{PhaseRequests, SamplePoints, solve_phases};
use canbaud::timing::physics::classic_tolerance;
use canbaud::timing::physics_bus::Bus;
use canbaud::timing::physics_fit::solutions_for_bus;
use canbaud::timing::{
    Limits, Prescalers, Ratio, Request, Rules, SamplePointPolicy, SjwPolicy, Solution, SolveError,
    Span, solutions, solve,
};
use canbaud::units::{Bitrate, Hertz, Permille};
use proptest::prelude::*;

fn request(clock: u64, bitrate: u32) -> Request {
    Request::new(Hertz::new(clock).unwrap(), Bitrate::new(bitrate).unwrap())
}

/// Mostly ranges that a chip could have; sometimes crossed, empty or absurd ones.
fn any_span(low: u16, high: u16) -> impl Strategy<Value = Span> {
    prop_oneof![
        8 => (0..=low, low..=high).prop_map(|(min, max)| Span::new(min, max)),
        1 => (any::<u16>(), any::<u16>()).prop_map(|(min, max)| Span::new(min, max)),
    ]
}

/// Mostly small, sometimes anything.
fn small_or_any(high: u16) -> impl Strategy<Value = u16> {
    prop_oneof![8 => 0..=high, 1 => any::<u16>()]
}

prop_compose! {
    fn any_limits()(
        tseg1 in any_span(4, 400), tseg2 in any_span(3, 200),
        prop_seg in any_span(3, 300), phase_seg1 in any_span(3, 300), bit_quanta in any_span(9, 600),
        sjw_max in small_or_any(40), clock_divider in small_or_any(4),
        first in (small_or_any(4), small_or_any(2_048), small_or_any(3)),
        second in proptest::option::of((small_or_any(64), small_or_any(4_096), 0..16_u16)),
        tseg1_excess_min in proptest::option::of(prop_oneof![8 => -30..=30_i16, 1 => any::<i16>()]),
        sjw_gap in small_or_any(2),
        whole in any::<bool>(),
    ) -> Limits {
        let mut prescalers = Prescalers::multiples(first.0, first.1, first.2);
        if let Some((min, max, step)) = second {
            prescalers = prescalers.and(min, max, step);
        }
        let usual = Limits::new(tseg1, tseg2, sjw_max, prescalers);
        if whole {
            let rules = Rules { tseg1_excess_min, sjw_gap };
            Limits { prop_seg, phase_seg1, bit_quanta, clock_divider, rules, ..usual }
        } else {
            usual
        }
    }
}

fn any_policy() -> impl Strategy<Value = SamplePointPolicy> {
    let point = (0..=1000_u16).prop_map(|p| Permille::new(p).unwrap());
    prop_oneof![
        Just(SamplePointPolicy::Nearest),
        Just(SamplePointPolicy::NotLater),
        Just(SamplePointPolicy::NotEarlier),
        (point.clone(), point)
            .prop_map(|(earliest, latest)| SamplePointPolicy::Within { earliest, latest }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Overflow checks are on in this profile: whatever is asked, there is an answer, and it
    /// keeps the limits.
    #[test]
    fn any_request_on_any_limits_is_answered(
        limits in any_limits(),
        clock in prop_oneof![
            8 => 1_000_000..=200_000_000_u64,
            1 => 1..=3_000_000_000_u64,
            1 => 1..=Hertz::MAX.hertz()
        ],
        bitrate in prop_oneof![8 => 5_000..=2_000_000_u32, 1 => 1..=1_000_u32, 1 => 1..=u32::MAX],
        point in 0..=1000_u16,
        policy in any_policy(),
        tolerance in prop_oneof![Just(5_000_u32), any::<u32>()],
        sjw in prop_oneof![
            Just(SjwPolicy::Largest),
            any::<u16>().prop_map(SjwPolicy::AtMost),
            any::<u16>().prop_map(SjwPolicy::Exactly),
        ],
    ) {
        let request = request(clock, bitrate)
            .with_sample_point(Permille::new(point).unwrap(), policy)
            .with_sjw(sjw)
            .with_tolerance_ppm(tolerance);
        match solve(&request, &limits) {
            Ok(solution) => {
                let timing = solution.timing;
                prop_assert!(limits.prescalers.contains(timing.prescaler));
                prop_assert!(limits.tseg1.contains(timing.tseg1()), "{timing:?}");
                prop_assert!(limits.tseg2.contains(timing.tseg2()), "{timing:?}");
                prop_assert!(limits.prop_seg.contains(timing.prop_seg.into()), "{timing:?}");
                prop_assert!(limits.phase_seg1.contains(timing.phase_seg1.into()), "{timing:?}");
                prop_assert!(limits.bit_quanta.contains(timing.quanta()), "{timing:?}");
                prop_assert!(timing.sjw >= 1);
                let ppb = solution.bitrate_error_ppb().unsigned_abs();
                prop_assert!(ppb <= u64::from(tolerance) * 1_000 + 1);
            }
            Err(error) => {
                prop_assert!(!error.to_string().is_empty());
                prop_assert!(error.reason().starts_with("bit timing: "));
            }
        }
        let _ = limits.check(&canbaud::timing::BitTiming {
            prescaler: point, prop_seg: point, phase_seg1: 1, phase_seg2: 1, sjw: point,
        });
    }

    /// The list is sorted, has no setting twice, and starts with the optimum.
    #[test]
    fn solutions_are_ranked(
        index in 0..ALL.len(),
        clock in 4_000_000..=170_000_000_u64,
        bitrate in 10_000..=1_000_000_u32,
        point in 500..=950_u16,
        policy in any_policy(),
    ) {
        let limits = &ALL[index].nominal;
        let request = request(clock, bitrate)
            .with_sample_point(Permille::new(point).unwrap(), policy);
        let Ok(ranked) = solutions::<6>(&request, limits) else { return Ok(()) };
        let list: Vec<&Solution> = ranked.iter().collect();
        prop_assert_eq!(*list[0], solve(&request, limits).unwrap());
        for pair in list.windows(2) {
            prop_assert!(key(pair[0], &request) <= key(pair[1], &request));
            prop_assert_ne!(pair[0].timing, pair[1].timing);
        }
        for solution in list {
            prop_assert_eq!(limits.check(&solution.timing), Ok(()));
        }
    }

    /// A setting chosen for a bus covers its delay and stands its clocks.
    #[test]
    fn settings_for_a_bus_suit_it(
        index in 0..ALL.len(),
        bitrate in prop_oneof![Just(125_000_u32), Just(250_000), Just(500_000), Just(1_000_000)],
        length in 0..600_u32,
        ppm in 1..10_000_u32,
    ) {
        let limits = &ALL[index].nominal;
        let clock = Hertz::new(40_000_000).unwrap();
        let bus = Bus::new(length);
        let request = request(clock.hertz(), bitrate);
        let Ok(ranked) = solutions_for_bus::<3>(&request, limits, &bus, ppm) else { return Ok(()) };
        for solution in ranked.iter() {
            let timing = &solution.timing;
            prop_assert_eq!(limits.check(timing), Ok(()));
            let quantum = u128::from(timing.prescaler) * u128::from(limits.clock_divider);
            // Twice (250 ns + 5 ns/m) within PROP_SEG, in ps times the clock.
            let needed = u128::from(2 * (250_000 + 5_000 * u64::from(length))) * 40_000_000;
            prop_assert!(u128::from(timing.prop_seg) * quantum * 1_000_000_000_000 >= needed);
            prop_assert!(classic_tolerance(timing).limit() >= Ratio::new(ppm.into(), 1_000_000).unwrap());
        }
    }
}

fn key(solution: &Solution, request: &Request) -> (Ratio, Ratio) {
    let divisor = solution.rate.divisor();
    let asked = u64::from(request.bitrate.bits_per_second()) * divisor;
    let rate = Ratio::new(request.clock.hertz().abs_diff(asked), asked).unwrap();
    let timing = &solution.timing;
    let wanted = u64::from(request.sample_point.permille()) * u64::from(timing.quanta());
    let point = (1_000 * u64::from(1 + timing.tseg1())).abs_diff(wanted);
    (rate, Ratio::new(point, timing.quanta().into()).unwrap())
}

fn both(controller: &Controller, clock: u64, nominal: u32, data: u32) -> [Solution; 2] {
    let solved = solve_phases(
        controller,
        &PhaseRequests {
            nominal: request(clock, nominal),
            data: Some(request(clock, data)),
            xl: None,
            sample_points: SamplePoints::Own,
        },
    )
    .unwrap();
    [solved.nominal, solved.data.unwrap()]
}

/// Solved one by one, 92 of 220 such pairs of M_CAN get different prescalers although most have a
/// common one that is exact in both phases.
#[test]
fn a_common_prescaler_is_taken_wherever_one_is_exact_in_both_phases() {
    let clocks = [8, 16, 20, 24, 32, 40, 48, 60, 64, 80, 160].map(|mhz| mhz * 1_000_000_u64);
    let m_can = &controllers::m_can::CONTROLLER;
    let mut common = 0;
    for clock in clocks {
        for nominal in [125_000, 250_000, 500_000, 1_000_000_u32] {
            for data in [1_000_000, 2_000_000, 4_000_000, 5_000_000, 8_000_000_u32] {
                let fits = |rate: u32, prescaler: u64, span: Span| {
                    let unit = u64::from(rate) * prescaler;
                    clock % unit == 0 && span.contains((clock / unit) as u32)
                };
                let exact = (1..=32).any(|p| {
                    fits(nominal, p, Span::new(5, 385)) && fits(data, p, Span::new(4, 49))
                });
                if exact {
                    let [nominal, data] = both(m_can, clock, nominal, data);
                    assert_eq!(nominal.timing.prescaler, data.timing.prescaler);
                    assert_eq!((nominal.bitrate_error_ppb(), data.bitrate_error_ppb()), (0, 0));
                    common += 1;
                }
            }
        }
    }
    assert!(common > 150, "only {common} of 220 pairs have a common prescaler");
}

/// Against every pair of settings of a controller: no pair with one prescaler beats the answer.
#[test]
fn no_pair_of_settings_beats_the_phases_solved_together() {
    let controller = &controllers::xcanfd1::CONTROLLER;
    let (nominal_limits, data_limits) = (&controller.nominal, controller.data.as_ref().unwrap());
    for (clock, nominal, data) in [
        (40_000_000, 500_000, 2_000_000),
        (80_000_000, 125_000, 5_000_000),
        (24_000_000, 1_000_000, 8_000_000),
    ] {
        let answer = both(controller, clock, nominal, data);
        let requests = [request(clock, nominal), request(clock, data)];
        let sorted = |pair: [(Ratio, Ratio); 2]| {
            let [a, b] = pair;
            (a.0.max(b.0), a.0.min(b.0), a.1.max(b.1), a.1.min(b.1))
        };
        let ours = sorted([key(&answer[0], &requests[0]), key(&answer[1], &requests[1])]);
        for prescaler in 1..=256_u16 {
            let only = Prescalers::range(prescaler, prescaler);
            let one = |request: &Request, limits: &Limits| {
                let request = request.with_tolerance_ppm(u32::MAX);
                solve(&request, &limits.with_prescalers(only)).ok()
            };
            let pair = (one(&requests[0], nominal_limits), one(&requests[1], data_limits));
            if let (Some(n), Some(d)) = pair {
                let theirs = sorted([key(&n, &requests[0]), key(&d, &requests[1])]);
                assert!(ours <= theirs, "{clock} {nominal} {data} prescaler {prescaler}");
            }
        }
    }
}

#[test]
fn equal_sample_points_are_equal_where_the_quanta_allow() {
    let clock = Hertz::new(80_000_000).unwrap();
    let requests = PhaseRequests {
        nominal: Request::new(clock, Bitrate::new(500_000).unwrap()),
        data: Some(Request::new(clock, Bitrate::new(2_000_000).unwrap())),
        xl: None,
        sample_points: SamplePoints::Equal,
    };
    let solved = solve_phases(&controllers::m_can::CONTROLLER, &requests).unwrap();
    let data = solved.data.unwrap();
    assert_eq!(solved.nominal.timing.sample_point(), data.timing.sample_point());
    assert_eq!((solved.nominal.bitrate_error_ppb(), data.bitrate_error_ppb()), (0, 0));
}

#[test]
fn one_prescaler_for_three_phases_of_x_can() {
    let requests = PhaseRequests {
        nominal: request(160_000_000, 500_000),
        data: Some(request(160_000_000, 2_000_000)),
        xl: Some(request(160_000_000, 10_000_000)),
        sample_points: SamplePoints::Own,
    };
    let solved = solve_phases(&controllers::x_can_prt::CONTROLLER, &requests).unwrap();
    assert!(solved.has_common_prescaler());
    assert_eq!(controllers::x_can_prt::CONTROLLER.check(&solved.configuration()), Ok(()));
    let slow = PhaseRequests { nominal: request(160_000_000, 5_000), ..requests };
    let error = solve_phases(&controllers::x_can_prt::CONTROLLER, &slow).unwrap_err();
    assert!(error.to_string().contains("one prescaler for all phases"), "{error}");
}

/// The traps of other calculators, each with the right answer.
#[test]
fn known_defects_of_others_do_not_occur() {
    // Sample point ranked before the bit rate: 125 MHz, 1 Mbit/s, CTU data phase.
    let data = controllers::ctu_can_fd::CONTROLLER.data.unwrap();
    let solution = solve(&request(125_000_000, 1_000_000), &data).unwrap();
    assert_eq!(solution.bitrate_error_ppb(), 0);
    assert_eq!(solution.timing.quanta(), 125);
    // The whole-bit/s truncation took +100 ppm: 66.666666 MHz, 10 kbit/s with 59 x 113 is -50.007.
    let solution = solve(&request(66_666_666, 10_000), &controllers::m_can::NOMINAL).unwrap();
    assert_eq!(solution.bitrate_error_ppb(), -50_007);
    // Integer division before multiplication: 36 MHz, 500 kbit/s gave 91.7 %.
    let solution = solve(&request(36_000_000, 500_000), &controllers::bxcan::NOMINAL).unwrap();
    assert_eq!(solution.timing.sample_point().permille(), 875);
    // Panic at few quanta: 4 MHz, 1 Mbit/s.
    let solution = solve(&request(4_000_000, 1_000_000), &controllers::m_can::DATA).unwrap();
    assert_eq!(solution.timing.quanta(), 4);
    // PS1 > PS2 of the GRCAN at a sample point of 50 %.
    let half = request(8_000_000, 500_000)
        .with_sample_point(Permille::new(500).unwrap(), SamplePointPolicy::Nearest);
    let timing = solve(&half, &controllers::grcan::NOMINAL).unwrap().timing;
    assert!(timing.phase_seg1 > timing.phase_seg2 && timing.phase_seg2 >= timing.sjw);
}

#[test]
fn errors_name_the_limit() {
    let solve_on = |clock, bitrate| solve(&request(clock, bitrate), &controllers::sja1000::NOMINAL);
    assert!(matches!(
        solve_on(8_000_000, 4_000_000),
        Err(SolveError::TooFast { divisor_min: 6, .. })
    ));
    assert!(matches!(
        solve_on(160_000_000, 5_000),
        Err(SolveError::TooSlow { divisor_max: 3_200, .. })
    ));
    let close = request(42_000_000, 999_000).with_tolerance_ppm(1_000);
    let error = solve(&close, &controllers::sja1000::NOMINAL).unwrap_err();
    assert!(matches!(error, SolveError::NotClose { tolerance_ppm: 1_000, .. }));
    assert_eq!(error.nearest().unwrap().to_string(), "1M");
    assert!(matches!(solve_on(3_000_000_000, 500_000), Err(SolveError::Clock { .. })));
    let late = request(16_000_000, 500_000)
        .with_sample_point(Permille::new(990).unwrap(), SamplePointPolicy::NotEarlier);
    assert!(matches!(
        solve(&late, &controllers::sja1000::NOMINAL),
        Err(SolveError::SamplePoint { .. })
    ));
}

#[test]
fn every_phase_of_every_controller_has_limits_that_agree() {
    for controller in ALL {
        for phase in [Phase::Nominal, Phase::Data, Phase::Xl] {
            if let Some(limits) = controller.limits(phase) {
                let quanta = limits.quanta();
                assert!(quanta.min <= quanta.max, "{} {phase}", controller.name);
            }
        }
    }
}
