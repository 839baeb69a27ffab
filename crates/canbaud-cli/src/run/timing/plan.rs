//! From what the user said to the settings.

use canbaud::timing::controllers::{ALL, Configuration, Controller, Phase};
use canbaud::timing::fd::{PhaseRequests, SamplePoints, solve_phases};
use canbaud::timing::physics_bus::{Bus, Window};
use canbaud::timing::physics_fit::{sample_points_for_bus, solutions_for_bus};
use canbaud::timing::tdc::Tdc;
use canbaud::timing::xl::{PwmLimits, pwm};
use canbaud::timing::{Limits, Request, Solution, solutions};
use canbaud::units::{Bitrate, Hertz, Permille};

use super::args::{Policy, TimingArgs};
use super::refusal::Refusal;
use super::{autobaud, decode, json, names, tables, text};
use crate::exit::Exit;
use crate::tell::tell;

/// Most settings that can be listed; `--count` goes up to this.
const LISTED_MAX: usize = 20;

/// What was found.
pub(super) struct Answer {
    pub(super) controller: Controller,
    pub(super) clock: Hertz,
    pub(super) phases: Vec<PhaseAnswer>,
    /// The best setting of every phase.
    pub(super) configuration: Configuration,
    pub(super) data_tdc: Tdc,
    pub(super) bus: Bus,
    /// Sample points that bus and clocks leave; only when they were given.
    pub(super) window: Option<Window>,
}

/// The settings of one phase, best first.
pub(super) struct PhaseAnswer {
    pub(super) phase: Phase,
    pub(super) request: Request,
    pub(super) solutions: Vec<Solution>,
}

/// `canbaud timing`.
pub(crate) fn timing(args: &TimingArgs) -> Exit {
    match run(args) {
        Ok(text) => text::print(&text),
        Err(refusal) => refusal.tell(args.json),
    }
}

/// What the command prints.
pub(super) fn run(args: &TimingArgs) -> Result<String, Refusal> {
    match args {
        TimingArgs { table: Some(table), .. } => tables::run(*table, args.json),
        TimingArgs { autobaud_table: true, .. } => autobaud::run(args),
        TimingArgs { decode: Some(words), .. } => decode::run(args, words),
        TimingArgs { all: true, .. } => all(args),
        _ => one(args),
    }
}

fn one(args: &TimingArgs) -> Result<String, Refusal> {
    let answer = solve(args, &controller(args)?)?;
    if args.json { json::answer(&answer) } else { text::answer(&answer) }
}

/// One line for each controller; those that cannot do it are named at the end.
fn all(args: &TimingArgs) -> Result<String, Refusal> {
    let (mut answers, mut refusals) = (Vec::new(), Vec::new());
    for controller in ALL {
        match solve(args, &with_divider(controller, args)) {
            Ok(answer) => answers.push(answer),
            Err(refusal) if refusal.exit == Exit::Impossible => {
                refusals.push((controller.name, refusal));
            }
            // No data phase, or what is wrong for every controller.
            Err(refusal) if args.clock.is_none() || args.bitrate.is_none() => return Err(refusal),
            Err(refusal) => refusals.push((controller.name, refusal)),
        }
    }
    if answers.is_empty() {
        let (name, refusal) = refusals.swap_remove(0);
        return Err(Refusal {
            line: format!("no controller can do this; {name}: {}", refusal.line),
            ..refusal
        });
    }
    if args.json { json::all(&answers, &refusals) } else { text::all(&answers, &refusals) }
}

/// The controller that was named, behind the divider that was given.
pub(super) fn controller(args: &TimingArgs) -> Result<Controller, Refusal> {
    let found = match &args.controller {
        Some(name) => names::find(name)?,
        None => &names::ANY,
    };
    Ok(with_divider(found, args))
}

fn with_divider(controller: &Controller, args: &TimingArgs) -> Controller {
    match args.clock_divider {
        Some(divider) => controller.with_clock_divider(divider),
        None => *controller,
    }
}

/// The clock, or what to say without it.
pub(super) fn clock(args: &TimingArgs) -> Result<Hertz, Refusal> {
    args.clock.ok_or_else(|| {
        Refusal::usage(
            "--clock is missing",
            Some("the clock of the controller: --clock 80M".to_owned()),
        )
    })
}

