//! Row K3: the demands of Koppe, one scenario each.

use canbaud::detect::scan::Evidence;
use canbaud::lss::Request;
use canbaud::timing::tables::CANOPEN;
use canbaud_sim::check::Checker;
use canbaud_sim::{NodeConfig, Span, Time};

use super::bench::{ADDRESS, Inbox, ask, module, plug_in, running, talk};
use super::finding::{Finding, cells, kbits, ms};
use crate::{DeviceConfig, Listener, Network};

pub(super) fn k3() -> Finding {
    let mut finding = Finding::default();
    let mut rows = vec![cells!["demand", "figure"]];
    for (demand, scenario) in [
        ("configured within the network", within as fn(&mut Finding) -> String),
        ("bus-off handled autonomously", bus_off),
        ("runs with modules that do not support LSS", beside_others),
        ("all CANopen bit rates", all_rates),
        ("no error frames by wrong bit rates", no_error_frames),
        ("no specific identifier or data", any_frames),
    ] {
        let figure = scenario(&mut finding);
        rows.push(cells![demand, figure]);
    }
    finding.table(&rows);
    finding
}

/// The whole network goes from 250 to 500 kbit/s by LSS.
fn within(finding: &mut Finding) -> String {
    let mut network = Network::new(31);
    let manager = module(&mut network, "manager", 250_000);
    let other = module(&mut network, "other", 250_000);
    talk(&mut network, other, Span::from_ms(20), Span::from_ms(380), 31);
    let Ok(place) = network.add(DeviceConfig::automatic(5).with_lss(ADDRESS)) else {
        return String::new();
    };
    network.power_on(place);
    let mut seen = (Inbox::of(manager), Checker::new(network.sim()));
    let wait = |network: &mut Network, seen: &mut (Inbox, Checker), ms| {
        let until = network.sim().now() + Span::from_ms(ms);
        network.run_until(until, seen);
    };
    wait(&mut network, &mut seen, 300);
    for request in [
        Request::SwitchStateGlobal { mode: 1 },
        Request::ConfigureBitTiming { table_selector: 0, table_index: 2 },
        Request::StoreConfiguration,
        Request::ActivateBitTiming { switch_delay_ms: 50 },
    ] {
        ask(&mut network, manager, request);
        wait(&mut network, &mut seen, 20);
    }
    // The two without LSS are switched by their own means.
    let now = network.sim().now();
    for id in [manager, other] {
        if let Ok(config) = NodeConfig::at("switched", 500_000) {
            let _ = network.sim_mut().reconfigure_at(now + Span::from_ms(40), id, config);
        }
    }
    wait(&mut network, &mut seen, 300);
    ask(&mut network, manager, Request::InquireNodeId);
    ask(&mut network, manager, Request::SwitchStateGlobal { mode: 0 });
    wait(&mut network, &mut seen, 300);
    let answered = seen.0.count(0x7E4, &[0x13, 0]) + seen.0.count(0x7E4, &[0x17, 0]);
    let boots = seen.0.count(0x705, &[0]);
    let errors = network.errors_of(manager) + network.errors_of(other) + seen.1.violations();
    let rate = network.device(place).joined().last().map_or(0, |j| j.bitrate.bits_per_second());
    finding.require(answered == 2 && boots == 2, format!("within: {answered} {boots}"));
    finding.require(errors == 0 && rate == 500_000, format!("within: {errors} errors, {rate}"));
    format!(
        "250 to 500 kbit/s by LSS: {answered} positive answers, boot-up at the new rate, {errors} errors"
    )
}

/// The line is shorted until nodes are bus-off; then the rate changes while one is bus-off.
fn bus_off(finding: &mut Finding) -> String {
    let mut network = Network::new(32);
    let manager = DeviceConfig::mini_master(1, 250_000, Span::from_ms(20));
    let mut config = DeviceConfig::automatic(2);
    config.pdo = Some(Span::from_ms(5));
    let places: Vec<usize> =
        [manager, config].map(|config| network.add(config)).into_iter().flatten().collect();
    let mut checker = Checker::new(network.sim());
    places.iter().for_each(|place| network.power_on(*place));
    let begin = Time::ZERO + Span::from_ms(500);
    network.run_until(begin, &mut checker);
    let joins = network.device(places[1]).joined().len();
    network.sim_mut().recessive_at(begin, Span::from_ms(50));
    network.run_until(begin + Span::from_ms(51), &mut checker);
    let all = |network: &Network| network.devices().iter().all(|d| d.is_operational());
    let shorted = network.sim().now();
    let done = network.run_while(Span::from_s(10), &mut checker, all);
    let back = network.sim().now().since(shorted);
    let fell = network.device(places[1]).joined().len() > joins;
    let broken = network.tally().broken_silence + checker.violations();
    finding.require(done && fell && broken == 0, format!("bus-off: {done} {fell} {broken}"));
    format!(
        "line shorted for 50 ms while both send: both bus-off, both operational again {} later, nobody touched them",
        ms(back)
    )
}

