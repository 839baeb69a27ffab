//! LSS devices on a bit-accurate bus: a master configures them and goes along with their bit rate.

use canbaud::lss::{
    Activation, ActivationAction, Exchange, ExchangeAction, Fastscan, FastscanAction,
    FastscanOptions, LssAddress, LssState, NodeId as CanopenId, Pace, RateSetting, Reply, Service,
    ServiceError,
};
use canbaud::units::{Bitrate, Micros, Permille};
use canbaud::wire::{Frame, Id};
use canbaud_sim::check::Checker;
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::{BitTiming, Event, NodeConfig, NodeId, Span, Time};

const NETWORK: &str = include_str!("../../../examples/lss/network.toml");
const DRIVE: LssAddress = LssAddress::new(0x29C, 1, 0x1_0002, 4711);
const ENCODER: LssAddress = LssAddress::new(0x29C, 7, 0x2_0000, 815);
const VALVE: LssAddress = LssAddress::new(0x5B, 0x1234, 3, 99);

/// The node "master" with the procedures of canbaud as its software.
struct Bench {
    run: Run,
    node: NodeId,
    config: NodeConfig,
    checker: Checker,
    heard: Vec<(Time, Frame)>,
}

impl Bench {
    fn new() -> Self {
        let scenario = Scenario::parse("network.toml", NETWORK).unwrap();
        let (node, config) = scenario.node("master").unwrap();
        let config = config.clone();
        let mut run = Run::new(&scenario, 7).unwrap();
        run.hold_news(node);
        let checker = Checker::new(run.sim());
        Self { run, node, config, checker, heard: Vec::new() }
    }

    fn now(&self) -> Micros {
        Micros(self.run.sim().now().femtoseconds() / 1_000_000_000)
    }

    fn send(&mut self, frame: &Frame) {
        let now = self.run.sim().now();
        self.run.sim_mut().send_at(now, self.node, *frame);
    }

    /// Lets the bus run until `deadline`, or until the master has received something.
    fn wait(&mut self, deadline: Micros) -> Option<Frame> {
        let until = Time::from_fs(deadline.0 * 1_000_000_000);
        while self.run.sim().now() < until {
            let slice = (self.run.sim().now() + Span::from_us(100)).min(until);
            self.run.advance(slice, &mut self.checker);
            let mut received = None;
            for (at, _, event) in self.run.take_held_news() {
                if let Event::Received { frame } = event {
                    self.heard.push((at, frame));
                    received = Some(frame);
                }
            }
            if received.is_some() {
                return received;
            }
        }
        None
    }

    fn exchange(&mut self, service: Service) -> Result<Reply, ServiceError> {
        let mut exchange = Exchange::new(service, Pace::default(), self.now());
        loop {
            while let Some(action) = exchange.poll(self.now()) {
                match action {
                    ExchangeAction::Send(frame) => self.send(&frame),
                    ExchangeAction::Done(result) => return result,
                }
            }
            if let Some(frame) = self.wait(exchange.deadline()) {
                exchange.handle(self.now(), &frame);
            }
        }
    }

    fn fastscan(&mut self) -> Option<LssAddress> {
        let mut scan = Fastscan::new(FastscanOptions::default(), self.now());
        loop {
            while let Some(action) = scan.poll(self.now()) {
                match action {
                    FastscanAction::Send(frame) => self.send(&frame),
                    FastscanAction::Done(result) => return result.unwrap().map(|f| f.address),
                }
            }
            if let Some(frame) = self.wait(scan.deadline()) {
                scan.handle(self.now(), &frame);
            }
        }
    }

    fn activate(&mut self, delay_ms: u16, own: Option<u32>) {
        let mut activation = Activation::new(delay_ms);
        loop {
            while let Some(action) = activation.poll(self.now()) {
                match (action, own) {
                    (ActivationAction::Send(frame), _) => self.send(&frame),
                    (ActivationAction::SwitchBitRate { .. }, Some(rate)) => self.go_to(rate),
                    (ActivationAction::SwitchBitRate { .. }, None) => {}
                    (ActivationAction::Done, _) => return,
                }
            }
            assert_eq!(self.wait(activation.deadline()), None, "somebody sent in the silence");
        }
    }

    fn go_to(&mut self, rate: u32) {
        let point = Permille::new(875).unwrap();
        let nominal = BitTiming::find(self.config.oscillator.hertz, rate, point).unwrap();
        self.config.nominal = nominal;
        let (now, node, config) = (self.run.sim().now(), self.node, self.config.clone());
        self.run.sim_mut().reconfigure_at(now, node, config).unwrap();
    }

