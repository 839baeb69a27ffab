//! Rows A1 to A8: Infineon AP2925.

use canbaud::detect::PulseDetector;
use canbaud::detect::scan::Evidence;
use canbaud::timing::controllers::c167;
use canbaud::timing::tables::{AP2925, Ap2925Row, Misprint};
use canbaud::wire::{Frame, FrameKind, Id, Level, Logic};
use canbaud_sim::around::CaptureTimer;
use canbaud_sim::check::Checker;
use canbaud_sim::{NodeConfig, Observer, Simulation, Span, Time};

use super::bench::{any_frame, plug_in, running};
use super::finding::{Finding, cells, kbits, ms};
use crate::{Ap2925, Ap2925Table, DeviceConfig, Listener};

/// The rates of the document.
const RATES: [u32; 5] = [1_000_000, 500_000, 250_000, 125_000, 50_000];

pub(super) fn a1() -> Finding {
    let mut finding = Finding::default();
    let mut rows =
        vec![cells!["bus", "time to take part", "dominant levels before", "errors caused"]];
    for bitrate in RATES {
        let device = DeviceConfig::automatic(5).with(Listener::Monitoring(Evidence::Errors), None);
        let (mut network, ids, place) = running(bitrate, 2, Span::from_ms(10), device, 1);
        let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(8));
        let errors: u64 = ids.iter().map(|id| network.errors_of(*id)).sum();
        let silence = network.tally().broken_silence;
        let rate = network.device(place).joined().first().map(|joined| joined.bitrate);
        finding.require(rate.is_some_and(|r| r.bits_per_second() == bitrate), kbits(bitrate));
        finding
            .require(violations + errors + silence == 0, format!("{}: disturbed", kbits(bitrate)));
        rows.push(cells![kbits(bitrate), joined.map_or("never".into(), ms), silence, errors]);
    }
    finding.line("A device with a controller that only listens, no timer, on a bus with two modules that send any frame every 10 ms:");
    finding.table(&rows);
    finding
}

/// Two modules that send any frame as fast as they can, and the C167 of AP2925.
fn measure(row: &Ap2925Row, table: Ap2925Table, phase: u64) -> Option<(Ap2925, u64)> {
    let bitrate = u32::from(row.kbits_per_second) * 1000;
    let mut sim = Simulation::new(phase);
    let module = || NodeConfig::at("module", bitrate).map(|c| c.with_ppb(phase as i64 * 25_000));
    let ids = [sim.add_node(module().ok()?).ok()?, sim.add_node(module().ok()?).ok()?];
    let mut device = Ap2925::new(&mut sim, row.cpu_mhz, -50_000, table, phase).ok()?;
    let mut rng = canbaud_sim::Rng::new(phase);
    let bit = Span::from_ns(1_000_000_000 / u64::from(bitrate));
    for n in 0..60 {
        let at = Time::ZERO + Span::from_fs(bit.femtoseconds() * (200 * n + rng.below(60)));
        sim.send_at(at, ids[n as usize % 2], any_frame(ids[n as usize % 2], &mut rng));
    }
    let mut checker = Checker::new(&sim);
    let end = Time::ZERO + Span::from_fs(bit.femtoseconds() * 200 * 60);
    device.run(&mut sim, end, &mut checker);
    Some((device, checker.violations()))
}

/// Shortest levels measured over several phases of the loop, and how often the rate was found.
fn measured(row: &Ap2925Row, table: Ap2925Table) -> (u32, u32, usize) {
    let runs: Vec<_> = (0..4).filter_map(|phase| measure(row, table, phase)).collect();
    let first = |(device, _): &(Ap2925, u64)| device.measured().first().copied();
    let ticks: Vec<u32> = runs.iter().filter_map(first).collect();
    let found = runs.iter().filter(|(device, _)| device.found().is_some()).count();
    (ticks.iter().min().copied().unwrap_or(0), ticks.iter().max().copied().unwrap_or(0), found)
}

pub(super) fn a2() -> Finding {
    let mut finding = Finding::default();
    let mut rows =
        vec![cells!["f_CPU", "bus", "ticks a bit", "range", "measured", "rate found and verified"]];
    for row in &AP2925 {
        let (low, high, found) = measured(row, Ap2925Table::Corrected);
        let [from, exact, to] = row.right_ticks().map(u32::from);
        let inside = from <= low && high <= to;
        let name = format!("{} MHz, {} kbit/s", row.cpu_mhz, row.kbits_per_second);
        finding.require(inside, format!("{name}: {low} to {high} outside {from} to {to}"));
        finding.require(found == 4, format!("{name}: found {found} of 4"));
        rows.push(cells![
            format!("{} MHz", row.cpu_mhz),
            format!("{} kbit/s", row.kbits_per_second),
            exact,
            format!("{from} to {to}"),
            format!("{low} to {high}"),
            format!("{found} of 4"),
        ]);
    }
    finding.line("The simulated loop of measure.c (4 clocks a turn) with 100 dominant levels, four phases each, clocks 50 to 125 ppm apart, the table with its misprints put right:");
    finding.table(&rows);
    finding
}