fn beside_others(finding: &mut Finding) -> String {
    let device = DeviceConfig::automatic(5);
    let (mut network, ids, place) = running(125_000, 4, Span::from_ms(20), device, 33);
    let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(5));
    network.run_for(Span::from_s(2));
    let errors: u64 = ids.iter().map(|id| network.errors_of(*id)).sum();
    finding.require(joined.is_some() && violations + errors == 0, "beside others");
    let joined = joined.map_or("never".into(), ms);
    format!("four modules without LSS at 125 kbit/s: in after {joined}, {errors} errors in 2 s")
}

fn all_rates(finding: &mut Finding) -> String {
    let mut figures = Vec::new();
    for row in &CANOPEN {
        let rate = row.bits_per_second;
        for (listener, timer) in [
            (Listener::Monitoring(Evidence::Errors), Some(8_000_000)),
            (Listener::Monitoring(Evidence::Errors), None),
        ] {
            let device = DeviceConfig::automatic(5).with(listener, timer);
            let period = Span::from_us((300_000_000 / u64::from(rate)).max(5_000));
            let (mut network, ids, place) = running(rate, 2, period, device, 34);
            let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(9));
            let errors: u64 = ids.iter().map(|id| network.errors_of(*id)).sum();
            let found = network.device(place).joined().first().map(|j| j.bitrate.bits_per_second());
            finding.require(found == Some(rate), format!("{}: {found:?}", kbits(rate)));
            finding.require(violations + errors == 0, format!("{}: errors", kbits(rate)));
            if timer.is_some() {
                figures.push(format!("{}: {}", kbits(rate), joined.map_or("never".into(), ms)));
            }
        }
    }
    format!("with a timer and without; with: {}", figures.join(", "))
}

fn no_error_frames(finding: &mut Finding) -> String {
    let (mut devices, mut errors) = (0, 0);
    for seed in 0..6 {
        let (mut network, ids, place) =
            running(500_000, 2, Span::from_ms(4), DeviceConfig::automatic(5), 350 + seed);
        let mut places = vec![place];
        for (id, listener, timer) in [
            (6, Listener::Monitoring(Evidence::Counter), None),
            (7, Listener::Gate, None),
            (8, Listener::None, Some(8_000_000)),
        ] {
            places.extend(network.add(DeviceConfig::automatic(id).with(listener, timer)));
        }
        let mut checker = Checker::new(network.sim());
        places.iter().for_each(|place| network.power_on(*place));
        let all = |network: &Network| network.devices().iter().all(|d| !d.must_be_silent());
        let done = network.run_while(Span::from_s(9), &mut checker, all);
        finding.require(done, format!("seed {seed}: not all in"));
        devices += places.len();
        let caused: u64 = ids.iter().map(|id| network.errors_of(*id)).sum();
        errors += caused + checker.violations() + network.tally().broken_silence;
    }
    finding.require(errors == 0, format!("{errors} errors"));
    format!(
        "{devices} devices that detect together in 6 networks: {errors} errors, every bit checked"
    )
}

fn any_frames(finding: &mut Finding) -> String {
    let mut times = Vec::new();
    for seed in 0..20 {
        let device = DeviceConfig::automatic(5);
        let (mut network, _, place) = running(250_000, 1, Span::from_ms(10), device, 360 + seed);
        let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(5));
        finding.require(joined.is_some() && violations == 0, format!("any frame, seed {seed}"));
        times.extend(joined);
    }
    times.sort();
    let worst = times.last().copied().map_or("never".into(), ms);
    format!(
        "a lone talker, random identifiers (11 and 29 bits), lengths and data, 20 seeds: in after {worst} at most"
    )
}
