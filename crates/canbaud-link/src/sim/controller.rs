//! A simulated controller behind the seam of a scan.

use std::collections::VecDeque;

use canbaud::detect::scan::{
    Candidate, Capabilities, Capture, Configured, Controller, ErrorClass, ErrorPlace, ErrorSeen,
    Evidence, FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::units::{Bitrate, Micros, Permille};
use canbaud_sim::around::{self, ControllerSettings, Fifo};
use canbaud_sim::{
    BitTiming, ClockError, ErrorKind, Event, Mode, NodeConfig, NodeId, Observer, Place, Simulation,
    Span, Time, TimingError,
};

use super::adapter::{Adapter, Stamps};
use super::bus::{SimBus, micros, time};

/// What can go wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SimError {
    /// The simulated clock cannot make the rate.
    #[error(transparent)]
    Timing(#[from] TimingError),
    /// There is no such clock.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// It was started before it was configured.
    #[error("the controller was started without a bit timing")]
    NotConfigured,
}

/// A controller on a simulated bus that can only listen.
#[derive(Debug)]
pub struct SimController<O> {
    bus: SimBus<O>,
    controller: around::Controller,
    adapter: Adapter,
    config: Option<NodeConfig>,
    /// What it has told, and when the host gets it.
    told: VecDeque<(Micros, Observation)>,
    counter: u16,
    /// How long before it listens traffic begins; `None`: there is traffic all the time.
    lead: Option<Span>,
    /// Frames that began while it listened, of those counted by the bus.
    heard: u64,
    at_start: u64,
    listening: bool,
}

/// What a new node is set up as, before a scan configures it.
pub(super) fn off(adapter: &Adapter) -> Result<NodeConfig, TimingError> {
    let mut config = NodeConfig::at("scanner", 500_000)?.with_mode(Mode::Disabled);
    config.monitoring_counters = adapter.counters;
    config.fd = match adapter.fd {
        canbaud::detect::scan::FdSupport::Classic => canbaud_sim::FdSupport::None,
        canbaud::detect::scan::FdSupport::Fd => canbaud_sim::FdSupport::Enabled,
    };
    Ok(config)
}

impl<O: Observer> SimController<O> {
    /// Adds a node for the controller, switched off, to a simulation that has not run yet.
    ///
    /// # Errors
    /// [`SimError`] if the simulator has no such clock.
    pub fn add_to(sim: &mut Simulation, adapter: &Adapter) -> Result<NodeId, SimError> {
        let node = sim.add_node(off(adapter)?)?;
        sim.watch(node);
        Ok(node)
    }

    /// The controller at `node`, which [`SimController::add_to`] has made.
    pub fn new(bus: SimBus<O>, node: NodeId, adapter: Adapter) -> Self {
        let settings = ControllerSettings {
            reconfiguration: Span::from_us(adapter.reconfiguration.0),
            depth: adapter.depth,
            fifo: adapter.fifo,
        };
        Self {
            bus,
            controller: around::Controller::new(node, settings),
            adapter,
            config: None,
            told: VecDeque::new(),
            counter: 0,
            lead: None,
            heard: 0,
            at_start: 0,
            listening: false,
        }
    }

    /// Leaves out the traffic that passes while the controller is set up, up to `lead` before it
    /// listens: nobody hears it.
    #[must_use]
    pub const fn lean(mut self, lead: Span) -> Self {
        self.lead = Some(lead);
        self
    }

    /// Now, on the scan's clock.
    pub const fn now(&self) -> Micros {
        micros(self.bus.sim().now())
    }

    /// The bus.
    pub const fn bus(&self) -> &SimBus<O> {
        &self.bus
    }

    /// The bus, to disturb it.
    pub const fn bus_mut(&mut self) -> &mut SimBus<O> {
        &mut self.bus
    }

    /// Gives the bus back.
    pub fn into_bus(self) -> SimBus<O> {
        self.bus
    }

    /// Transmissions that began while it listened.
    pub const fn heard(&self) -> u64 {
        self.heard + if self.listening { self.bus.transmissions() - self.at_start } else { 0 }
    }

    /// A frame of a local process, which the host's network stack hands back at `at`.
    pub fn loop_back(&mut self, at: Micros, frame: canbaud::wire::Frame) {
        let seen = FrameSeen { frame, origin: Origin::Local, received: Some(at) };
        self.told.push_back((at, Observation::Frame(seen)));
    }

    /// Lets the time go on until it has something to tell, at most until `until`.
    pub fn wait(&mut self, until: Micros) {
        let node = self.controller.node();
        while self.now() < until {
            if self.told.front().is_some_and(|(at, _)| *at <= self.now()) {
                return;
            }
            let next = self.told.front().map_or(until, |(at, _)| (*at).min(until));
            for (at, event) in self.bus.run(time(next), node) {
                self.notice(at, &event);
            }
        }
    }

    /// Something happened in the node.
    fn notice(&mut self, at: Time, event: &Event) {
        let tells = self.adapter.evidence;
        match event {
            Event::Received { .. } if self.waiting_frames() >= self.adapter.depth => {
                self.tell(at, Observation::Lost);
            }
            Event::Received { frame } => {
                let received = self.stamp(at);
                let seen = FrameSeen { frame: *frame, origin: Origin::Bus, received };
                self.tell(at, Observation::Frame(seen));
            }
            Event::Error { kind, place, .. } if tells == Evidence::Errors => {
                let received = self.stamp(at);
                let seen = ErrorSeen { class: class(*kind), place: self::place(*place), received };
                self.tell(at, Observation::Error(seen));
            }
            Event::Counted { rec, .. } if tells == Evidence::Counter && *rec != self.counter => {
                self.counter = *rec;
                self.tell(at, Observation::ReceiveErrors(*rec));
            }
            _ => {}
        }
    }

    fn waiting_frames(&self) -> usize {
        self.told.iter().filter(|(_, told)| matches!(told, Observation::Frame(_))).count()
    }

    fn stamp(&self, at: Time) -> Option<Micros> {
        match self.adapter.stamps {
            Stamps::None => None,
            Stamps::Hardware => Some(micros(at)),
            Stamps::Arrival => Some(self.arrival(at)),
        }
    }

    /// When the host gets what came in at `at`.
    fn arrival(&self, at: Time) -> Micros {
        let (at, batch) = (micros(at).0, self.adapter.batch.0);
        Micros(if batch == 0 { at } else { at.div_ceil(batch) * batch })
    }

    fn tell(&mut self, at: Time, observation: Observation) {
        let arrival = self.arrival(at);
        // Of the counter, the host reads the last value only.
        if let (Observation::ReceiveErrors(_), Some((when, Observation::ReceiveErrors(before)))) =
            (observation, self.told.back_mut())
            && *when == arrival
            && *before > 0
        {
            *before = self.counter;
            return;
        }
        self.told.push_back((arrival, observation));
    }

    fn timing(bitrate: Bitrate, capture: Capture) -> Result<BitTiming, SimError> {
        let rate = bitrate.bits_per_second();
        // CiA 301 and the default of Linux.
        let permille = match (capture, rate) {
            (Capture::Wide, _) | (_, 500_001..=800_000) => 800,
            (Capture::Usual, 800_001..) => 750,
            (Capture::Usual, _) => 875,
        };
        let point = Permille::new(permille).unwrap_or_default();
        let timing = BitTiming::find(80_000_000, rate, point)?;
        Ok(match capture {
            Capture::Usual => timing,
            Capture::Wide => timing.with_sjw(timing.phase_seg1().min(timing.phase_seg2()))?,
        })
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

const fn place(place: Place) -> ErrorPlace {
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

impl<O: Observer> Controller for SimController<O> {
    type Error = SimError;

    fn capabilities(&self) -> Capabilities<'_> {
        const LOW: Bitrate = match Bitrate::new(5_000) {
            Some(rate) => rate,
            None => unreachable!(),
        };
        const HIGH: Bitrate = match Bitrate::new(1_000_000) {
            Some(rate) => rate,
            None => unreachable!(),
        };
        Capabilities {
            rates: RateChoice::Between(LOW, HIGH),
            evidence: self.adapter.evidence,
            fd: self.adapter.fd,
            reconfiguration: self.adapter.reconfiguration,
            latency: self.adapter.batch,
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, SimError> {
        let mut config = off(&self.adapter)?;
        config.nominal = Self::timing(candidate.nominal, candidate.capture)?;
        if let Some(data) = candidate.data {
            config = config.with_data_bitrate(data.bits_per_second())?;
        }
        let rate = |timing: &BitTiming| {
            let quanta = u64::from(timing.prescaler()) * u64::from(timing.quanta());
            u32::try_from((config.oscillator.hertz + quanta / 2) / quanta)
                .ok()
                .and_then(Bitrate::new)
        };
        let configured = Configured {
            nominal: rate(&config.nominal).unwrap_or(candidate.nominal),
            data: config.data.as_ref().and_then(rate),
        };
        self.config = Some(config);
        if self.adapter.fifo == Fifo::Cleared {
            self.told.clear();
        }
        Ok(configured)
    }

    fn start_monitoring(&mut self) -> Result<(), SimError> {
        let config = self.config.clone().ok_or(SimError::NotConfigured)?;
        let node = self.controller.node();
        let sim = self.bus.sim_mut();
        let ready = self.controller.reconfigure(config.nominal, Mode::BusMonitoring, sim)?;
        // The model keeps the rest of the node as it was.
        sim.reconfigure_at(ready, node, config.with_mode(Mode::BusMonitoring))?;
        if let Some(lead) = self.lead {
            self.bus.skip_to(ready - lead);
        }
        while self.bus.sim().now() < ready {
            for (at, event) in self.bus.run(ready, node) {
                self.notice(at, &event);
            }
        }
        self.counter = 0;
        if self.adapter.evidence == Evidence::Counter {
            self.told.push_back((micros(ready), Observation::ReceiveErrors(0)));
        }
        self.listening = true;
        self.at_start = self.bus.transmissions();
        Ok(())
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, SimError> {
        match self.told.front() {
            Some((at, _)) if *at <= now => Ok(self.told.pop_front().map(|(_, told)| told)),
            _ => Ok(None),
        }
    }

    fn stop(&mut self) -> Result<(), SimError> {
        let node = self.controller.node();
        self.heard = self.heard();
        self.listening = false;
        let sim = self.bus.sim_mut();
        let off = sim.node(node).config().clone().with_mode(Mode::Disabled);
        sim.reconfigure_at(sim.now(), node, off)?;
        Ok(())
    }
}
