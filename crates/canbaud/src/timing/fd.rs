//! Phases solved together: CAN FD and CAN XL.

use super::controllers::{Configuration, Controller, Phase, PrescalerSharing, RegisterError};
use super::tdc::Tdc;
use super::{Limits, Prescalers, Ratio, Request, SamplePointPolicy, Solution, SolveError, solve};
use crate::units::Permille;

/// Whether the phases should have the same sample point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplePoints {
    /// Each as near as possible to its own request.
    Own,
    /// As equal as possible first.
    Equal,
}

/// What is asked for in each phase. The clocks must be the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhaseRequests {
    /// Arbitration phase.
    pub nominal: Request,
    /// CAN FD data phase.
    pub data: Option<Request>,
    /// CAN XL data phase.
    pub xl: Option<Request>,
    /// Whether the sample points should be equal.
    pub sample_points: SamplePoints,
}

/// The settings of all phases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhaseSolutions {
    /// Arbitration phase.
    pub nominal: Solution,
    /// CAN FD data phase.
    pub data: Option<Solution>,
    /// CAN XL data phase.
    pub xl: Option<Solution>,
    /// Transmitter delay compensation of the FD data phase.
    pub data_tdc: Tdc,
    /// Transmitter delay compensation of the XL data phase.
    pub xl_tdc: Tdc,
}

impl PhaseSolutions {
    /// Whether all phases have the same prescaler.
    #[must_use]
    pub fn has_common_prescaler(&self) -> bool {
        let nominal = self.nominal.timing.prescaler;
        [self.data, self.xl].iter().flatten().all(|s| s.timing.prescaler == nominal)
    }

    /// What to program.
    #[must_use]
    pub fn configuration(&self) -> Configuration {
        Configuration {
            nominal: self.nominal.timing,
            data: self.data.map(|s| s.timing),
            xl: self.xl.map(|s| s.timing),
            data_tdc_offset: self.data_tdc.offset(),
            xl_tdc_offset: self.xl_tdc.offset(),
            pwm: None,
        }
    }
}

/// Why the phases cannot be solved together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PhasesError {
    /// The controller has no such phase.
    NoPhase(Phase),
    /// One phase is impossible by itself.
    Phase(Phase, SolveError),
    /// The clocks of two requests differ.
    Clocks,
    /// The data phase is slower than the nominal one.
    DataSlower(Phase),
    /// No prescaler serves all phases of a controller that has only one.
    NoCommonPrescaler,
}

impl core::fmt::Display for PhasesError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoPhase(phase) => write!(f, "{}", RegisterError::NoPhase(*phase)),
            Self::Phase(phase, error) => write!(f, "{phase} phase: {error}"),
            Self::Clocks => f.write_str("the phases must have the same clock"),
            Self::DataSlower(phase) => {
                write!(f, "the {phase} phase must not be slower than the nominal phase")
            }
            Self::NoCommonPrescaler => f.write_str(
                "the controller has one prescaler for all phases, and none gives every bit rate \
                 within its tolerance",
            ),
        }
    }
}

impl core::error::Error for PhasesError {}

/// One phase of the joint problem.
#[derive(Clone, Copy)]
struct PhaseProblem {
    phase: Phase,
    request: Request,
    limits: Limits,
}

