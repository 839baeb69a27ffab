//! Scenarios with nodes that find their own way: those of the library, and what a run promises.

use std::path::Path;

use canbaud_lab::Autonomous;
use canbaud_sim::check::Checker;
use canbaud_sim::scenario::{Run, Scenario, Timeline};
use canbaud_sim::{Blind, Event, NodeId, Observer, Time};

fn library(name: &str) -> Scenario {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../canbaud-sim/scenarios");
    Scenario::read(&directory.join(name)).unwrap()
}

/// Each with its own seed and others, every bit checked.
#[test]
fn scenarios_of_the_library_meet_their_expectations() {
    for (name, seeds) in [
        ("canopen-network.toml", 3),
        ("canopen-silent-start.toml", 10),
        ("canopen-wrong-rate.toml", 4),
    ] {
        let scenario = library(name);
        assert!(scenario.needs_software());
        for seed in scenario.seed..scenario.seed + seeds {
            let mut run = Run::with(&scenario, seed, &Autonomous).unwrap();
            let mut checker = Checker::new(run.sim());
            run.finish(&mut checker);
            assert_eq!(run.misses(), [], "{name} --seed {seed}");
            assert_eq!(checker.violations(), 0, "{name} --seed {seed}: {:?}", checker.first());
        }
    }
}

#[test]
fn a_seed_repeats_a_run_and_another_does_not() {
    let scenario = library("canopen-network.toml");
    let run = |seed| {
        let mut run = Run::with(&scenario, seed, &Autonomous).unwrap();
        run.advance(Time::ZERO + canbaud_sim::Span::from_ms(700), &mut Blind);
        run.finish(&mut Blind);
        let mut statistics = run.statistics().clone();
        statistics.seed = 0;
        statistics
    };
    assert_eq!(run(4), run(4));
    assert_ne!(run(4), run(5));
}

fn timeline(scenario: &Scenario) -> String {
    let mut run = Run::with(scenario, scenario.seed, &Autonomous).unwrap();
    let mut timeline = Timeline::new(Vec::new(), scenario.node_names());
    run.finish(&mut timeline);
    String::from_utf8(timeline.finish().unwrap()).unwrap()
}

/// What a person reads of a node: power, stages with LEDs, rates, boot-up, and nothing of others'
/// frames.
#[test]
fn the_timeline_tells_the_way_of_a_node_in_words() {
    let text = timeline(&library("canopen-wrong-rate.toml"));
    let valve: Vec<_> = text.lines().filter(|line| line.contains(" valve ")).collect();
    let mut lines = valve.iter();
    for part in [
        "power on: stored rate 125k, remembers nothing",
        "takes part at 125kbit/s (RUN off, ERROR off)",
        "sends its boot-up message 703",
        "error as",
        "detects: listens, drives nothing (RUN flickering, ERROR flickering)",
        "listens at 500kbit/s",
        "takes part at 500kbit/s (RUN off, ERROR off)",
        "sends its boot-up message 703",
        "pre-operational (RUN blinking, ERROR off)",
        "operational (RUN on, ERROR off)",
        "is bus-off",
        "bus-off: waits for 128 times 11 recessive bits (RUN off, ERROR on)",
        "operational (RUN on, ERROR off)",
    ] {
        assert!(lines.any(|line| line.contains(part)), "no {part:?} in\n{}", valve.join("\n"));
    }
    assert!(text.contains("drive    power off"), "{text}");
    assert!(!text.contains("received"), "{text}");
    assert!(text.contains("times more"), "repetitions are counted\n{text}");
}

/// Counts dominant levels of a node.
struct Drives(NodeId, u64);

impl Observer for Drives {
    fn txd(&mut self, _: Time, node: NodeId, level: canbaud::wire::Level) {
        self.1 += u64::from(node == self.0 && level == canbaud::wire::Level::Dominant);
    }

    fn event(&mut self, _: Time, _: NodeId, _: &Event) {}
}

const RATE_ABROAD: &str = "
title = 'a bus at a rate that is none of CANopen'
duration = '2s'
[[node]]
name = 'a'
bitrate = '200k'
[[node]]
name = 'b'
bitrate = '200k'
[[traffic]]
node = 'a'
kind = 'periodic'
period = '2ms'
id = 0x123
dlc = 8
[[node]]
name = 'guest'
autonomous = { node_id = 9, timer = '8M' }
[[expect]]
node = 'guest'
stage = 'operational'
[[expect]]
node = 'guest'
found = '250k'
";

/// Expectations of an autonomous node can fail, and a node abroad drives nothing.
#[test]
fn a_missed_stage_is_named_and_a_foreign_rate_is_never_joined() {
    let scenario = Scenario::parse("abroad.toml", RATE_ABROAD).unwrap();
    let mut run = Run::with(&scenario, 1, &Autonomous).unwrap();
    let mut drives = Drives(scenario.node("guest").unwrap().0, 0);
    run.finish(&mut drives);
    let misses: Vec<_> = run.misses().iter().map(ToString::to_string).collect();
    assert_eq!(
        misses,
        [
            "line 19: guest: ends detecting, expected operational",
            "line 22: guest: found None, expected Some(250000)",
        ]
    );
    assert_eq!(drives.1, 0);
    assert!(timeline(&scenario).contains("LEDs: RUN flickering, ERROR blinking"));
    // What it hears while it listens is no trouble of its own.
    assert!(!timeline(&scenario).contains("flag"));
}