    /// All three devices have the bit rate as pending, the two new ones node-IDs 20 and 21.
    fn configure(&mut self, setting: RateSetting, for_valve: RateSetting) {
        for address in [DRIVE, ENCODER, VALVE] {
            assert_eq!(self.exchange(Service::SwitchStateSelective(address)), Ok(Reply::Done));
            let setting = if address == VALVE { for_valve } else { setting };
            let service = Service::configure_rate(setting).unwrap();
            assert_eq!(self.exchange(service), Ok(Reply::Done), "{address}");
            self.exchange(Service::StoreConfiguration).unwrap();
            self.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
        }
    }

    fn boot_ups(&self) -> Vec<u32> {
        let ids = self.heard.iter().map(|(_, frame)| frame.id());
        ids.filter(|id| matches!(id, Id::Base(0x701..=0x77F))).map(|id| id.raw() - 0x700).collect()
    }

    /// No law of the bus was broken, and nobody saw an error.
    fn assert_clean(&self) {
        assert_eq!(self.checker.violations(), 0, "{:?}", self.checker.first());
        for (name, node) in
            ["drive", "encoder", "valve"].iter().zip(&self.run.statistics().nodes[1..])
        {
            assert_eq!((node.errors, node.tec_max), (0, 0), "{name}");
        }
        assert_eq!(self.run.statistics().nodes[0].errors, 0);
    }
}

fn fixed(rate: u32) -> RateSetting {
    RateSetting::Fixed(Bitrate::new(rate).unwrap())
}

#[test]
fn devices_on_a_bus_with_bits_are_found_and_boot_up() {
    let mut bench = Bench::new();
    let mut found = Vec::new();
    for id in [20, 21] {
        found.push(bench.fastscan().unwrap());
        let node_id = CanopenId::new(id).unwrap();
        bench.exchange(Service::ConfigureNodeId(node_id)).unwrap();
        bench.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
        bench.wait(bench.now() + Micros::from_ms(20));
    }
    found.sort();
    assert_eq!(found, [DRIVE, ENCODER]);
    assert_eq!(bench.fastscan(), None);
    assert_eq!(bench.boot_ups(), [20, 21]);
    bench.assert_clean();
}

#[test]
fn a_network_changes_its_bit_rate_without_one_error_frame() {
    for rate in [1_000_000, 800_000, 500_000, 125_000, 50_000, 20_000, 10_000] {
        let mut bench = Bench::new();
        bench.configure(fixed(rate), fixed(rate));
        bench.exchange(Service::SwitchStateGlobal(LssState::Configuration)).unwrap();
        bench.activate(100, Some(rate));
        bench.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
        for address in [DRIVE, ENCODER, VALVE] {
            let selected = bench.exchange(Service::SwitchStateSelective(address));
            assert_eq!(selected, Ok(Reply::Done), "{address} at {rate}");
            bench.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
        }
        for device in bench.run.lss_devices() {
            assert_eq!(device.stored().rate, fixed(rate));
        }
        bench.assert_clean();
    }
}

#[test]
fn index_9_finds_the_bit_rate_that_the_master_goes_to_without_one_dominant_bit() {
    for rate in [1_000_000, 500_000, 125_000, 20_000] {
        let mut bench = Bench::new();
        // The valve is a mini-master and must not detect.
        bench.exchange(Service::SwitchStateSelective(VALVE)).unwrap();
        let automatic = Service::configure_rate(RateSetting::Automatic).unwrap();
        assert!(matches!(bench.exchange(automatic), Err(ServiceError::Refused(_))));
        bench.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
        bench.configure(RateSetting::Automatic, fixed(rate));
        bench.exchange(Service::SwitchStateGlobal(LssState::Configuration)).unwrap();
        bench.activate(100, Some(rate));
        let dominant =
            |bench: &Bench, place: usize| bench.run.statistics().nodes[place + 1].dominant;
        let before = [0, 1].map(|place| dominant(&bench, place));
        // The master's messages, acknowledged by the valve, are what they find it by; each of the
        // eight rates may cost a message.
        for _ in 0..10 {
            bench.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
            for (place, before) in before.into_iter().enumerate() {
                if !bench.run.lss_devices()[place].slave().may_send() {
                    assert_eq!(dominant(&bench, place), before, "device {place} at {rate}");
                }
            }
            bench.wait(bench.now() + Micros::from_ms(20));
        }
        for address in [DRIVE, ENCODER] {
            let selected = bench.exchange(Service::SwitchStateSelective(address));
            assert_eq!(selected, Ok(Reply::Done), "{address} at {rate}");
            bench.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
        }
        let [_, _, _, valve] = &bench.run.statistics().nodes[..] else { panic!("four nodes") };
        assert_eq!((valve.errors, valve.tec_max), (0, 0), "an error frame was caused");
        assert_eq!(bench.run.statistics().nodes[0].errors, 0);
        assert_eq!(bench.checker.violations(), 0, "{:?}", bench.checker.first());
    }
}