/// Solves all phases for one controller.
///
/// Bit rate errors come first (the larger one, then the other); among equals a common prescaler,
/// then equal sample points where asked for, then the sample points of the requests (again the
/// larger error first), then the smaller prescaler.
///
/// ```
/// use canbaud::timing::{controllers::m_can, fd::*, Request};
/// use canbaud::units::{Bitrate, Hertz};
/// let clock = Hertz::new(40_000_000).unwrap();
/// let solved = solve_phases(&m_can::CONTROLLER, &PhaseRequests {
///     nominal: Request::new(clock, Bitrate::new(125_000).unwrap()),
///     data: Some(Request::new(clock, Bitrate::new(1_000_000).unwrap())),
///     xl: None,
///     sample_points: SamplePoints::Own,
/// }).unwrap();
/// // Solved one by one the prescalers are 1 and 1 or 2 and 1; together they are equal.
/// assert!(solved.has_common_prescaler());
/// ```
///
/// # Errors
/// [`PhasesError`] names the phase and what stands in the way.
pub fn solve_phases(
    controller: &Controller,
    requests: &PhaseRequests,
) -> Result<PhaseSolutions, PhasesError> {
    let problems = problems(controller, requests)?;
    let common = common(&problems, requests.sample_points);
    let chosen = match controller.prescalers {
        PrescalerSharing::Shared => common.ok_or(PhasesError::NoCommonPrescaler)?,
        PrescalerSharing::OnePerPhase => {
            let alone = alone(&problems)?;
            match common {
                Some(common) if rate_errors(&common) == rate_errors(&alone) => common,
                _ => alone,
            }
        }
    };
    let [nominal, data, xl] = chosen;
    let nominal = nominal.ok_or(PhasesError::NoPhase(Phase::Nominal))?;
    let tdc = |solution: Option<Solution>| match solution {
        Some(solution) => Tdc::of(&solution.timing, controller.tdc_offset_max),
        None => Tdc::None,
    };
    Ok(PhaseSolutions { nominal, data, xl, data_tdc: tdc(data), xl_tdc: tdc(xl) })
}

fn problems(
    controller: &Controller,
    requests: &PhaseRequests,
) -> Result<[Option<PhaseProblem>; 3], PhasesError> {
    let mut problems = [None; 3];
    let asked = [
        (Phase::Nominal, Some(requests.nominal)),
        (Phase::Data, requests.data),
        (Phase::Xl, requests.xl),
    ];
    for (slot, (phase, request)) in problems.iter_mut().zip(asked) {
        let Some(request) = request else { continue };
        let limits = *controller.limits(phase).ok_or(PhasesError::NoPhase(phase))?;
        if request.clock != requests.nominal.clock {
            return Err(PhasesError::Clocks);
        }
        if request.bitrate < requests.nominal.bitrate {
            return Err(PhasesError::DataSlower(phase));
        }
        *slot = Some(PhaseProblem { phase, request, limits });
    }
    Ok(problems)
}

type Trio = [Option<Solution>; 3];

fn alone(problems: &[Option<PhaseProblem>; 3]) -> Result<Trio, PhasesError> {
    let mut trio = [None; 3];
    for (slot, problem) in trio.iter_mut().zip(problems) {
        if let Some(problem) = problem {
            let solved = solve(&problem.request, &problem.limits);
            *slot = Some(solved.map_err(|error| PhasesError::Phase(problem.phase, error))?);
        }
    }
    Ok(trio)
}

/// The best setting with one prescaler for all phases.
fn common(problems: &[Option<PhaseProblem>; 3], points: SamplePoints) -> Option<Trio> {
    let mut best: Option<(Key, Trio)> = None;
    for prescaler in candidates(problems) {
        let Some(trio) = with_prescaler(problems, prescaler, points) else { continue };
        let key = Key::of(problems, &trio, points);
        if best.as_ref().is_none_or(|(best, _)| key < *best) {
            best = Some((key, trio));
        }
    }
    best.map(|(_, trio)| trio)
}

/// Prescalers that every phase offers, up to the highest that the fastest phase can use.
fn candidates(problems: &[Option<PhaseProblem>; 3]) -> impl Iterator<Item = u16> {
    let most = problems.iter().flatten().map(|problem| {
        let quanta = u64::from(problem.limits.quanta().min.max(1));
        let rate = u64::from(problem.request.bitrate.bits_per_second());
        let divider = u64::from(problem.limits.clock_divider.max(1));
        let clocks = problem.request.clock.hertz();
        clocks.checked_div(rate * divider * quanta).unwrap_or(0) + 1
    });
    let most = most.min().unwrap_or(0).min(u64::from(u16::MAX)) as u16;
    let offered = |prescaler: &u16| {
        problems.iter().flatten().all(|p| p.limits.prescalers.contains(*prescaler))
    };
    (1..=most).filter(offered)
}

