//! Rows K1, K2, K4, K5, K8, K9 and K11: Koppe, iCC 2003.

use canbaud::detect::scan::Evidence;
use canbaud::lss::{Part, RateSetting, Request};
use canbaud::node::{Node, SettingsError, Silence, Stage, Startup};
use canbaud::timing::controllers::sja1000;
use canbaud::timing::tables::{AP2925, CANOPEN, CANOPEN_TIMER_TICKS};
use canbaud::timing::{Request as TimingRequest, solve};
use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud::wire::{Frame, FrameKind, Id, Level};
use canbaud_sim::check::Checker;
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::{Gate, Span, Time};

use super::bench::{ADDRESS, Inbox, ask, module, plug_in, running, talk};
use super::finding::{Finding, cells, kbits, ms};
use crate::{DeviceConfig, Listener, Network};

pub(super) fn k1() -> Finding {
    let mut finding = Finding::default();
    let mut rows = vec![cells!["rate", "quanta", "sample point", "SJA1000 at 16 MHz"]];
    for row in &CANOPEN {
        let request = Hertz::new(16_000_000)
            .zip(Bitrate::new(row.bits_per_second))
            .map(|(clock, bitrate)| TimingRequest::new(clock, bitrate));
        let solution = request.and_then(|request| solve(&request, &sja1000::NOMINAL).ok());
        let made = solution.map(|s| (s.timing.quanta(), s.timing.sample_point().permille()));
        let printed = (u32::from(row.quanta), u64::from(row.sample_point_permille));
        finding.require(made == Some(printed), format!("{row:?}"));
        let point = |permille: u64| format!("{:.1} %", permille as f64 / 10.0);
        let solved = made.map_or("none".into(), |(q, p)| format!("{q} quanta, {}", point(p)));
        rows.push(cells![kbits(row.bits_per_second), row.quanta, point(printed.1), solved]);
    }
    finding.table(&rows);
    finding
}

/// A manager at 500 kbit/s that looks for the device by LSS, another module, and the device.
fn dead_lock(device: Option<DeviceConfig>) -> (u64, usize, Option<Span>) {
    let mut network = Network::new(4);
    let manager = module(&mut network, "manager", 500_000);
    let other = module(&mut network, "other", 500_000);
    talk(&mut network, other, Span::from_ms(20), Span::from_s(4), 4);
    let place = match device {
        // A device of the old kind: it stays where it was stored.
        None => {
            module(&mut network, "old device", 125_000);
            None
        }
        Some(config) => network.add(config).ok(),
    };
    if let Some(place) = place {
        network.power_on(place);
    }
    let mut inbox = Inbox::of(manager);
    let mut answered = None;
    for _ in 0..30 {
        for (part, number) in [
            (Part::VendorId, ADDRESS.vendor_id),
            (Part::ProductCode, ADDRESS.product_code),
            (Part::RevisionNumber, ADDRESS.revision_number),
            (Part::SerialNumber, ADDRESS.serial_number),
        ] {
            ask(&mut network, manager, Request::SwitchStateSelective { part, number });
        }
        let until = network.sim().now() + Span::from_ms(100);
        network.run_until(until, &mut inbox);
        if inbox.count(0x7E4, &[0x44]) > 0 {
            answered.get_or_insert(network.sim().now().since(Time::ZERO));
        }
        ask(&mut network, manager, Request::SwitchStateGlobal { mode: 0 });
    }
    let errors = network.errors_of(manager) + network.errors_of(other);
    (errors, inbox.count(0x7E4, &[0x44]), answered)
}

pub(super) fn k2() -> Finding {
    let mut finding = Finding::default();
    let (errors, answers, _) = dead_lock(None);
    finding.line(format!("Dead-lock: a device stored with 125 kbit/s in a network of 500 kbit/s, looked for 30 times by LSS within 3 s: {answers} answers, {errors} errors at the other nodes."));
    finding.require(answers == 0 && errors > 0, "no dead-lock");
    let (errors, answers, first) =
        dead_lock(Some(DeviceConfig::automatic(5).fixed(125_000).with_lss(ADDRESS)));
    finding.require(answers >= 29, format!("{answers} answers with canbaud's node"));
    finding.line(format!("Cure 1, the same device with canbaud's node, stored with 125 kbit/s: it listens again after its first error: {answers} answers, {errors} errors, reached within {}.", first.map_or("never".into(), ms)));
    let (errors, answers, first) = dead_lock(Some(DeviceConfig::automatic(5).with_lss(ADDRESS)));
    finding.require(answers >= 29 && errors == 0, format!("{answers} answers, {errors} errors"));
    finding.line(format!(
        "Cure 2, index 9: {answers} answers, {errors} errors, reached within {}.",
        first.map_or("never".into(), ms)
    ));
    finding
}

