//! A device: controller, timer and memory of the simulator, with [`canbaud::node::Node`] inside.

use canbaud::detect::scan::{
    Candidate, Capabilities, Configured, ErrorClass, ErrorPlace, ErrorSeen, Evidence, FdSupport,
    FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::fault;
use canbaud::lss::{
    Automatic, Configuration, LssAddress, NodeId, RateSet, RateSetting, Slave, SlaveAction,
    SlaveOptions,
};
use canbaud::node::{
    Action, Input, Means, NmtState, Node, Sending, Settings, Stage, Startup, load, save,
};
use canbaud::timing::default_sample_point;
use canbaud::units::{Bitrate, Hertz, Micros, Permille, Timebase};
use canbaud::wire::{Frame, Level, Logic};
use canbaud_sim::around::CaptureTimer;
use canbaud_sim::{
    BitTiming, ErrorKind, Event, FaultState, Gate, Mode, MonitoringCounters, NodeConfig, Place,
    Recovery, Simulation, Span, Time,
};

use crate::memory::Memory;

/// How a device can listen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listener {
    /// Its controller has bus monitoring, and says so much.
    Monitoring(Evidence),
    /// Its controller has none, but the gate circuit of Koppe stands before it.
    Gate,
    /// Its controller can only take part or be off; the timer has to do.
    None,
}

/// What a device is made of, and how it is set.
#[derive(Debug, Clone)]
pub struct DeviceConfig {
    /// For people.
    pub name: String,
    /// Its node-ID.
    pub node_id: NodeId,
    /// Frequency of its controller's clock.
    pub clock_hz: u64,
    /// How much faster its clocks run.
    pub ppb: i64,
    /// The capture timer, if it has one.
    pub timer_hz: Option<u64>,
    /// How its controller listens.
    pub listener: Listener,
    /// T_cc: off, new timing, on again.
    pub reconfiguration: Span,
    /// How it is set; [`Settings::means`] is made from what stands above.
    pub settings: Settings,
    /// Time between two process data objects while it is operational.
    pub pdo: Option<Span>,
    /// Time between two SYNC messages, if it is their producer.
    pub sync: Option<Span>,
    /// Its LSS address, if it is an LSS slave.
    pub lss: Option<LssAddress>,
}

/// The lowest and the highest rate of CANopen.
const RANGE: (u32, u32) = (10_000, 1_000_000);

impl DeviceConfig {
    /// A device with everything: bus monitoring that reports errors, an 8 MHz timer, and automatic
    /// detection.
    #[must_use]
    pub fn automatic(id: u8) -> Self {
        let node_id = NodeId::new(id).unwrap_or(NodeId::UNCONFIGURED);
        let mut config = Self {
            name: format!("node-{id}"),
            node_id,
            clock_hz: 16_000_000,
            ppb: 0,
            timer_hz: Some(8_000_000),
            listener: Listener::Monitoring(Evidence::Errors),
            reconfiguration: Span::from_us(100),
            settings: Settings::automatic(
                node_id,
                Means::Timer(Timebase::from_frequency(hertz(8_000_000))),
            ),
            pdo: None,
            sync: None,
            lss: None,
        };
        config.settings.means = config.means();
        config
    }

    /// The device that knows its rate, starts the others, and sends SYNC.
    #[must_use]
    pub fn mini_master(id: u8, bitrate: u32, sync: Span) -> Self {
        let mut config = Self::automatic(id);
        config.name = "manager".into();
        config.settings.startup = canbaud::node::Startup::MiniMaster;
        config.settings.rate = fixed(bitrate);
        config.sync = Some(sync);
        config
    }

    /// The same device with its rate set by hand.
    #[must_use]
    pub fn fixed(mut self, bitrate: u32) -> Self {
        self.settings.rate = fixed(bitrate);
        self
    }

    /// The same device as an LSS slave.
    #[must_use]
    pub const fn with_lss(mut self, address: LssAddress) -> Self {
        self.lss = Some(address);
        self
    }