fn with_prescaler(
    problems: &[Option<PhaseProblem>; 3],
    prescaler: u16,
    points: SamplePoints,
) -> Option<Trio> {
    let mut trio = [None; 3];
    for (slot, problem) in trio.iter_mut().zip(problems) {
        if let Some(problem) = problem {
            *slot = Some(fixed(problem, prescaler, problem.request).ok()?);
        }
    }
    match points {
        SamplePoints::Own => Some(trio),
        SamplePoints::Equal => Some(equalised(problems, prescaler, trio)),
    }
}

fn fixed(problem: &PhaseProblem, prescaler: u16, request: Request) -> Result<Solution, SolveError> {
    let only = Prescalers::multiples(prescaler, prescaler, prescaler);
    solve(&request, &problem.limits.with_prescalers(only))
}

/// Tries every sample point of the phase with the fewest quanta on all phases, and keeps what is
/// most equal; the bit rate errors stay what they are.
fn equalised(problems: &[Option<PhaseProblem>; 3], prescaler: u16, trio: Trio) -> Trio {
    let coarsest = trio.iter().flatten().map(|s| s.timing.quanta()).min().unwrap_or(0);
    let mut best = (Key::of(problems, &trio, SamplePoints::Equal), trio);
    for tseg2 in 1..coarsest {
        let Some(point) = nearest_permille(coarsest - tseg2, coarsest) else { continue };
        let mut next = trio;
        for (slot, problem) in next.iter_mut().zip(problems) {
            let (Some(solution), Some(problem)) = (&slot, problem) else { continue };
            let request = problem.request.with_sample_point(point, SamplePointPolicy::Nearest);
            match fixed(problem, prescaler, request) {
                Ok(moved) if moved.rate == solution.rate => *slot = Some(moved),
                _ => {}
            }
        }
        let key = Key::of(problems, &next, SamplePoints::Equal);
        if key < best.0 {
            best = (key, next);
        }
    }
    best.1
}

fn nearest_permille(numerator: u32, denominator: u32) -> Option<Permille> {
    Permille::new(u16::try_from((2000 * numerator + denominator) / (2 * denominator)).ok()?)
}

/// Rate errors of the phases, the larger first; a phase that is not there has none.
fn rate_errors(trio: &Trio) -> [Ratio; 3] {
    let mut errors = trio.map(|solution| match solution {
        Some(solution) => {
            let divisor = solution.rate.divisor();
            let asked = u64::from(solution.bitrate.bits_per_second()) * divisor;
            Ratio::over(solution.rate.clock().abs_diff(asked), asked)
        }
        None => Ratio::over(0, 1),
    });
    errors.sort_unstable_by(|a, b| b.cmp(a));
    errors
}

/// What decides between prescalers, most important first.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    rate_errors: [Ratio; 3],
    inequality: Ratio,
    point_errors: [Ratio; 3],
}

impl Key {
    fn of(problems: &[Option<PhaseProblem>; 3], trio: &Trio, points: SamplePoints) -> Self {
        let sample_points = trio.map(|solution| solution.map(|s| s.timing.sample_point()));
        let inequality = match points {
            SamplePoints::Own => Ratio::over(0, 1),
            SamplePoints::Equal => spread(&sample_points),
        };
        let mut point_errors = [Ratio::over(0, 1); 3];
        for ((slot, problem), point) in point_errors.iter_mut().zip(problems).zip(sample_points) {
            if let (Some(problem), Some(point)) = (problem, point) {
                let asked = u64::from(problem.request.sample_point.permille());
                *slot = difference(point, Ratio::over(asked, 1000));
            }
        }
        point_errors.sort_unstable_by(|a, b| b.cmp(a));
        Self { rate_errors: rate_errors(trio), inequality, point_errors }
    }
}

fn spread(points: &[Option<Ratio>; 3]) -> Ratio {
    let earliest = points.iter().flatten().min();
    let latest = points.iter().flatten().max();
    match (earliest, latest) {
        (Some(earliest), Some(latest)) => difference(*earliest, *latest),
        _ => Ratio::over(0, 1),
    }
}

/// `|a - b|`; the parts are at most 17 bits each, so nothing overflows.
fn difference(a: Ratio, b: Ratio) -> Ratio {
    let (left, right) = (a.numerator() * b.denominator(), b.numerator() * a.denominator());
    Ratio::over(left.abs_diff(right), a.denominator() * b.denominator())
}