pub(super) fn k4() -> Finding {
    let mut finding = Finding::default();
    let file = include_str!("../../../canbaud-sim/scenarios/koppe-fallback.toml");
    let run = Scenario::parse("koppe-fallback.toml", file).ok().and_then(|s| Run::new(&s, 1).ok());
    let Some(mut run) = finding.need(run, "the scenario does not run") else { return finding };
    run.finish(&mut canbaud_sim::Blind);
    let nodes = &run.statistics().nodes;
    let lost = nodes.iter().filter(|node| node.found_bitrate == Some(20_000));
    let lost: Vec<_> = lost.map(|node| node.name.clone()).collect();
    let errors: u64 = nodes.iter().map(|node| node.errors).sum();
    finding.line(format!("Fallback to 20 kbit/s (scenario koppe-fallback: manager, device, and one that babbles at 250 kbit/s instead of 500): {errors} errors in 3 s; at 20 kbit/s in the end, lost to the network: {}.", lost.join(", ")));
    finding.require(!lost.is_empty(), "nobody fell back");
    // The same bus with canbaud's node in place of the two.
    let mut network = Network::new(1);
    let manager = module(&mut network, "manager", 500_000);
    talk(&mut network, manager, Span::from_ms(10), Span::from_s(3), 1);
    let mut device = DeviceConfig::automatic(2).fixed(500_000);
    let mut wrong = DeviceConfig::automatic(3).fixed(250_000);
    (device.pdo, wrong.pdo) = (Some(Span::from_ms(10)), Some(Span::from_us(300)));
    let places = [device, wrong].map(|config| network.add(config));
    let places: Vec<usize> = places.into_iter().flatten().collect();
    places.iter().for_each(|place| network.power_on(*place));
    network.run_for(Span::from_s(3));
    let rate = |place: &usize| match network.device(*place).software().map(Node::stage) {
        Some(Stage::TakingPart { bitrate, .. }) => bitrate.to_string(),
        _ => "silent".to_owned(),
    };
    let rates: Vec<String> = places.iter().map(rate).collect();
    let errors = network.tally().errors;
    finding.require(rates == ["500k", "500k"], format!("{rates:?}"));
    finding.line(format!("canbaud's nodes on that bus, one stored with 250 kbit/s: {errors} errors in 3 s, then both at {} bit/s, and the manager never left.", rates.join(" and ")));
    finding
}

pub(super) fn k5() -> Finding {
    let mut finding = Finding::default();
    for row in CANOPEN_TIMER_TICKS.iter().filter(|row| row.is_misprint()) {
        let exact = row.ticks();
        finding.erratum(format!(
            "Table 2, {} MHz, {} kbit/s: {} ticks are printed, {}/{} are right",
            row.timer_mhz,
            row.kbits_per_second,
            row.printed,
            exact.numerator(),
            exact.denominator(),
        ));
    }
    finding.erratum("The paper calls the application note AP2995; it is AP2925");
    finding.require(finding.errata.len() == 2, "one misprint in table 2");
    let at_10 = CANOPEN_TIMER_TICKS.iter().filter(|row| row.timer_mhz == 10);
    let ticks: Vec<String> =
        at_10.map(|row| format!("{} kbit/s: {}", row.kbits_per_second, row.printed)).collect();
    finding.line(format!("Minimum pulse at 10 MHz, as printed: {}.", ticks.join(", ")));
    let mut rows = vec![cells!["lone talker at", "any frame, timer 2 MHz: rate known after"]];
    for bitrate in [500_000, 800_000, 1_000_000] {
        let device = DeviceConfig::automatic(5).with(Listener::None, Some(2_000_000));
        let (mut network, _, place) = running(bitrate, 1, Span::from_ms(2), device, 5);
        let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(2));
        let rate = network.device(place).joined().first().map(|j| j.bitrate.bits_per_second());
        finding.require(rate == Some(bitrate) && violations == 0, format!("{bitrate}: {rate:?}"));
        rows.push(cells![kbits(bitrate), joined.map_or("never".into(), ms)]);
    }
    finding.line("canbaud's node with nothing but a 2 MHz timer (2 to 4 ticks a bit), one active node that nobody acknowledges:");
    finding.table(&rows);
    let slowest = AP2925.iter().map(|row| row.ticks()).min().unwrap_or(0);
    finding.line(format!("AP2925 itself never has fewer than {slowest} ticks a bit."));
    finding
}