/// Edges at the star point.
#[derive(Debug, Default)]
struct Edges(Vec<(Time, Level)>);

impl Observer for Edges {
    fn bus(&mut self, at: Time, level: Level) {
        self.0.push((at, level));
    }
}

/// Edges that a lone talker makes with `frame`.
fn lone(bitrate: u32, frame: Frame, span: Span) -> Vec<(Time, Level)> {
    let mut sim = Simulation::new(1);
    let mut edges = Edges::default();
    if let Ok(config) = NodeConfig::at("lone", bitrate)
        && let Ok(id) = sim.add_node(config)
    {
        sim.send_at(Time::ZERO, id, frame);
        sim.run(Time::ZERO + span, &mut edges);
    }
    edges.0
}

/// The shortest dominant level of a recording, in bits of `bitrate`, rounded.
fn shortest_bits(edges: &[(Time, Level)], bitrate: u32) -> u64 {
    let dominant = edges.windows(2).filter(|pair| pair[0].1 == Level::Dominant);
    let shortest = dominant.map(|pair| pair[1].0.since(pair[0].0).femtoseconds()).min();
    let bit = 1_000_000_000_000_000 / u64::from(bitrate);
    (shortest.unwrap_or(0) + bit / 2) / bit
}

pub(super) fn a3() -> Finding {
    let mut finding = Finding::default();
    let bitrate = 500_000;
    // A lone talker's frame in which no dominant bit stands alone.
    let lonely = (0..0x800_u32 * 256).find_map(|n| {
        let id = Id::base((n / 256) as u16)?;
        let frame = Frame::new(id, FrameKind::Data, 1, &[n as u8]).ok()?;
        let edges = lone(bitrate, frame, Span::from_us(120));
        (shortest_bits(&edges, bitrate) >= 2).then_some(frame)
    });
    let Some(frame) = finding.need(lonely, "no such frame") else { return finding };
    let edges = lone(bitrate, frame, Span::from_ms(30));
    let shortest = shortest_bits(&edges, bitrate);
    let Ok(mut timer) = CaptureTimer::new(2_000_000, 0, 64, Span::ZERO) else { return finding };
    let mut detector = PulseDetector::<160>::new();
    detector.begin(0, Logic::High);
    let mut frames = None;
    for (at, level) in &edges {
        timer.edge(*at, *level).into_iter().for_each(|capture| detector.push(capture.ticks));
        if let canbaud::detect::Verdict::Found(found) = detector.verdict() {
            frames.get_or_insert((found, at.since(Time::ZERO)));
        }
    }
    let bytes: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    finding.line(format!(
        "A lone talker at {} sends the data frame {}#{bytes}, which nobody acknowledges: its shortest dominant level is {shortest} bits, so the shortest of 100 says {}.",
        kbits(bitrate),
        frame.id(),
        kbits(bitrate / shortest.max(1) as u32),
    ));
    finding.require(shortest == 2, "the frame has a lone dominant bit");
    let Some((found, at)) = finding.need(frames, "the detector has no verdict") else {
        return finding;
    };
    let timebase =
        canbaud::units::Hertz::new(2_000_000).map(canbaud::units::Timebase::from_frequency);
    let rate = timebase.and_then(|t| found.nominal.millibits_per_second(t)).unwrap_or(0) / 1000;
    finding.require(rate.abs_diff(500_000) < 2_500, format!("measured {rate} bit/s"));
    finding.line(format!(
        "`PulseDetector` with a 2 MHz timer (4 ticks a bit) proves {:.1} kbit/s from {} frame(s), {} after the start.",
        rate as f64 / 1e3,
        found.proven_frames,
        ms(at),
    ));
    finding
}

/// What a misprint says, for people.
fn say(row: &Ap2925Row, misprint: &Misprint) -> String {
    let place = format!("{} MHz, {} kbit/s", row.cpu_mhz, row.kbits_per_second);
    match misprint {
        Misprint::Register { right } => {
            format!("{place}: register {:04X}h is printed, {right:04X}h is right", row.printed_btr)
        }
        Misprint::SamplePoint { right } => format!(
            "{place}: sample point {} % is printed, that of the register is {:.2} %",
            row.printed_sample_point / 10,
            right.numerator() as f64 * 100.0 / right.denominator() as f64,
        ),
        Misprint::Ticks { right } => {
            format!("{place}: ticks {:?} are printed, {right:?} are right", row.printed_ticks)
        }
    }
}