    /// The same device with another way to listen and another timer.
    #[must_use]
    pub fn with(mut self, listener: Listener, timer_hz: Option<u64>) -> Self {
        (self.listener, self.timer_hz) = (listener, timer_hz);
        self.settings.means = self.means();
        self
    }

    /// The means that timer and listener make.
    fn means(&self) -> Means {
        let timebase = self.timer_hz.map(|hz| Timebase::from_frequency(hertz(hz)));
        let evidence = match self.listener {
            Listener::Monitoring(evidence) => evidence,
            Listener::Gate | Listener::None => Evidence::Errors,
        };
        let rate = |bits| Bitrate::new(bits).unwrap_or(Settings::CANOPEN_RATES[0]);
        match (timebase, self.listener) {
            (Some(timebase), Listener::None) => Means::Timer(timebase),
            (Some(timebase), _) => Means::Both(timebase),
            (None, _) => Means::Controller(Capabilities {
                rates: RateChoice::Between(rate(RANGE.0), rate(RANGE.1)),
                evidence,
                fd: FdSupport::Classic,
                reconfiguration: Micros(self.reconfiguration.femtoseconds() / FS_PER_US),
                latency: Micros(0),
            }),
        }
    }
}

fn fixed(bitrate: u32) -> RateSetting {
    Bitrate::new(bitrate).map_or(RateSetting::Automatic, RateSetting::Fixed)
}

fn hertz(hz: u64) -> Hertz {
    Hertz::new(hz).unwrap_or(Hertz::MAX)
}

const FS_PER_US: u64 = 1_000_000_000;

/// Whole microseconds since the start.
pub(crate) const fn micros(time: Time) -> Micros {
    Micros(time.femtoseconds() / FS_PER_US)
}

/// That many microseconds after the start.
pub(crate) const fn time(micros: Micros) -> Time {
    Time::from_fs(micros.0.saturating_mul(FS_PER_US))
}

/// Who else took part at a rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Company {
    /// Nobody: it was the first, or its rate is wrong.
    Nobody,
    /// Somebody.
    Somebody,
}

/// A device began to take part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Joined {
    /// When it decided to.
    pub at: Time,
    /// At which rate.
    pub bitrate: Bitrate,
    /// Who else took part at it.
    pub company: Company,
}

/// A device on a simulated bus.
#[derive(Debug)]
pub struct Device {
    config: DeviceConfig,
    id: canbaud_sim::NodeId,
    software: Option<Node>,
    timer: Option<CaptureTimer>,
    memory: Memory,
    /// The controller will be like this then.
    switching: Option<(Time, NodeConfig, Configured)>,
    /// Sent by [`Action::Send`] and not yet acknowledged.
    under_way: Option<Frame>,
    lss: Option<Slave>,
    stored: StoredConfiguration,
    /// The LSS slave waits for the detection that it has asked for.
    lss_waits: bool,
    next_pdo: Time,
    pdo_pending: bool,
    counter: u8,
    joined: Vec<Joined>,
    line: Level,
}

impl Device {
    /// Puts a device on the bus, switched off.
    ///
    /// # Errors
    /// [`canbaud_sim::ClockError`] if its clock is impossible.
    pub fn new(
        config: DeviceConfig,
        sim: &mut Simulation,
    ) -> Result<Self, canbaud_sim::ClockError> {
        let mut node = blank(&config);
        node.mode = Mode::Disabled;
        let id = sim.add_node(node)?;
        sim.watch(id);
        let timer = match config.timer_hz {
            Some(hz) => Some(CaptureTimer::new(hz, config.ppb, 64, Span::ZERO)?),
            None => None,
        };
        Ok(Self {
            config,
            id,
            software: None,
            timer,
            memory: Memory::new(),
            switching: None,
            under_way: None,
            lss: None,
            stored: StoredConfiguration(None),
            lss_waits: false,
            next_pdo: Time::NEVER,
            pdo_pending: false,
            counter: 0,
            joined: Vec::new(),
            line: Level::Recessive,
        })
    }