/// An LSS master written as traffic: `right` sends these bytes on these identifiers.
fn with_a_master(duration: &str, commands: &[(&str, u32, &str)], rest: &str) -> Scenario {
    let mut text = format!(
        "title = 'an LSS master as traffic'\nduration = '{duration}'\n\
         [[node]]\nname = 'right'\nbitrate = '250k'\n\
         [[node]]\nname = 'manager'\nbitrate = '250k'\n\
         autonomous = {{ node_id = 1, start_up = 'mini-master', sync = '5ms' }}\n\
         [[node]]\nname = 'drive'\n\
         autonomous = {{ node_id = 5, timer = '8M', pdo = '3ms', heartbeat = '10ms' }}\n\
         lss = {{ vendor_id = 1, product_code = 2, revision_number = 3, serial_number = 4 }}\n"
    );
    for (at, id, data) in commands {
        let dlc = data.split(' ').count();
        text.push_str(&format!(
            "[[traffic]]\nnode = 'right'\nkind = 'single'\nstart = '{at}'\nid = {id}\ndlc = {dlc}\n\
             payload = 'hex:{data}'\n"
        ));
    }
    Scenario::parse("master.toml", &(text + rest)).unwrap()
}

const LSS: u32 = 0x7E5;
const CONFIGURATION: &str = "04 01 00 00 00 00 00 00";
const WAITING: &str = "04 00 00 00 00 00 00 00";

/// When a node sent a frame of an identifier below 7E4h.
struct Sent(NodeId, Vec<Time>);

impl Observer for Sent {
    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        if let Event::TransmissionStarted { frame, .. } = event
            && node == self.0
            && frame.id().raw() < 0x7E4
        {
            self.1.push(at);
        }
    }
}

/// CiA 305: between "activate" and the end of the second period nothing is sent, neither what the
/// node nor what its application has to say.
#[test]
fn an_activation_is_silent_for_both_periods() {
    let scenario = with_a_master(
        "1s",
        &[("300ms", LSS, CONFIGURATION), ("310ms", LSS, "15 64 00 00 00 00 00 00")],
        "",
    );
    let mut run = Run::with(&scenario, 1, &Autonomous).unwrap();
    let mut sent = Sent(scenario.node("drive").unwrap().0, Vec::new());
    run.finish(&mut sent);
    let within =
        |from: f64, to: f64| sent.1.iter().filter(|at| (from..to).contains(&at.seconds())).count();
    assert!(within(0.200, 0.309) > 30, "it talks before");
    // A frame that had begun is let go; the command takes half a millisecond on the wire.
    assert_eq!(within(0.312, 0.510), 0, "it talks in the silence");
    assert!(within(0.515, 0.700) > 30, "it talks behind");
    assert_eq!(run.statistics().nodes[2].broken_silence, 0);
}

/// What LSS has stored is there after a loss of power; what was only pending is not.
#[test]
fn a_stored_configuration_outlasts_a_loss_of_power() {
    let power = "[[change]]\nat = '400ms'\nnode = 'drive'\npower = 'off'\n\
                 [[change]]\nat = '450ms'\nnode = 'drive'\npower = 'on'\n";
    let rate = ("310ms", LSS, "13 00 03 00 00 00 00 00");
    let node_id = ("320ms", LSS, "11 2A 00 00 00 00 00 00");
    let store = ("330ms", LSS, "17 00 00 00 00 00 00 00");
    for (commands, stored, boot) in [
        (&[("300ms", LSS, CONFIGURATION), rate, node_id, store][..], "250k", "72A"),
        (&[("300ms", LSS, CONFIGURATION), rate, node_id], "automatic", "705"),
    ] {
        let text = timeline(&with_a_master("1s", commands, power));
        let (_, behind) = text.split_once("drive    power off").expect(&text);
        assert!(behind.contains(&format!("power on: stored rate {stored},")), "{behind}");
        assert!(behind.contains(&format!("drive    sends its boot-up message {boot}")), "{behind}");
        assert!(behind.contains("drive    operational"), "{behind}");
    }
}

/// CiA 305: a pending node-ID becomes active at the NMT state reset communication, and only there.
#[test]
fn a_pending_node_id_becomes_active_at_reset_communication() {
    let commands = [
        ("300ms", LSS, CONFIGURATION),
        ("310ms", LSS, "11 2A 00 00 00 00 00 00"),
        ("320ms", LSS, WAITING),
        ("400ms", 0, "82 05"),
    ];
    let text = timeline(&with_a_master("600ms", &commands, ""));
    let (before, behind) = text.split_once("LSS: node-ID 42 is pending").expect(&text);
    assert!(before.contains("sends its boot-up message 705"), "{before}");
    let (_, at) = behind.split_once("drive    sends its boot-up message 72A").expect(behind);
    assert!(at.contains("drive    operational"), "{at}");
    let line = text.lines().find(|line| line.contains("boot-up message 72A")).unwrap();
    assert!(line.starts_with("0.40"), "{line}");
}