pub(super) fn k8() -> Finding {
    let mut finding = Finding::default();
    let (r, d) = (Level::Recessive, Level::Dominant);
    let table = [(r, r, r), (r, d, d), (d, r, d), (d, d, d)];
    let mut rows = vec![cells!["Tx-CAN", "Rx transceiver", "Rx-CAN printed", "Rx-CAN simulated"]];
    for (txd, rxd, printed) in table {
        let simulated = Gate::Closed.controller_rxd(txd, rxd);
        finding.require(simulated == printed, format!("{txd:?} {rxd:?}"));
        rows.push(cells![
            format!("{txd:?}"),
            format!("{rxd:?}"),
            format!("{printed:?}"),
            format!("{simulated:?}")
        ]);
    }
    finding.table(&rows);
    let device = DeviceConfig::automatic(5).with(Listener::Gate, None);
    let (mut network, ids, place) = running(500_000, 2, Span::from_ms(10), device, 6);
    let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(8));
    let errors: u64 = ids.iter().map(|id| network.errors_of(*id)).sum();
    let silence = network.tally().broken_silence;
    finding.require(joined.is_some() && violations + errors + silence == 0, "gate disturbs");
    finding.line(format!("A device with a controller in normal mode behind the closed gate finds 500 kbit/s after {}; dominant levels behind the gate: {silence}; errors at the modules: {errors}.", joined.map_or("never".into(), ms)));
    finding
}

/// Who starts the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Starter {
    /// A CANopen manager: it sends "start all" every 50 ms, and knows nothing of canbaud.
    Manager,
    /// A device with object 1F80h.
    MiniMaster,
}

/// Automatic devices of several kinds, with somebody who starts them and `modules` of fixed rate.
fn configuration(starter: Starter, modules: usize) -> (Option<Span>, u64, u64) {
    let mut network = Network::new(7);
    let mut places: Vec<usize> = Vec::new();
    match starter {
        Starter::MiniMaster => {
            let manager = DeviceConfig::mini_master(1, 500_000, Span::from_ms(20));
            places.extend(network.add(manager));
        }
        Starter::Manager => {
            let id = module(&mut network, "manager", 500_000);
            let start = Frame::new(Id::Base(0), FrameKind::Data, 2, &[1, 0]);
            for n in 0..200 {
                let at = Time::ZERO + Span::from_ms(50 * n);
                start.iter().for_each(|frame| network.sim_mut().send_at(at, id, *frame));
            }
        }
    }
    for n in 0..modules {
        let id = module(&mut network, &format!("fixed-{n}"), 500_000);
        talk(&mut network, id, Span::from_ms(30), Span::from_s(10), 7);
    }
    for (id, listener, timer) in [
        (2, Listener::Monitoring(Evidence::Errors), Some(8_000_000)),
        (3, Listener::Monitoring(Evidence::Errors), None),
        (4, Listener::Gate, None),
        (5, Listener::None, Some(8_000_000)),
    ] {
        places.extend(network.add(DeviceConfig::automatic(id).with(listener, timer)));
    }
    let mut checker = Checker::new(network.sim());
    places.iter().for_each(|place| network.power_on(*place));
    let all = |network: &Network| network.devices().iter().all(|device| device.is_operational());
    let done = network.run_while(Span::from_s(10), &mut checker, all);
    let when = done.then(|| network.sim().now().since(Time::ZERO));
    (when, network.tally().broken_silence, checker.violations())
}

/// Devices that are all automatic; gives when all took part, and how often one broke the silence.
fn all_automatic(silence: Silence, seed: u64) -> (Option<Span>, usize) {
    let mut network = Network::new(seed);
    for id in 2..=6 {
        let listener = Listener::Monitoring(Evidence::Errors);
        let mut config =
            DeviceConfig::automatic(id).with(listener, (id % 2 == 0).then_some(8_000_000));
        config.settings.silence = silence;
        config.settings.seed = seed * 100 + u64::from(id);
        if let Ok(place) = network.add(config) {
            network.power_on(place);
        }
    }
    let in_network = |node: &Node| matches!(node.stage(), Stage::TakingPart { nmt: Some(_), .. });
    let all = |network: &Network| {
        network.devices().iter().all(|device| device.software().is_some_and(in_network))
    };
    let done = network.run_while(Span::from_s(120), &mut canbaud_sim::Blind, all);
    let joins = network.devices().iter().map(|device| device.joined().len()).sum();
    (done.then(|| network.sim().now().since(Time::ZERO)), joins)
}