pub(super) fn a4() -> Finding {
    let mut finding = Finding::default();
    for row in &AP2925 {
        for misprint in row.misprints() {
            finding.erratum(say(row, &misprint));
        }
    }
    finding.require(finding.errata.len() == 7, "seven misprints");
    // What the two that matter do to a bus.
    let slow = measure(&AP2925[4], Ap2925Table::Printed, 1);
    let right = measure(&AP2925[4], Ap2925Table::Corrected, 1);
    let ticks = measure(&AP2925[12], Ap2925Table::Printed, 1);
    if let (Some((slow, _)), Some((right, _)), Some((ticks, _))) = (&slow, &right, &ticks) {
        finding.line(format!(
            "24 MHz, 50 kbit/s: with the printed register (47.619 kbit/s) the device destroys {} frames of the bus and never gets in; with the right one it destroys {} and is in.",
            slow.errors(), right.errors(),
        ));
        finding.line(format!(
            "8 MHz, 125 kbit/s: the shortest level measures {} ticks, which is in no printed range: {}.",
            ticks.measured().first().copied().unwrap_or(0),
            if ticks.found().is_some() { "found all the same" } else { "the rate is never found" },
        ));
        finding.require(slow.errors() > 0 && slow.found().is_none(), "47.619 kbit/s works");
        finding.require(right.errors() == 0 && right.found().is_some(), "50 kbit/s does not work");
        finding.require(ticks.found().is_none(), "125 kbit/s is found by the printed ticks");
    }
    let generated = AP2925.iter().filter(|row| c167_register(row) == Some(row.btr())).count();
    finding.require(generated == AP2925.len(), "registers packed");
    finding.line(format!("The {} lines are reproduced from their segment columns; 800, 100, 20 and 10 kbit/s are missing in the document. `canbaud timing` makes such a table for any clock and controller.", AP2925.len()));
    finding
}

fn c167_register(row: &Ap2925Row) -> Option<u16> {
    let word = c167::BTR.pack(&canbaud::timing::controllers::Configuration::classic(row.timing));
    u16::try_from(word.ok()?).ok()
}

/// Bit time in CPU clocks of a register, by the formula of the document.
fn formula(register: u16) -> u32 {
    let (brp, tseg1, tseg2) = (register & 0x3F, register >> 8 & 0x0F, register >> 12 & 0x07);
    2 * (u32::from(brp) + 1) * (1 + (u32::from(tseg1) + 1) + (u32::from(tseg2) + 1))
}

pub(super) fn a5() -> Finding {
    let mut finding = Finding::default();
    let holds = |register: fn(&Ap2925Row) -> u16| {
        AP2925.iter().filter(|row| formula(register(row)) == row.ticks()).count()
    };
    let (printed, code, right) =
        (holds(|row| row.printed_btr), holds(|row| row.code_btr), holds(|row| row.btr()));
    finding.require((printed, code, right) == (25, 26, 26), "25, 26 and 26 registers");
    let alike =
        AP2925.iter().filter(|row| row.timing.clocks_per_bit(2) == u64::from(formula(row.btr())));
    finding.require(alike.count() == AP2925.len(), "library and formula differ");
    finding.line(format!("The formula, worked out from the bits of the register, gives the bit rate for {printed} of 26 printed registers, {code} of 26 in the program, {right} of 26 that canbaud packs."));
    finding
}

pub(super) fn a6() -> Finding {
    let mut finding = Finding::default();
    let as_described = with_a_glitch();
    if let Some((device, violations)) = &as_described {
        let (measured, found) = (device.measured(), device.found());
        finding.require(*violations == 0, "checkers complain");
        finding.require(found.is_some_and(|(_, rate)| rate == 500_000), "500 kbit/s not found");
        finding.require(device.errors() > 0 && measured.len() > 1, "the glitch did no harm");
        finding.line(format!(
            "As described, 24 MHz, 500 kbit/s, with one glitch of 1 µs in the first measurement: the shortest levels are {measured:?} ticks; the first means 1 Mbit/s, the controller goes on, {} error(s) later it measures again and is in at {}.",
            device.errors(),
            found.map_or("never".into(), |(at, _)| ms(at.since(Time::ZERO))),
        ));
    }
    let mut rows = vec![cells![
        "canbaud's node with",
        "in after",
        "wrong rates tried on the bus",
        "dominant before the verdict"
    ]];
    for (name, listener, timer) in [
        ("timer and bus monitoring", Listener::Monitoring(Evidence::Errors), Some(24_000_000)),
        ("timer alone", Listener::None, Some(24_000_000)),
        ("bus monitoring alone", Listener::Monitoring(Evidence::Errors), None),
    ] {
        let device = DeviceConfig::automatic(5).with(listener, timer);
        let (mut network, _, place) = running(500_000, 2, Span::from_ms(5), device, 2);
        for n in 0..20 {
            let at = Time::ZERO + Span::from_us(3_000 + 1_700 * n);
            network.sim_mut().dominant_at(at, Span::from_ns(100));
        }
        let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(8));
        let wrong = network.device(place).joined().iter();
        let wrong = wrong.filter(|joined| joined.bitrate.bits_per_second() != 500_000).count();
        let silence = network.tally().broken_silence;
        finding.require(joined.is_some() && violations == 0, format!("{name}: not in"));
        finding.require(wrong == 0 && silence == 0, format!("{name}: disturbs"));
        rows.push(cells![name, joined.map_or("never".into(), ms), wrong, silence]);
    }
    finding.line("canbaud's node on such a bus (two modules, any frame every 5 ms) with a glitch of 100 ns every 1.7 ms:");
    finding.table(&rows);
    finding
}

