//! Networks of nodes that find their own way; a few seeds of what `examples/plant` and
//! `examples/day` run by the thousand.

use canbaud::lss::RateSetting;
use canbaud::node::{Leds, Pattern, Silence, Stage};
use canbaud::units::{Bitrate, Micros};
use canbaud_lab::{DeviceConfig, Listener, Memory, Mix, Network, Plant, Shift};
use canbaud_sim::check::Checker;
use canbaud_sim::{Span, Time};

/// All automatic but one, 250 kbit/s, power-on to all operational, every bit checked.
#[test]
fn twenty_nodes_come_up_with_every_mix_and_seed() {
    for mix in Mix::ALL {
        for seed in 0..12 {
            let plant = Plant { nodes: 20, bitrate: 250_000, mix, seed };
            let (mut network, times) = plant.build();
            let mut checker = Checker::new(network.sim());
            let outcome = plant.bring_up(&mut network, &times, Span::from_s(60), &mut checker);
            let what = format!("examples/plant 1 {mix:?} {seed}: {outcome:?}");
            assert!(outcome.all_operational.is_some(), "{what}");
            assert_eq!((outcome.broken_silence, outcome.wrong_joins), (0, 0), "{what}");
            assert_eq!(checker.violations(), 0, "{what}: {:?}", checker.first());
        }
    }
}

#[test]
fn networks_of_every_canopen_rate_come_up() {
    for bitrate in [1_000_000, 800_000, 500_000, 125_000, 50_000, 20_000] {
        let plant = Plant { nodes: 6, bitrate, mix: Mix::Any, seed: 7 };
        let outcome = plant.run(Span::from_s(120));
        assert!(outcome.all_operational.is_some(), "{plant:?} {outcome:?}");
        assert_eq!((outcome.broken_silence, outcome.wrong_joins), (0, 0), "{plant:?}");
    }
}

/// Twenty minutes of a day: power lost at any moment, also while writing; the rate changes; shorts.
#[test]
fn nobody_is_lost_in_a_plant() {
    let mut memories: Vec<Memory> = Vec::new();
    for seed in 100..102 {
        let shift = Shift { nodes: 8, seed, span: Span::from_s(600), pause: Span::from_s(8) };
        let report = shift.run(&mut memories);
        let what = format!("examples/day 10 8 {seed}: {report:?}");
        assert!(report.power_cycles > 20 && report.rate_changes > 3, "{what}");
        assert_eq!((report.lost, report.broken_silence, report.wrong_joins), (0, 0, 0), "{what}");
    }
}

/// A manager at 500 kbit/s and one device.
fn pair(device: DeviceConfig) -> (Network, usize) {
    let mut network = Network::new(5);
    let manager = DeviceConfig::mini_master(1, 500_000, Span::from_ms(20));
    let manager = network.add(manager).unwrap();
    let place = network.add(device).unwrap();
    network.power_on(manager);
    (network, place)
}

fn leds(network: &Network, place: usize) -> Leds {
    network.device(place).software().unwrap().leds()
}

/// CiA 303-3 along the way: both flickering, then pre-operational or operational, on at bus-off.
#[test]
fn leds_say_where_a_node_is() {
    let (mut network, place) = pair(DeviceConfig::automatic(2));
    network.power_off(0);
    network.power_on(place);
    network.run_for(Span::from_ms(50));
    let searching = Leds { run: Pattern::Flickering, error: Pattern::Flickering };
    assert_eq!(leds(&network, place), searching);
    network.power_on(0);
    network.run_for(Span::from_ms(300));
    assert_eq!(leds(&network, place), Leds { run: Pattern::On, error: Pattern::Off });
    // The manager keeps its rate: it shows bus-off while it waits.
    let now = network.sim().now();
    network.sim_mut().recessive_at(now, Span::from_ms(30));
    let at_bus_off = |network: &Network| leds(network, 0).error == Pattern::On;
    assert!(network.run_while(Span::from_ms(60), &mut canbaud_sim::Blind, at_bus_off));
}

/// The rate that was right is remembered and tried first: a device without a timer is in with the
/// next two frames, without a round through all rates.
#[test]
fn the_last_good_rate_is_tried_first() {
    let listener = Listener::Monitoring(canbaud::detect::scan::Evidence::FramesOnly);
    let (mut network, place) = pair(DeviceConfig::automatic(2).with(listener, None));
    // Somebody who acknowledges, so that the manager's messages go on.
    let other = network.add(DeviceConfig::automatic(3)).unwrap();
    network.power_on(other);
    let mut times = Vec::new();
    for _ in 0..2 {
        network.run_for(Span::from_ms(200));
        let begin = network.sim().now();
        network.power_on(place);
        let up = |network: &Network| network.device(place).is_operational();
        assert!(network.run_while(Span::from_s(30), &mut canbaud_sim::Blind, up));
        times.push(network.sim().now().since(begin));
        network.power_off(place);
    }
    assert!(times[1] < Span::from_ms(100), "{times:?}");
    assert!(times[1].femtoseconds() * 3 < times[0].femtoseconds(), "{times:?}");
}

