//! Software of a CANopen device that can be configured over the bus (LSS).

use std::collections::VecDeque;

use canbaud::lss::{
    Configuration, NodeId as CanopenId, RateSet, RateSetting, Slave, SlaveAction, SlaveOptions,
    Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};

use crate::event::{Event, NodeId};
use crate::node::{Mode, NodeConfig};
use crate::simulation::Simulation;
use crate::software::LssStorage;
use crate::time::{Span, Time};
use crate::timing::BitTiming;

/// Commands that wait for the software; a further one is lost, as in a device.
const INBOX: usize = 16;

/// What an LSS device is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LssSetup {
    /// Its address, and what it can be set to.
    pub slave: SlaveOptions,
    /// What it has stored.
    pub stored: Configuration,
    /// The bit rates of the table with their timing, in the order in which it listens for them.
    pub timings: Vec<(Bitrate, BitTiming)>,
    /// What comes of "store configuration".
    pub storage: LssStorage,
    /// From the reception of a command until the answer waits in the controller.
    pub processing: Span,
    /// T_cc: off, new timing, on again.
    pub reconfiguration: Span,
}

impl LssSetup {
    /// The bit rates that a device with `timings` can be set to.
    #[must_use]
    pub fn rates(timings: &[(Bitrate, BitTiming)]) -> RateSet {
        timings.iter().fold(RateSet::NONE, |set, (rate, _)| set.with(*rate))
    }
}

/// Keeps what was stored last, if it works.
#[derive(Debug, Clone)]
struct Memory {
    kept: Configuration,
    storage: LssStorage,
}

impl Storage for Memory {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        self.storage.check()?;
        self.kept = configuration;
        Ok(())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Takes part, or keeps the silence of an activation.
    Running,
    /// Listens at the bit rate of this place; the first message without an error is the answer
    /// [Koppe, figure 1].
    Detecting { candidate: usize },
}

/// A node with its software.
#[derive(Debug, Clone)]
pub struct LssDevice {
    node: NodeId,
    setup: LssSetup,
    slave: Slave,
    memory: Memory,
    inbox: VecDeque<(Time, Frame)>,
    phase: Phase,
    /// Nothing that happens before counts: the controller is being set up anew.
    deaf_until: Time,
    found: Option<(Time, BitTiming)>,
}

fn micros(time: Time) -> Micros {
    Micros(time.femtoseconds() / 1_000_000_000)
}

fn time(at: Micros) -> Time {
    at.0.checked_mul(1_000_000_000).map_or(Time::NEVER, Time::from_fs)
}

impl LssDevice {
    /// The software of `node`, whose controller runs at the stored bit rate.
    #[must_use]
    pub fn new(node: NodeId, setup: LssSetup) -> Self {
        let slave = Slave::new(setup.slave, setup.stored);
        let memory = Memory { kept: setup.stored, storage: setup.storage };
        let (phase, inbox) = (Phase::Running, VecDeque::new());
        Self { node, setup, slave, memory, inbox, phase, deaf_until: Time::ZERO, found: None }
    }

    /// Its node.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Its LSS slave.
    #[must_use]
    pub const fn slave(&self) -> &Slave {
        &self.slave
    }

    /// What it has stored.
    #[must_use]
    pub const fn stored(&self) -> Configuration {
        self.memory.kept
    }

    /// When it went to another bit rate last, and which timing that is.
    #[must_use]
    pub const fn found(&self) -> Option<(Time, BitTiming)> {
        self.found
    }

    /// When it has something to do next.
    #[must_use]
    pub fn deadline(&self) -> Time {
        let inbox = self.inbox.front().map_or(Time::NEVER, |(at, _)| *at);
        inbox.min(time(self.slave.deadline()))
    }

    /// Its deadline has come.
    pub fn wake(&mut self, now: Time, sim: &mut Simulation) {
        self.carry_out(now, sim);
        while let Some((at, frame)) = self.inbox.pop_front() {
            if at > now {
                self.inbox.push_front((at, frame));
                break;
            }
            self.slave.handle(micros(now), &frame, &mut self.memory);
            self.carry_out(now, sim);
        }
    }

    /// Something happened in its controller.
    pub fn notice(&mut self, at: Time, event: &Event, sim: &mut Simulation) {
        if at < self.deaf_until {
            return;
        }
        match (self.phase, event) {
            (Phase::Running, Event::Received { frame }) if self.inbox.len() < INBOX => {
                self.inbox.push_back((at + self.setup.processing, *frame));
            }
            (Phase::Detecting { candidate }, Event::Received { .. }) => {
                self.phase = Phase::Running;
                if let Some((_, timing)) = self.setup.timings.get(candidate).copied() {
                    self.set_up(at, timing, Mode::Normal, sim);
                }
                self.slave.rate_found();
            }
            (Phase::Detecting { candidate }, Event::Error { .. }) => {
                self.listen(at, candidate + 1, sim);
            }
            _ => {}
        }
    }

    fn carry_out(&mut self, now: Time, sim: &mut Simulation) {
        while let Some(action) = self.slave.poll(micros(now)) {
            match action {
                SlaveAction::Send(frame) => sim.send_at(now.max(self.deaf_until), self.node, frame),
                SlaveAction::StopSending => sim.abort_requests(self.node),
                SlaveAction::SwitchBitRate(RateSetting::Fixed(rate)) => {
                    let timing = self.setup.timings.iter().find(|(known, _)| *known == rate);
                    // The slave takes no other bit rates than these.
                    if let Some((_, timing)) = timing.copied() {
                        self.set_up(now, timing, Mode::Normal, sim);
                    }
                }
                SlaveAction::SwitchBitRate(RateSetting::Automatic) => self.listen(now, 0, sim),
                SlaveAction::ResumeSending => {}
                SlaveAction::ResetCommunication(node_id) => {
                    self.slave.reset_communication();
                    self.boot_up(now, node_id, sim);
                }
            }
        }
    }

    fn boot_up(&self, now: Time, node_id: CanopenId, sim: &mut Simulation) {
        let id = Id::Base(0x700 + u16::from(node_id.get()));
        if let Ok(frame) = Frame::new(id, FrameKind::Data, 1, &[0]) {
            sim.send_at(now.max(self.deaf_until), self.node, frame);
        }
    }

    /// Listens silently at the bit rate of place `candidate`, over and over.
    fn listen(&mut self, at: Time, candidate: usize, sim: &mut Simulation) {
        let candidate = candidate % self.setup.timings.len().max(1);
        self.phase = Phase::Detecting { candidate };
        if let Some((_, timing)) = self.setup.timings.get(candidate).copied() {
            self.set_up(at, timing, Mode::BusMonitoring, sim);
        }
    }

    /// Off now, on again with `timing` after T_cc.
    fn set_up(&mut self, at: Time, timing: BitTiming, mode: Mode, sim: &mut Simulation) {
        self.deaf_until = at + self.setup.reconfiguration;
        if mode == Mode::Normal {
            self.found = Some((at, timing));
        }
        let mut config = sim.node(self.node).config().clone();
        let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
        (config.nominal, config.mode) = (timing, mode);
        // Its oscillator is the one that it has.
        let _ = sim.reconfigure_at(at, self.node, off);
        let _ = sim.reconfigure_at(self.deaf_until, self.node, config);
    }
}