pub(super) fn k9() -> Finding {
    let mut finding = Finding::default();
    let mut rows =
        vec![cells!["configuration", "all operational after", "dominant before the verdict"]];
    for (name, starter, modules) in [
        ("1: manager, automatic devices only", Starter::Manager, 0),
        (
            "2: manager, two devices of fixed rate without LSS, automatic devices",
            Starter::Manager,
            2,
        ),
        ("3: mini-master of fixed rate, automatic devices", Starter::MiniMaster, 0),
    ] {
        let (when, silence, violations) = configuration(starter, modules);
        finding.require(when.is_some() && silence + violations == 0, name);
        rows.push(cells![name, when.map_or("never".into(), ms), silence]);
    }
    let (when, joins) = all_automatic(Silence::Wait, 1);
    finding.require(when.is_none() && joins == 0, "all automatic: somebody talks");
    rows.push(cells!["3 without its cure: all devices automatic", "never (120 s)", 0]);
    finding.table(&rows);
    finding.line("The device that starts the others must not detect: `Settings::check` refuses index 9 for a mini-master (object 1F80h bit 0), and so does the LSS slave.");
    let mut settings = DeviceConfig::automatic(2).settings;
    settings.startup = Startup::from_1f80(1);
    let refused = Node::<160, 8>::new(settings, None, Micros(0)).err();
    finding.require(refused == Some(SettingsError::MiniMasterAutomatic), "not refused");
    let Some(default) = Bitrate::new(250_000) else { return finding };
    let cure = Silence::Break {
        default,
        after: Micros::from_ms(2_000),
        spread: Micros::from_ms(2_000),
        hold: Micros::from_ms(5_000),
    };
    let mut times: Vec<Span> = Vec::new();
    for seed in 1..=20 {
        let (when, _) = all_automatic(cure, seed);
        finding.require(when.is_some(), format!("seed {seed}: the cure does not work"));
        times.extend(when);
    }
    times.sort();
    if let (Some(first), Some(last)) = (times.first(), times.last()) {
        finding.line(format!("Another cure, without any master (`Silence::Break`, 2 s and up to 2 s at random), five automatic devices, 20 seeds: all take part at 250 kbit/s after {} to {}.", ms(*first), ms(*last)));
    }
    finding
}

pub(super) fn k11() -> Finding {
    let mut finding = Finding::default();
    let mut network = Network::new(9);
    let manager = module(&mut network, "manager", 250_000);
    let other = module(&mut network, "other", 250_000);
    talk(&mut network, other, Span::from_ms(20), Span::from_s(3), 9);
    let device = DeviceConfig::automatic(5).fixed(250_000).with_lss(ADDRESS);
    let Ok(place) = network.add(device) else { return finding };
    let mut seen = (Inbox::of(manager), Checker::new(network.sim()));
    network.power_on(place);
    let steps = [
        Request::SwitchStateGlobal { mode: 1 },
        Request::ConfigureBitTiming { table_selector: 0, table_index: 9 },
        Request::ActivateBitTiming { switch_delay_ms: 50 },
    ];
    let wait = |network: &mut Network, seen: &mut (Inbox, Checker), span| {
        let until = network.sim().now() + span;
        network.run_until(until, seen);
    };
    wait(&mut network, &mut seen, Span::from_ms(200));
    let boots = seen.0.count(0x705, &[0]);
    let mut asked = network.sim().now();
    for step in steps {
        asked = network.sim().now();
        ask(&mut network, manager, step);
        wait(&mut network, &mut seen, Span::from_ms(20));
    }
    let accepted = seen.0.count(0x7E4, &[0x13, 0]);
    wait(&mut network, &mut seen, Span::from_s(1));
    let again = seen.0.count(0x705, &[0]);
    let silent = network.tally().broken_silence + seen.1.violations();
    let setting = network.device(place).software().map(|node| node.settings().rate);
    finding
        .require(boots == 1 && accepted == 1 && again == 2, format!("{boots} {accepted} {again}"));
    finding.require(silent == 0, "disturbs");
    finding.require(setting == Some(RateSetting::Automatic), "not automatic");
    // Nobody may send before the second switch delay is over.
    let boot = seen.0.frames.iter().rev().find(|(_, frame)| frame.data() == [0]);
    let after = boot.map(|(at, _)| at.since(asked));
    finding.require(after.is_some_and(|span| span >= Span::from_ms(100)), "boot-up too early");
    finding.line(format!("LSS at 250 kbit/s: \"configure bit timing, table 0, index 9\" is answered with 0, then activated with a switch delay of 50 ms; the device goes silent, finds 250 kbit/s, and sends its boot-up message {} after the request (two switch delays are 100 ms); dominant levels meanwhile: {silent}.", after.map_or("never".into(), ms)));
    finding
}
