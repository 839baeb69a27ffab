//! A controller as software sees it: it takes time to set up anew, has a receive FIFO and says
//! which error came last.

use std::collections::VecDeque;

use canbaud::wire::Frame;

use crate::event::{ErrorKind, Event, NodeId, Place};
use crate::node::{Mode, NodeConfig};
use crate::simulation::Simulation;
use crate::time::{Span, Time};
use crate::timing::BitTiming;

/// What becomes of received frames when the bit timing changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fifo {
    /// They are gone.
    Cleared,
    /// They stay: software may read a frame that came in at the rate before.
    #[default]
    Kept,
}

/// What a controller is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ControllerSettings {
    /// T_cc: off, new timing, on again \[Koppe\].
    pub reconfiguration: Span,
    /// Frames that the FIFO holds; further ones are lost.
    pub depth: usize,
    /// What a new timing does to the FIFO.
    pub fifo: Fifo,
}

impl Default for ControllerSettings {
    /// 100 µs, three frames, kept.
    fn default() -> Self {
        Self { reconfiguration: Span::from_us(100), depth: 3, fifo: Fifo::Kept }
    }
}

/// A frame in the FIFO.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Received {
    /// When it was accepted.
    pub at: Time,
    /// The frame.
    pub frame: Frame,
}

/// The last error, as an error code register holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorCode {
    /// When.
    pub at: Time,
    /// What.
    pub kind: ErrorKind,
    /// Where in the frame.
    pub place: Place,
}

/// The software's side of one node, which has to be watched.
///
/// ```
/// use canbaud_sim::around::{Controller, ControllerSettings};
/// use canbaud_sim::{Mode, NodeConfig, Simulation};
/// let mut sim = Simulation::new(1);
/// let node = sim.add_node(NodeConfig::at("scanner", 500_000).unwrap()).unwrap();
/// let mut controller = Controller::new(node, ControllerSettings::default());
/// sim.watch(node);
/// let timing = NodeConfig::at("", 250_000).unwrap().nominal;
/// let ready = controller.reconfigure(timing, Mode::BusMonitoring, &mut sim).unwrap();
/// assert_eq!(ready.femtoseconds(), 100_000_000_000);
/// ```
#[derive(Debug, Clone)]
pub struct Controller {
    node: NodeId,
    settings: ControllerSettings,
    fifo: VecDeque<Received>,
    overruns: u64,
    last_error: Option<ErrorCode>,
    errors: u64,
}

impl Controller {
    /// A controller at `node`.
    #[must_use]
    pub const fn new(node: NodeId, settings: ControllerSettings) -> Self {
        Self { node, settings, fifo: VecDeque::new(), overruns: 0, last_error: None, errors: 0 }
    }

    /// Its node.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Switches off, loads `timing` and `mode`, switches on; returns when it integrates.
    ///
    /// # Errors
    /// [`crate::ClockError`] if the node's clock is impossible.
    pub fn reconfigure(
        &mut self,
        timing: BitTiming,
        mode: Mode,
        sim: &mut Simulation,
    ) -> Result<Time, crate::ClockError> {
        let config = sim.node(self.node).config().clone();
        let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
        let ready = sim.now() + self.settings.reconfiguration;
        sim.reconfigure_at(sim.now(), self.node, off)?;
        sim.reconfigure_at(ready, self.node, NodeConfig { nominal: timing, mode, ..config })?;
        if self.settings.fifo == Fifo::Cleared {
            self.fifo.clear();
        }
        Ok(ready)
    }

    /// Something happened in the node.
    pub fn notice(&mut self, at: Time, event: &Event) {
        match event {
            Event::Received { .. } if self.fifo.len() >= self.settings.depth => self.overruns += 1,
            Event::Received { frame } => self.fifo.push_back(Received { at, frame: *frame }),
            Event::Error { kind, place, .. } => {
                self.errors += 1;
                self.last_error = Some(ErrorCode { at, kind: *kind, place: *place });
            }
            _ => {}
        }
    }

    /// The oldest frame of the FIFO.
    pub fn read(&mut self) -> Option<Received> {
        self.fifo.pop_front()
    }

    /// Frames that were lost because the FIFO was full.
    #[must_use]
    pub const fn overruns(&self) -> u64 {
        self.overruns
    }

    /// The last error since this was called last.
    pub const fn take_error(&mut self) -> Option<ErrorCode> {
        self.last_error.take()
    }

    /// Errors so far.
    #[must_use]
    pub const fn errors(&self) -> u64 {
        self.errors
    }

    /// TEC and REC, as the registers show them.
    #[must_use]
    pub fn counters(&self, sim: &Simulation) -> (u16, u16) {
        let fault = sim.node(self.node).fault();
        (fault.tec(), fault.rec())
    }
}