/// A steady network does not wear the memory out.
#[test]
fn a_rate_is_written_once() {
    let (mut network, place) = pair(DeviceConfig::automatic(2));
    for _ in 0..20 {
        network.power_on(place);
        network.run_for(Span::from_ms(200));
        assert!(network.device(place).is_operational());
        network.power_off(place);
    }
    assert_eq!(network.device_mut(place).memory().writes(), 1);
}

/// The network changes its rate while the device is in operation.
#[test]
fn a_node_follows_a_change_of_rate_without_a_person() {
    for (listener, timer) in [
        (Listener::Monitoring(canbaud::detect::scan::Evidence::Errors), Some(8_000_000)),
        (Listener::Monitoring(canbaud::detect::scan::Evidence::Errors), None),
        (Listener::None, Some(8_000_000)),
    ] {
        let (mut network, place) = pair(DeviceConfig::automatic(2).with(listener, timer));
        network.power_on(place);
        network.run_for(Span::from_s(1));
        for rate in [125_000, 1_000_000, 50_000] {
            network.power_off(0);
            network.run_for(Span::from_ms(700));
            network.device_mut(0).settings().rate = RateSetting::Fixed(Bitrate::new(rate).unwrap());
            network.power_on(0);
            let all = |network: &Network| network.devices().iter().all(|d| d.is_operational());
            assert!(network.run_while(Span::from_s(20), &mut canbaud_sim::Blind, all), "{rate}");
            let joined = network.device(place).joined().last().unwrap();
            assert_eq!(joined.bitrate.bits_per_second(), rate);
            network.run_for(Span::from_s(1));
        }
        assert_eq!(network.tally().broken_silence, 0);
    }
}

/// K9, K2: two devices that are alone, with different memories, both breaking the silence: they
/// agree in the end, whoever began.
#[test]
fn two_who_break_the_silence_at_different_rates_agree() {
    for seed in 0..8 {
        let mut network = Network::new(seed);
        for (id, rate) in [(2, 500_000), (3, 125_000)] {
            let mut config = DeviceConfig::automatic(id);
            config.settings.silence = Silence::Break {
                default: Bitrate::new(rate).unwrap(),
                after: Micros::from_ms(500),
                // So short that both often begin at once.
                spread: Micros::from_ms(1),
                hold: Micros::from_ms(500),
            };
            config.settings.seed = seed * 10 + u64::from(id);
            let place = network.add(config).unwrap();
            network.power_on(place);
        }
        let agreed = |network: &Network| {
            let rates: Vec<_> = network
                .devices()
                .iter()
                .map(|device| match device.software().unwrap().stage() {
                    Stage::TakingPart { bitrate, nmt: Some(_) } => Some(bitrate),
                    _ => None,
                })
                .collect();
            rates[0].is_some() && rates[0] == rates[1]
        };
        let done = network.run_while(Span::from_s(120), &mut canbaud_sim::Blind, agreed);
        assert!(done, "seed {seed}");
        assert_eq!(network.tally().broken_silence, 0);
    }
}

/// A bus at a rate that the device does not have: it stays silent and shows it.
#[test]
fn a_rate_that_the_device_does_not_have_is_shown_and_not_guessed() {
    let mut network = Network::new(1);
    for name in ["a", "b"] {
        let config = canbaud_sim::NodeConfig::at(name, 400_000).unwrap();
        let id = network.add_plain(config).unwrap();
        for n in 0..100 {
            let id_ = canbaud::wire::Id::Base(0x100 + id.0 as u16);
            let frame = canbaud::wire::Frame::new(id_, canbaud::wire::FrameKind::Data, 2, &[n, 1]);
            let at = Time::ZERO + Span::from_us(3_000 * u64::from(n) + 700 * id.0 as u64);
            network.sim_mut().send_at(at, id, frame.unwrap());
        }
    }
    let place = network.add(DeviceConfig::automatic(2)).unwrap();
    network.power_on(place);
    network.run_for(Span::from_ms(400));
    assert!(network.device(place).joined().is_empty());
    assert_eq!(leds(&network, place).error, Pattern::Blinking);
    assert_eq!((network.tally().broken_silence, network.tally().errors), (0, 0));
}
