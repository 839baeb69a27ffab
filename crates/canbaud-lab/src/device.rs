//! A device: controller, timer and memory of the simulator, with [`canbaud::node::Node`] inside.

use std::collections::VecDeque;

use canbaud::detect::scan::{
    Candidate, Configured, ErrorSeen, Evidence, FrameSeen, Observation, Origin,
};
use canbaud::fault;
use canbaud::lss::{RateSetting, Slave, SlaveAction};
use canbaud::node::{Action, Input, NmtState, Node, Sending, Settings, Stage, boot_up, load, save};
use canbaud::timing::default_sample_point;
use canbaud::units::{Bitrate, Permille};
use canbaud::wire::{Frame, Level};
use canbaud_sim::around::CaptureTimer;
use canbaud_sim::{BitTiming, Event, FaultState, Gate, Mode, NodeConfig, Simulation, Span, Time};

use crate::config::{DeviceConfig, Listener};
use crate::controller::{Purpose, blank, class, frame, logic, mode, off, where_at};
use crate::journal::Journal;
use crate::lss::{StoredConfiguration, slave};
use crate::memory::Memory;
use crate::time::{micros, time};

/// LSS commands that wait for the software; a further one is lost, as in a device.
const INBOX: usize = 16;

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
    /// Its controller, off.
    off: NodeConfig,
    software: Option<Node>,
    timer: Option<CaptureTimer>,
    memory: Memory,
    /// The controller will be like this then.
    switching: Option<(Time, NodeConfig, Configured)>,
    /// Sent by [`Action::Send`] and not yet acknowledged.
    under_way: Option<Frame>,
    lss: Option<Slave>,
    /// LSS commands on their way through the device.
    inbox: VecDeque<(Time, Frame)>,
    stored: StoredConfiguration,
    /// The LSS slave waits for the detection that it has asked for.
    lss_waits: bool,
    next_pdo: Time,
    pdo_pending: bool,
    counter: u8,
    joined: Vec<Joined>,
    line: Level,
    journal: Journal,
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
        let off = blank(&config);
        let id = sim.add_node(off.clone())?;
        sim.watch(id);
        Self::at(config, id, off)
    }

    /// The device whose controller is the node `id`, switched off, set up as `controller`.
    ///
    /// # Errors
    /// [`canbaud_sim::ClockError`] if its timer is impossible.
    pub(crate) fn at(
        config: DeviceConfig,
        id: canbaud_sim::NodeId,
        controller: NodeConfig,
    ) -> Result<Self, canbaud_sim::ClockError> {
        let timer = match config.timer_hz {
            Some(hz) => Some(CaptureTimer::new(hz, config.ppb, 64, Span::ZERO)?),
            None => None,
        };
        let storage = config.lss_storage;
        Ok(Self {
            off: off(controller, config.listener),
            config,
            id,
            software: None,
            timer,
            memory: Memory::new(),
            switching: None,
            under_way: None,
            lss: None,
            inbox: VecDeque::new(),
            stored: StoredConfiguration { kept: None, storage },
            lss_waits: false,
            next_pdo: Time::NEVER,
            pdo_pending: false,
            counter: 0,
            joined: Vec::new(),
            line: Level::Recessive,
            journal: Journal::default(),
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

    /// What it tells about itself.
    pub(crate) const fn journal(&mut self) -> &mut Journal {
        &mut self.journal
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
        self.timer.is_some() && self.software.is_some() && self.must_be_silent()
    }

    /// Power comes.
    pub fn power_on(&mut self, sim: &mut Simulation) {
        self.memory.power_on();
        // A memory that cannot be read remembers nothing.
        let kept = load::<_, 4>(&mut self.memory).unwrap_or_default();
        let remembered = kept.and_then(|bytes| Bitrate::new(u32::from_le_bytes(bytes)));
        let mut settings = self.config.settings;
        // What LSS has stored is active from power-on.
        if let Some(stored) = self.stored.kept {
            (settings.node_id, settings.rate) = (stored.node_id, stored.rate);
        }
        self.journal.forget();
        self.journal.tell(|| {
            let known = remembered.map_or("nothing".into(), |rate| format!("{rate}bit/s"));
            format!("power on: stored rate {}, remembers {known}", settings.rate)
        });
        self.software = Node::new(settings, remembered, micros(sim.now())).ok();
        self.lss = self.config.lss.map(|address| slave(address, &self.config, &settings));
        self.lss_waits = false;
        self.next_pdo = sim.now();
        self.turn(sim);
    }

    /// Power goes.
    pub fn power_off(&mut self, sim: &mut Simulation) {
        self.software = None;
        self.lss = None;
        self.switching = None;
        self.inbox.clear();
        self.journal.forget();
        self.journal.tell(|| "power off".into());
        self.forget_requests(sim);
        self.set_up(sim, self.off.clone());
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
        let inbox = self.inbox.front().map_or(Time::NEVER, |(at, _)| *at);
        let pdo = if self.produces() { self.next_pdo } else { Time::NEVER };
        deadline.min(switching).min(pdo).min(lss).min(inbox)
    }

    fn period(&self) -> Option<Span> {
        self.config.sync.or(self.config.pdo)
    }

    fn produces(&self) -> bool {
        let may_send = self.lss.as_ref().is_none_or(Slave::may_send);
        self.period().is_some() && !self.pdo_pending && may_send && self.is_operational()
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
                if normal && self.lss.is_some() && self.inbox.len() < INBOX {
                    self.inbox.push_back((at + self.config.lss_processing, *frame));
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
            && !matches!(node.stage(), Stage::TakingPart { .. })
        {
            node.timer(timer.ticks(sim.now()), logic(self.line));
        }
        self.follow(sim);
        self.turn_lss(sim);
        if self.produces() && self.next_pdo <= sim.now() {
            self.produce(sim);
        }
    }

    /// Does what the node asks for.
    fn follow(&mut self, sim: &mut Simulation) {
        let now = micros(sim.now());
        while let Some(node) = &mut self.software {
            let action = node.poll(now);
            self.journal.look(node);
            let Some(action) = action else { return };
            self.act(&action, sim);
        }
    }

    /// LSS commands that are through the device, and what the LSS slave wants.
    fn turn_lss(&mut self, sim: &mut Simulation) {
        let now = micros(sim.now());
        if self.lss_waits && !self.must_be_silent() {
            self.lss_waits = false;
            self.lss.as_mut().into_iter().for_each(Slave::rate_found);
        }
        self.carry_out_lss(sim);
        while let Some((_, frame)) = self.inbox.front().copied().filter(|(at, _)| *at <= sim.now())
        {
            self.inbox.pop_front();
            if let Some(slave) = &mut self.lss {
                self.journal.look_at_lss(slave);
                slave.handle(now, &frame, &mut self.stored);
                self.journal.look_at_lss(slave);
            }
            self.carry_out_lss(sim);
        }
    }

    fn carry_out_lss(&mut self, sim: &mut Simulation) {
        let now = micros(sim.now());
        while let Some(action) = self.lss.as_mut().and_then(|slave| slave.poll(now)) {
            let Some(node) = &mut self.software else { return };
            match action {
                SlaveAction::Send(frame) => sim.send_at(sim.now(), self.id, frame),
                SlaveAction::StopSending => {
                    self.journal.tell(|| "LSS: falls silent for an activation".into());
                    node.set_sending(Sending::Forbidden);
                    self.forget_requests(sim);
                }
                SlaveAction::ResumeSending => {
                    self.journal.tell(|| "LSS: may send again".into());
                    node.set_sending(Sending::Allowed);
                }
                SlaveAction::SwitchBitRate(rate) => {
                    self.journal.tell(|| format!("LSS: switches to {rate}"));
                    // The slave has offered only what can be.
                    let _ = node.set_rate(rate, now);
                    self.lss_waits = rate == RateSetting::Automatic;
                }
                SlaveAction::ResetCommunication(node_id) => {
                    self.lss.as_mut().into_iter().for_each(Slave::reset_communication);
                    node.reset_communication(node_id);
                }
            }
            self.follow(sim);
        }
    }

    fn act(&mut self, action: &Action, sim: &mut Simulation) {
        match action {
            Action::Stop => {
                self.switching = None;
                self.forget_requests(sim);
                self.set_up(sim, self.off.clone());
            }
            Action::Listen(candidate) => {
                self.journal.listens(candidate.nominal);
                self.switch(candidate, Purpose::Listen, sim);
            }
            Action::TakePart(candidate) => {
                let (at, bitrate) = (sim.now(), candidate.nominal);
                let company = self.company(bitrate, sim);
                self.joined.push(Joined { at, bitrate, company });
                self.switch(candidate, Purpose::TakePart, sim);
            }
            Action::Send(frame) => {
                let node_id = self.software.as_ref().map(|node| node.settings().node_id);
                if node_id.and_then(boot_up).as_ref() == Some(frame) {
                    self.journal.tell(|| format!("sends its boot-up message {}", frame.id()));
                }
                self.under_way = Some(*frame);
                sim.send_at(sim.now(), self.id, *frame);
            }
            Action::Remember(rate) => {
                self.journal.tell(|| format!("remembers {rate}bit/s"));
                // Power may go meanwhile: the next power-on finds the old value or the new one.
                let _ = save(&mut self.memory, &rate.bits_per_second().to_le_bytes());
            }
            // The pending node-ID becomes the active one.
            Action::Reset(_) => {
                if let (Some(slave), Some(node)) = (&mut self.lss, &mut self.software) {
                    slave.reset_communication();
                    node.reset_communication(slave.active().node_id);
                }
            }
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
        let mut config = self.off.clone();
        self.set_up(sim, config.clone());
        let rate = candidate.nominal.bits_per_second();
        let point = Permille::new(default_sample_point(candidate.nominal).permille());
        let timing = BitTiming::find(self.config.clock_hz, rate, point.unwrap_or_default());
        let (Ok(timing), Some(mode)) = (timing, mode(self.config.listener, purpose)) else {
            self.switching = None;
            self.journal.tell(|| format!("its controller refuses {}bit/s", candidate.nominal));
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
                let node_id =
                    self.software.as_ref().map_or(0, |node| node.settings().node_id.get());
                let id = 0x180 + u16::from(node_id & 0x7F);
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