fn solve(args: &TimingArgs, controller: &Controller) -> Result<Answer, Refusal> {
    let clock = clock(args)?;
    let Some(bitrate) = args.bitrate else {
        return Err(Refusal::usage(
            "--bitrate is missing",
            Some("such as --bitrate 500k".to_owned()),
        ));
    };
    let bus = bus(args);
    let nominal = request(args, clock, bitrate, args.sample_point);
    let data_point = args.data_sample_point;
    let data = args.data_bitrate.map(|rate| request(args, clock, rate, data_point));
    let xl = args.xl_bitrate.map(|rate| request(args, clock, rate, data_point));
    let answer = if data.is_none() && xl.is_none() {
        single(args, controller, nominal, bus)
    } else {
        let points = if args.equal_sample_points { SamplePoints::Equal } else { SamplePoints::Own };
        several(args, controller, PhaseRequests { nominal, data, xl, sample_points: points }, bus)
    };
    answer.map_err(|refusal| match &refusal.hint {
        None if controller.name == names::ANY.name && refusal.exit == Exit::Impossible => refusal
            .with_hint("--controller NAME or --all: most controllers can hold more than this"),
        _ => refusal,
    })
}

pub(super) fn request(
    args: &TimingArgs,
    clock: Hertz,
    bitrate: Bitrate,
    point: Option<Permille>,
) -> Request {
    let request =
        Request::new(clock, bitrate).with_sjw(args.sjw).with_tolerance_ppm(args.tolerance);
    let point = point.unwrap_or(request.sample_point);
    request.with_sample_point(point, args.policy.into())
}

fn bus(args: &TimingArgs) -> Bus {
    Bus::new(args.bus.length.unwrap_or(0))
        .with_node_delay_ns(args.bus.node_delay)
        .with_cable_delay_ps_per_m(args.bus.cable_delay)
}

/// Clock tolerance asked for, when the bus matters at all.
fn bus_tolerance(args: &TimingArgs) -> Option<u32> {
    match (args.bus.length, args.bus.ppm) {
        (None, None) => None,
        (_, Some(ppm)) => Some(ppm),
        (Some(_), None) => Some(0),
    }
}

fn single(
    args: &TimingArgs,
    controller: &Controller,
    request: Request,
    bus: Bus,
) -> Result<Answer, Refusal> {
    let limits = &controller.nominal;
    let window = bus_tolerance(args).map(|ppm| Window::new(request.bitrate, &bus, ppm));
    let ranked = match bus_tolerance(args) {
        Some(ppm) => solutions_for_bus::<LISTED_MAX>(&request, limits, &bus, ppm)?,
        None => solutions::<LISTED_MAX>(&request, limits)?,
    };
    let solutions: Vec<Solution> = ranked.iter().take(args.count.into()).copied().collect();
    let Some(best) = solutions.first() else {
        return Err(no_sjw(&request, limits));
    };
    Ok(Answer {
        controller: *controller,
        clock: request.clock,
        configuration: Configuration::classic(best.timing),
        phases: vec![PhaseAnswer { phase: Phase::Nominal, request, solutions }],
        data_tdc: Tdc::None,
        bus,
        window,
    })
}

/// `solutions` leaves out what cannot have the SJW; `solve` then says so.
fn no_sjw(request: &Request, limits: &Limits) -> Refusal {
    match canbaud::timing::solve(request, limits) {
        Err(error) => error.into(),
        Ok(_) => Refusal::impossible("no setting meets every condition", None),
    }
}

fn several(
    args: &TimingArgs,
    controller: &Controller,
    mut requests: PhaseRequests,
    bus: Bus,
) -> Result<Answer, Refusal> {
    let nominal = &mut requests.nominal;
    let window = bus_tolerance(args).map(|ppm| Window::new(nominal.bitrate, &bus, ppm));
    if let Some(ppm) = bus_tolerance(args) {
        if args.policy != Policy::Nearest {
            return Err(Refusal::usage(
                "--policy does not go with --length or --ppm and a data phase",
                None,
            ));
        }
        nominal.policy = sample_points_for_bus(nominal.bitrate, &bus, ppm)?;
    }
    let nominal = requests.nominal;
    let solved = solve_phases(controller, &requests)?;
    let mut configuration = solved.configuration();
    if let Some(xl) = &solved.xl {
        let coding = pwm(
            nominal.clock,
            xl.rate.divisor(),
            solved.nominal.rate.divisor(),
            PwmLimits::SIX_BITS,
        );
        match coding {
            Ok(coding) => configuration.pwm = Some(coding),
            Err(error) => tell!("canbaud: the XL data phase stays without PWM: {error}"),
        }
    }
    let mut phases = vec![PhaseAnswer {
        phase: Phase::Nominal,
        request: nominal,
        solutions: vec![solved.nominal],
    }];
    for (phase, request, solution) in
        [(Phase::Data, requests.data, solved.data), (Phase::Xl, requests.xl, solved.xl)]
    {
        if let (Some(request), Some(solution)) = (request, solution) {
            phases.push(PhaseAnswer { phase, request, solutions: vec![solution] });
        }
    }
    let clock = nominal.clock;
    let data_tdc = solved.data_tdc;
    Ok(Answer { controller: *controller, clock, phases, configuration, data_tdc, bus, window })
}