/// The procedure of the document, with a pulse in the first measurement that is half a bit short.
fn with_a_glitch() -> Option<(Ap2925, u64)> {
    let mut sim = Simulation::new(3);
    let module = || NodeConfig::at("module", 500_000).ok();
    let ids = [sim.add_node(module()?).ok()?, sim.add_node(module()?).ok()?];
    let mut device = Ap2925::new(&mut sim, 24, 0, Ap2925Table::Corrected, 1).ok()?;
    let mut rng = canbaud_sim::Rng::new(3);
    for n in 0..60_u64 {
        let at = Time::ZERO + Span::from_us(400 * n + rng.below(60));
        let id = ids[n as usize % 2];
        sim.send_at(at, id, any_frame(id, &mut rng));
    }
    // In the pause between two frames.
    sim.dominant_at(Time::ZERO + Span::from_us(790), Span::from_us(1));
    let mut checker = Checker::new(&sim);
    device.run(&mut sim, Time::ZERO + Span::from_ms(24), &mut checker);
    Some((device, checker.violations()))
}

pub(super) fn a7() -> Finding {
    let mut finding = Finding::default();
    let mut worst = (0_i64, 0_i64);
    for row in &AP2925 {
        let (low, high, _) = measured(row, Ap2925Table::Corrected);
        let exact = i64::from(row.ticks());
        worst = (worst.0.min(i64::from(low) - exact), worst.1.max(i64::from(high) - exact));
    }
    let narrowest = AP2925.iter().map(|row| {
        let [from, exact, to] = row.right_ticks();
        (exact - from).min(to - exact)
    });
    let narrowest = narrowest.min().unwrap_or(0);
    finding.require(worst.0 < 0, "the loop measures exactly");
    finding.require(worst.0 >= -4 && worst.1 <= 4, format!("off by {worst:?}"));
    finding.line(format!("Over all 26 lines the loop's shortest level is {} to {:+} ticks from the exact count (one turn of the loop is 4 clocks); the narrowest range of the tables leaves {narrowest} ticks to one side.", worst.0, worst.1));
    finding
}

pub(super) fn a8() -> Finding {
    let mut finding = Finding::default();
    let mut plugs = 0;
    for (seed, (listener, timer)) in [
        (Listener::Monitoring(Evidence::Errors), Some(8_000_000)),
        (Listener::Monitoring(Evidence::Counter), None),
        (Listener::Monitoring(Evidence::FramesOnly), None),
        (Listener::Gate, None),
        (Listener::None, Some(8_000_000)),
    ]
    .into_iter()
    .enumerate()
    {
        for bitrate in RATES {
            let device = DeviceConfig::automatic(5).with(listener, timer);
            let seed = 10 + seed as u64;
            let (mut network, ids, place) = running(bitrate, 3, Span::from_ms(15), device, seed);
            let wait = Span::from_us(4_321);
            let (joined, violations) = plug_in(&mut network, place, wait, Span::from_s(8));
            network.run_for(Span::from_ms(50));
            let name = format!("{listener:?} at {}", kbits(bitrate));
            let errors: u64 = ids.iter().map(|id| network.errors_of(*id)).sum();
            finding.require(joined.is_some(), format!("{name}: not in"));
            finding.require(
                violations + errors + network.tally().broken_silence == 0,
                format!("{name}: {errors} errors"),
            );
            plugs += 1;
        }
    }
    finding.line(format!("{plugs} hot plugs (five kinds of device, five rates, three modules that talk), under all checkers: 0 dominant levels before the verdict, 0 errors at any module before and after it."));
    finding
}