    /// Its node on the bus.
    #[must_use]
    pub const fn id(&self) -> canbaud_sim::NodeId {
        self.id
    }

    /// What it is made of.
    #[must_use]
    pub const fn config(&self) -> &DeviceConfig {
        &self.config
    }

    /// Its software, while it has power.
    #[must_use]
    pub const fn software(&self) -> Option<&Node> {
        self.software.as_ref()
    }

    /// Its software, to be told something else than what the network tells it.
    pub const fn software_mut(&mut self) -> Option<&mut Node> {
        self.software.as_mut()
    }

    /// Its memory.
    pub const fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    /// Gives it the memory of another life.
    pub fn insert_memory(&mut self, memory: Memory) {
        self.memory = memory;
    }

    /// How it is set from the next power-on on.
    pub const fn settings(&mut self) -> &mut Settings {
        &mut self.config.settings
    }

    /// Every time that it began to take part.
    #[must_use]
    pub fn joined(&self) -> &[Joined] {
        &self.joined
    }

    /// Whether it is operational.
    #[must_use]
    pub fn is_operational(&self) -> bool {
        self.software.as_ref().is_some_and(|node| {
            matches!(node.stage(), Stage::TakingPart { nmt: Some(NmtState::Operational), .. })
        })
    }

    /// Whether it must not drive the bus.
    #[must_use]
    pub fn must_be_silent(&self) -> bool {
        self.software.as_ref().is_none_or(|node| !matches!(node.stage(), Stage::TakingPart { .. }))
    }

    /// Whether its timer follows the edges now.
    #[must_use]
    pub fn follows_edges(&self) -> bool {
        let detects = |node: &Node| node.stage() == Stage::Detecting;
        self.timer.is_some() && self.software.as_ref().is_some_and(detects)
    }

    /// Power comes.
    pub fn power_on(&mut self, sim: &mut Simulation) {
        self.memory.power_on();
        // A memory that cannot be read remembers nothing.
        let kept = load::<_, 4>(&mut self.memory).unwrap_or_default();
        let remembered = kept.and_then(|bytes| Bitrate::new(u32::from_le_bytes(bytes)));
        let now = micros(sim.now());
        self.software = Node::new(self.config.settings, remembered, now).ok();
        self.lss = self.config.lss.map(|address| slave(address, &self.config.settings));
        self.lss_waits = false;
        self.next_pdo = sim.now();
        self.turn(sim);
    }

    /// Power goes.
    pub fn power_off(&mut self, sim: &mut Simulation) {
        self.software = None;
        self.lss = None;
        self.switching = None;
        self.forget_requests(sim);
        self.set_up(sim, NodeConfig { mode: Mode::Disabled, ..blank(&self.config) });
    }

    fn forget_requests(&mut self, sim: &mut Simulation) {
        sim.abort_requests(self.id);
        self.under_way = None;
        self.pdo_pending = false;
    }

    fn set_up(&self, sim: &mut Simulation, config: NodeConfig) {
        // The oscillator was checked when the device was made.
        let _ = sim.reconfigure_at(sim.now(), self.id, config);
    }

    /// The line changed, as the timer sees it.
    pub fn edge(&mut self, at: Time, level: Level) {
        self.line = level;
        if let (Some(timer), Some(node)) = (&mut self.timer, &mut self.software)
            && let Some(capture) = timer.edge(at, level)
        {
            node.edge(capture.ticks, logic(level));
        }
    }

    /// When it has to be looked at.
    #[must_use]
    pub fn wake(&self) -> Time {
        let Some(node) = &self.software else { return Time::NEVER };
        let deadline = node.deadline().map_or(Time::NEVER, time);
        let switching = self.switching.as_ref().map_or(Time::NEVER, |(at, ..)| *at);
        let lss = self.lss.as_ref().map_or(Time::NEVER, |slave| time(slave.deadline()));
        let pdo = if self.produces() { self.next_pdo } else { Time::NEVER };
        deadline.min(switching).min(pdo).min(lss)
    }

