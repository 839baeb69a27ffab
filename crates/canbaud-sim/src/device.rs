//! Software of a node: what reacts to what its controller reports.

use canbaud::wire::{Frame, FrameKind, Id};

use crate::event::{Event, FaultState, NodeId};
use crate::node::{Gate, Mode, NodeConfig};
use crate::simulation::Simulation;
use crate::time::{Span, Time};
use crate::timing::BitTiming;

/// A reply of a device: when `to` arrives it sends `frame`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// Identifier that it waits for.
    pub to: Id,
    /// What it sends.
    pub frame: Frame,
}

/// How a node finds its bit rate, or does not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Program {
    /// Stays at its rate.
    Fixed,
    /// Listens at one rate after the other; the first message without an error is the answer
    /// [Koppe, figure 1].
    Autobaud {
        /// In this order, over and over.
        timings: Vec<BitTiming>,
        /// T_cc: off, new timing, on again.
        reconfiguration: Span,
        /// Goes on if for so long there is neither a message nor an error; `None`: waits for ever,
        /// as in the figure.
        patience: Option<Span>,
    },
    /// Goes to a fixed low rate after bus-off [Koppe, default fallback bit rate].
    Fallback {
        /// That rate.
        timing: BitTiming,
        /// T_cc.
        reconfiguration: Span,
    },
}

/// The state of an autobaud device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Searching,
    Joined,
}

/// A node with its software.
#[derive(Debug, Clone)]
pub struct Device {
    node: NodeId,
    program: Program,
    replies: Vec<Reply>,
    /// Sent once the device takes part: the boot-up message.
    announcement: Option<Frame>,
    phase: Phase,
    candidate: usize,
    /// Nothing that happens before counts: the controller is being set up anew.
    deaf_until: Time,
    found: Option<(Time, BitTiming)>,
    messages: u64,
}

impl Device {
    /// The software of `node`, whose controller starts as [`Device::first_config`] says.
    #[must_use]
    pub fn new(node: NodeId, program: Program, replies: Vec<Reply>, boot_up: Option<u8>) -> Self {
        let announcement = boot_up.and_then(|id| {
            let id = Id::base(0x700 + u16::from(id))?;
            Frame::new(id, FrameKind::Data, 1, &[0]).ok()
        });
        let phase = match program {
            Program::Autobaud { .. } => Phase::Searching,
            Program::Fixed | Program::Fallback { .. } => Phase::Joined,
        };
        Self {
            node,
            program,
            replies,
            announcement,
            phase,
            candidate: 0,
            deaf_until: Time::ZERO,
            found: None,
            messages: 0,
        }
    }

    /// Its node.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// When it found its bit rate, and which timing it was.
    #[must_use]
    pub const fn found(&self) -> Option<(Time, BitTiming)> {
        self.found
    }

    /// Messages and errors that it looked at while it searched.
    #[must_use]
    pub const fn messages(&self) -> u64 {
        self.messages
    }

    /// How the controller is set up at first.
    #[must_use]
    pub fn first_config(program: &Program, mut config: NodeConfig) -> NodeConfig {
        if let Program::Autobaud { timings, .. } = program
            && let Some(first) = timings.first()
        {
            config.nominal = *first;
            listen(&mut config);
        }
        config
    }

    /// When it loses its patience.
    #[must_use]
    pub fn deadline(&self) -> Time {
        match (self.phase, &self.program) {
            (Phase::Searching, Program::Autobaud { patience: Some(patience), .. }) => {
                self.deaf_until + *patience
            }
            _ => Time::NEVER,
        }
    }

    /// Its deadline has come.
    pub fn lose_patience(&mut self, now: Time, sim: &mut Simulation) {
        self.try_next(now, sim);
    }

    /// Something happened in its controller.
    pub fn notice(&mut self, at: Time, event: &Event, sim: &mut Simulation) {
        if at < self.deaf_until {
            return;
        }
        match (self.phase, event) {
            (Phase::Searching, Event::Received { .. }) => {
                self.messages += 1;
                self.join(at, sim);
            }
            (Phase::Searching, Event::Error { .. }) => {
                self.messages += 1;
                self.try_next(at, sim);
            }
            (Phase::Joined, Event::Received { frame }) => self.reply(at, frame, sim),
            (Phase::Joined, Event::Fault(FaultState::BusOff)) => self.fall_back(at, sim),
            _ => {}
        }
    }

    fn try_next(&mut self, at: Time, sim: &mut Simulation) {
        let Program::Autobaud { timings, reconfiguration, .. } = &self.program else { return };
        self.candidate = (self.candidate + 1) % timings.len();
        let mut config = sim.node(self.node).config().clone();
        config.nominal = timings[self.candidate];
        listen(&mut config);
        let span = *reconfiguration;
        self.set_up(at, span, config, sim);
    }

    fn join(&mut self, at: Time, sim: &mut Simulation) {
        let Program::Autobaud { timings, reconfiguration, .. } = &self.program else { return };
        let (timing, span) = (timings[self.candidate], *reconfiguration);
        self.found = Some((at, timing));
        self.phase = Phase::Joined;
        let mut config = sim.node(self.node).config().clone();
        config.nominal = timing;
        config.mode = Mode::Normal;
        if config.gate == Gate::Closed {
            config.gate = Gate::Open;
        }
        self.set_up(at, span, config, sim);
        if let Some(frame) = self.announcement {
            sim.send_at(self.deaf_until, self.node, frame);
        }
    }

    fn fall_back(&mut self, at: Time, sim: &mut Simulation) {
        let Program::Fallback { timing, reconfiguration } = &self.program else { return };
        let (timing, span) = (*timing, *reconfiguration);
        let mut config = sim.node(self.node).config().clone();
        if config.nominal != timing {
            config.nominal = timing;
            self.found = Some((at, timing));
            self.set_up(at, span, config, sim);
        }
    }

    fn reply(&self, at: Time, frame: &Frame, sim: &mut Simulation) {
        for reply in self.replies.iter().filter(|reply| reply.to == frame.id()) {
            sim.send_at(at, self.node, reply.frame);
        }
    }

    /// Off now, on again as `config` after `span`.
    fn set_up(&mut self, at: Time, span: Span, config: NodeConfig, sim: &mut Simulation) {
        self.deaf_until = at + span;
        let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
        // Its oscillator is the one that it has.
        let _ = sim.reconfigure_at(at, self.node, off);
        let _ = sim.reconfigure_at(self.deaf_until, self.node, config);
    }
}

/// Silent, by the controller's mode or by its gate.
fn listen(config: &mut NodeConfig) {
    if config.gate == Gate::Absent {
        config.mode = Mode::BusMonitoring;
    } else {
        config.mode = Mode::Normal;
        config.gate = Gate::Closed;
    }
}
