//! The seam for software from outside: what it is told, and that it is watched.

use canbaud::units::Bitrate;
use canbaud::wire::{Frame, FrameKind, Id, Level};
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::software::{AutonomousPlan, Listening, Software, Stage, Standing, Supplier};
use canbaud_sim::{Blind, ClockError, Event, Mode, NodeConfig, NodeId, Simulation, Span, Time};

/// Says that it listens, and sends.
#[derive(Debug)]
struct Liar {
    node: NodeId,
    config: NodeConfig,
    powered: bool,
    edges: u64,
    received: u64,
    next: Time,
}

impl Software for Liar {
    fn power_on(&mut self, sim: &mut Simulation) {
        self.powered = true;
        let config = NodeConfig { mode: Mode::Normal, ..self.config.clone() };
        sim.reconfigure_at(sim.now(), self.node, config).unwrap();
        self.next = sim.now() + Span::from_ms(20);
    }

    fn power_off(&mut self, sim: &mut Simulation) {
        self.powered = false;
        self.next = Time::NEVER;
        sim.reconfigure_at(sim.now(), self.node, self.config.clone()).unwrap();
    }

    fn notice(&mut self, _: Time, event: &Event, _: &mut Simulation) {
        self.received += u64::from(matches!(event, Event::Received { .. }));
    }

    fn follows_edges(&self) -> bool {
        self.powered
    }

    fn edge(&mut self, _: Time, _: Level) {
        self.edges += 1;
    }

    fn deadline(&self) -> Time {
        self.next
    }

    fn wake(&mut self, sim: &mut Simulation) {
        if self.next <= sim.now() {
            self.next += Span::from_ms(20);
            let frame = Frame::new(Id::Base(0x55), FrameKind::Data, 1, &[7]).unwrap();
            sim.send_at(sim.now(), self.node, frame);
        }
    }

    fn take_told(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn standing(&self) -> Standing {
        // What it was told is read back by the rate that it claims.
        let rate = Bitrate::new(1_000 * self.received as u32 + self.edges as u32);
        let stage = if self.powered { Stage::Detecting } else { Stage::Off };
        Standing { stage, takes_part: rate.map(|rate| (rate, Time::ZERO)) }
    }
}

struct Liars;

impl Supplier for Liars {
    fn software(
        &self,
        plan: &AutonomousPlan,
        node: NodeId,
        config: &NodeConfig,
        seed: u64,
    ) -> Result<Box<dyn Software>, ClockError> {
        assert_eq!((plan.listening, plan.timer_hz), (Listening::Counter, Some(2_000_000)));
        assert_eq!((config.mode, config.name.as_str()), (Mode::Disabled, "liar"));
        assert_ne!(seed, 0);
        let (config, next) = (config.clone(), Time::NEVER);
        Ok(Box::new(Liar { node, config, powered: false, edges: 0, received: 0, next }))
    }
}

const SCENARIO: &str = "
title = 'a liar'
duration = '100ms'
[[node]]
name = 'a'
bitrate = '10k'
[[node]]
name = 'liar'
autonomous = { listener = 'counter', timer = '2M' }
joins = '20ms'
[[traffic]]
node = 'a'
kind = 'periodic'
period = '10ms'
id = 0x123
dlc = 0
[[change]]
at = '60ms'
node = 'liar'
power = 'off'
[[expect]]
node = 'liar'
broken_silence_max = 0
stage = 'off'
";

/// Software is not believed: each dominant level while it says that it listens is counted.
#[test]
fn broken_silence_is_noticed_whatever_the_software_says() {
    let scenario = Scenario::parse("liar.toml", SCENARIO).unwrap();
    let mut run = Run::with(&scenario, 1, &Liars).unwrap();
    run.finish(&mut Blind);
    let liar = &run.statistics().nodes[1];
    assert_eq!(liar.broken_silence, liar.dominant);
    assert!(liar.broken_silence > 5, "{liar:?}");
    let misses: Vec<_> = run.misses().iter().map(ToString::to_string).collect();
    assert_eq!(misses.len(), 1, "{misses:?}");
    assert!(misses[0].contains("broken silence"), "{misses:?}");
    // Power came at 20 ms and went at 60 ms: the edges and the frames between, and those that
    // had waited for an acknowledgement, were handed over.
    let claimed = liar.found_bitrate.unwrap();
    assert!((2..=7).contains(&(claimed / 1_000)), "{claimed}");
    assert!(claimed % 1_000 > 30, "{claimed}");
    assert_eq!(liar.stage.as_deref(), Some("off"));
}