    fn period(&self) -> Option<Span> {
        self.config.sync.or(self.config.pdo)
    }

    fn produces(&self) -> bool {
        self.period().is_some() && !self.pdo_pending && self.is_operational()
    }

    /// Something happened in its controller.
    pub fn notice(&mut self, at: Time, event: &Event, sim: &Simulation) {
        let Some(node) = &mut self.software else { return };
        let now = micros(at);
        let normal = sim.node(self.id).config().mode == Mode::Normal
            && sim.node(self.id).config().gate != Gate::Closed;
        let evidence = match (normal, self.config.listener) {
            (false, Listener::Monitoring(evidence)) => evidence,
            _ => Evidence::Errors,
        };
        let fault = sim.node(self.id).fault();
        match event {
            Event::Received { frame } => {
                let seen = FrameSeen { frame: *frame, origin: Origin::Bus, received: Some(now) };
                node.handle(now, &Input::Heard(Observation::Frame(seen)));
                if let (Some(slave), true) = (&mut self.lss, normal) {
                    slave.handle(now, frame, &mut self.stored);
                }
            }
            Event::Error { kind, place, .. } if evidence == Evidence::Errors => {
                let error =
                    ErrorSeen { class: class(*kind), place: where_at(*place), received: Some(now) };
                node.handle(now, &Input::Heard(Observation::Error(error)));
            }
            Event::Counted { rec, .. } if !normal && evidence == Evidence::Counter => {
                node.handle(now, &Input::Heard(Observation::ReceiveErrors(*rec)));
            }
            Event::Counted { .. } if !normal => {}
            Event::Counted { tec, rec, .. } => {
                let state = fault::State::of(*tec, *rec);
                // Bus-off is told by the controller itself.
                if state != fault::State::BusOff {
                    node.handle(now, &Input::Fault { state, tec: *tec, rec: *rec });
                }
            }
            Event::Fault(state) if normal => {
                let state = match state {
                    FaultState::ErrorActive => fault::State::ErrorActive,
                    FaultState::ErrorPassive => fault::State::ErrorPassive,
                    FaultState::BusOff => fault::State::BusOff,
                };
                node.handle(now, &Input::Fault { state, tec: fault.tec(), rec: fault.rec() });
            }
            Event::Transmitted { frame } if self.under_way.as_ref() == Some(frame) => {
                self.under_way = None;
                node.handle(now, &Input::Sent);
            }
            Event::Transmitted { .. } => self.pdo_pending = false,
            _ => {}
        }
    }

    /// Does what is due.
    pub fn turn(&mut self, sim: &mut Simulation) {
        let now = micros(sim.now());
        if let Some((_, config, configured)) = self.switching.take_if(|(at, ..)| *at <= sim.now()) {
            self.set_up(sim, config);
            if let Some(node) = &mut self.software {
                node.handle(now, &Input::Ready(configured));
            }
        }
        if let (Some(timer), Some(node)) = (&self.timer, &mut self.software)
            && node.stage() == Stage::Detecting
        {
            node.timer(timer.ticks(sim.now()), logic(self.line));
        }
        while let Some(action) = self.software.as_mut().and_then(|node| node.poll(now)) {
            self.act(&action, sim);
        }
        self.turn_lss(sim);
        if self.produces() && self.next_pdo <= sim.now() {
            self.produce(sim);
        }
    }

    /// What the LSS slave wants.
    fn turn_lss(&mut self, sim: &mut Simulation) {
        let now = micros(sim.now());
        if self.lss_waits && !self.must_be_silent() {
            self.lss_waits = false;
            self.lss.as_mut().into_iter().for_each(Slave::rate_found);
        }
        while let Some(action) = self.lss.as_mut().and_then(|slave| slave.poll(now)) {
            let Some(node) = &mut self.software else { return };
            match action {
                SlaveAction::Send(frame) => sim.send_at(sim.now(), self.id, frame),
                SlaveAction::StopSending => node.set_sending(Sending::Forbidden),
                SlaveAction::ResumeSending => node.set_sending(Sending::Allowed),
                SlaveAction::SwitchBitRate(rate) => {
                    // The slave has offered only what can be.
                    let _ = node.set_rate(rate, now);
                    self.lss_waits = rate == RateSetting::Automatic;
                }
                SlaveAction::ResetCommunication(node_id) => {
                    self.config.node_id = node_id;
                    self.lss.as_mut().into_iter().for_each(Slave::reset_communication);
                }
            }
            while let Some(action) = self.software.as_mut().and_then(|node| node.poll(now)) {
                self.act(&action, sim);
            }
        }
    }

    fn act(&mut self, action: &Action, sim: &mut Simulation) {
        match action {
            Action::Stop => {
                self.switching = None;
                self.forget_requests(sim);
                self.set_up(sim, NodeConfig { mode: Mode::Disabled, ..blank(&self.config) });
            }
            Action::Listen(candidate) => self.switch(candidate, Purpose::Listen, sim),
            Action::TakePart(candidate) => {
                let (at, bitrate) = (sim.now(), candidate.nominal);
                let company = self.company(bitrate, sim);
                self.joined.push(Joined { at, bitrate, company });
                self.switch(candidate, Purpose::TakePart, sim);
            }
            Action::Send(frame) => {
                self.under_way = Some(*frame);
                sim.send_at(sim.now(), self.id, *frame);
            }
            Action::Remember(rate) => {
                // Power may go meanwhile: the next power-on finds the old value or the new one.
                let _ = save(&mut self.memory, &rate.bits_per_second().to_le_bytes());
            }
            Action::Reset(_) => {}
        }
    }

    /// Who takes part at `bitrate`, by the controllers' bit timing.
    fn company(&self, bitrate: Bitrate, sim: &Simulation) -> Company {
        let others = sim.nodes().iter().enumerate().filter(|(place, _)| *place != self.id.0);
        let mut others = others.map(|(_, node)| node.config()).filter(|config| config.can_drive());
        let alike = |config: &NodeConfig| {
            let periods = u64::from(config.nominal.prescaler() * config.nominal.quanta());
            let rate = config.oscillator.hertz / periods;
            rate.abs_diff(bitrate.bits_per_second().into()) <= rate / 100
        };
        if others.any(alike) { Company::Somebody } else { Company::Nobody }
    }

    fn switch(&mut self, candidate: &Candidate, purpose: Purpose, sim: &mut Simulation) {
        self.forget_requests(sim);
        let mut config = blank(&self.config);
        self.set_up(sim, NodeConfig { mode: Mode::Disabled, ..config.clone() });
        let rate = candidate.nominal.bits_per_second();
        let point = Permille::new(default_sample_point(candidate.nominal).permille());
        let timing = BitTiming::find(self.config.clock_hz, rate, point.unwrap_or_default());
        let (Ok(timing), Some(mode)) = (timing, mode(self.config.listener, purpose)) else {
            self.switching = None;
            if let Some(node) = &mut self.software {
                node.handle(micros(sim.now()), &Input::Refused);
            }
            return;
        };
        config.nominal = timing;
        (config.mode, config.gate) = mode;
        let made = self.config.clock_hz / u64::from(timing.prescaler() * timing.quanta());
        let nominal = u32::try_from(made).ok().and_then(Bitrate::new);
        let configured = Configured { nominal: nominal.unwrap_or(candidate.nominal), data: None };
        self.switching = Some((sim.now() + self.config.reconfiguration, config, configured));
    }

    fn produce(&mut self, sim: &mut Simulation) {
        let Some(period) = self.period() else { return };
        self.counter = self.counter.wrapping_add(1);
        let frame = match self.config.sync {
            Some(_) => frame(0x080, &[self.counter]),
            None => {
                let id = 0x180 + u16::from(self.config.node_id.get() & 0x7F);
                let counter = self.counter;
                frame(id, &[counter, !counter, 0x5A, counter ^ 0x33, 0, 0, 0xFF, 1])
            }
        };
        if let Some(frame) = frame {
            sim.send_at(sim.now(), self.id, frame);
            self.pdo_pending = true;
        }
        self.next_pdo = sim.now() + period;
    }
}

/// What LSS has stored.
#[derive(Debug, Clone, Copy)]
struct StoredConfiguration(Option<Configuration>);

impl canbaud::lss::Storage for StoredConfiguration {
    fn store(&mut self, configuration: Configuration) -> Result<(), canbaud::lss::StoreError> {
        self.0 = Some(configuration);
        Ok(())
    }
}

fn slave(address: LssAddress, settings: &Settings) -> Slave {
    let automatic = match settings.startup {
        Startup::Slave => Automatic::Offered,
        Startup::MiniMaster => Automatic::Refused,
    };
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic };
    Slave::new(options, Configuration { node_id: settings.node_id, rate: settings.rate })
}

/// What the controller is set up for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Listen,
    TakePart,
}

/// Mode and gate for a purpose; `None` if the device cannot.
const fn mode(listener: Listener, purpose: Purpose) -> Option<(Mode, Gate)> {
    match (listener, purpose) {
        (Listener::Gate, Purpose::TakePart) => Some((Mode::Normal, Gate::Open)),
        (Listener::Gate, Purpose::Listen) => Some((Mode::Normal, Gate::Closed)),
        (_, Purpose::TakePart) => Some((Mode::Normal, Gate::Absent)),
        (Listener::Monitoring(_), Purpose::Listen) => Some((Mode::BusMonitoring, Gate::Absent)),
        (Listener::None, Purpose::Listen) => None,
    }
}

fn frame(id: u16, data: &[u8]) -> Option<Frame> {
    let id = canbaud::wire::Id::base(id)?;
    Frame::new(id, canbaud::wire::FrameKind::Data, data.len() as u8, data).ok()
}

/// The controller as it comes out of reset.
fn blank(config: &DeviceConfig) -> NodeConfig {
    // 125 kbit/s can be made of every clock in use.
    let point = Permille::new(875).unwrap_or_default();
    let nominal = BitTiming::find(config.clock_hz, 125_000, point);
    let mut node = NodeConfig::at(&config.name, 125_000).unwrap_or_else(|_| unreachable!());
    node.oscillator = canbaud_sim::Oscillator { hertz: config.clock_hz, ppb: config.ppb };
    node.nominal = nominal.unwrap_or(node.nominal);
    node.fd = canbaud_sim::FdSupport::None;
    node.recovery = Recovery::Manual;
    if config.listener == Listener::Gate {
        node.gate = Gate::Closed;
    }
    if config.listener == Listener::Monitoring(Evidence::Counter) {
        node.monitoring_counters = MonitoringCounters::Counting;
    }
    node
}

const fn logic(level: Level) -> Logic {
    match level {
        Level::Recessive => Logic::High,
        Level::Dominant => Logic::Low,
    }
}

const fn class(kind: ErrorKind) -> ErrorClass {
    match kind {
        ErrorKind::Bit => ErrorClass::Bit,
        ErrorKind::Stuff => ErrorClass::Stuff,
        ErrorKind::Form => ErrorClass::Form,
        ErrorKind::Crc => ErrorClass::Crc,
        ErrorKind::Ack => ErrorClass::Acknowledge,
    }
}

const fn where_at(place: Place) -> ErrorPlace {
    match place {
        Place::Arbitration => ErrorPlace::Arbitration,
        Place::Control | Place::Data | Place::Crc => ErrorPlace::BeforeCrcEnd,
        Place::CrcDelimiter => ErrorPlace::CrcDelimiter,
        Place::AckSlot => ErrorPlace::AckSlot,
        Place::AckDelimiter => ErrorPlace::AckDelimiter,
        Place::EndOfFrame => ErrorPlace::EndOfFrame,
        Place::Flag | Place::Delimiter | Place::Between => ErrorPlace::Between,
    }
}
