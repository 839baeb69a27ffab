//! The seam for software that the simulator must not know: nodes that detect their bit rate.
//!
//! A scenario says what such a node is ([`AutonomousPlan`]); a [`Supplier`] makes its [`Software`].
//! The simulator hands it what a device hears of its controller and its capture timer, and asks
//! where it stands. It never sees how the software comes to what it does.

use std::fmt;

use canbaud::lss::{Automatic, LssAddress, NodeId as CanopenId, RateSetting, StoreError};
use canbaud::units::Bitrate;
use canbaud::wire::Level;

use crate::clock::ClockError;
use crate::event::{Event, NodeId};
use crate::node::NodeConfig;
use crate::simulation::Simulation;
use crate::time::{Span, Time};

/// Software of a node: what reacts to what its controller and its timer report.
pub trait Software: fmt::Debug {
    /// Power comes.
    fn power_on(&mut self, sim: &mut Simulation);

    /// Power goes; what is stored stays.
    fn power_off(&mut self, sim: &mut Simulation);

    /// Something happened in its controller.
    fn notice(&mut self, at: Time, event: &Event, sim: &mut Simulation);

    /// Whether its timer captures edges now.
    fn follows_edges(&self) -> bool;

    /// The line changed to `level`.
    fn edge(&mut self, at: Time, level: Level);

    /// When it wants to be woken; [`Time::NEVER`] if only something that happens can bring it on.
    fn deadline(&self) -> Time;

    /// Does what is due.
    fn wake(&mut self, sim: &mut Simulation);

    /// What it has to tell since the last call, for people.
    fn take_told(&mut self) -> Vec<String>;

    /// Where it stands.
    fn standing(&self) -> Standing;
}

/// Where software stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Standing {
    /// Where on its way.
    pub stage: Stage,
    /// The bit rate at which it takes part, and since when.
    pub takes_part: Option<(Bitrate, Time)>,
}

/// Where a node is on its way into the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Without power.
    Off,
    /// Listens for the bit rate; it must not drive the bus.
    Detecting,
    /// Waits for the end of bus-off; it must not drive the bus.
    Recovering,
    /// Takes part; its boot-up message is not acknowledged yet.
    Initialising,
    /// NMT state pre-operational.
    PreOperational,
    /// NMT state operational.
    Operational,
    /// NMT state stopped.
    Stopped,
}

impl Stage {
    /// Whether a node must not drive the bus.
    #[must_use]
    pub const fn must_be_silent(self) -> bool {
        matches!(self, Self::Off | Self::Detecting | Self::Recovering)
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Off => "off",
            Self::Detecting => "detecting",
            Self::Recovering => "recovering",
            Self::Initialising => "initialising",
            Self::PreOperational => "pre-operational",
            Self::Operational => "operational",
            Self::Stopped => "stopped",
        })
    }
}

/// How a node can listen without taking part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listening {
    /// Bus monitoring; the controller tells each error.
    Errors,
    /// Bus monitoring; only the receive error counter moves.
    Counter,
    /// Bus monitoring; at a wrong bit rate there is nothing to be seen.
    FramesOnly,
    /// The gate circuit of Koppe.
    Gate,
    /// Not at all: the timer has to do.
    None,
}

/// Object 1F80h, NMT start-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartUp {
    /// Waits for an NMT master.
    Slave,
    /// Starts itself and the others.
    MiniMaster,
}

/// How a node breaks the silence of a bus where nobody talks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BreakSilence {
    /// The bit rate where none was right yet.
    pub default: Bitrate,
    /// How long it waits at least.
    pub after: Span,
    /// How much longer at random.
    pub spread: Span,
    /// How long it waits for an acknowledgement.
    pub hold: Span,
}

/// What comes of "store configuration".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LssStorage {
    /// It is kept over a loss of power.
    #[default]
    Works,
    /// The medium cannot be accessed: error 2.
    Fails,
    /// The device cannot store: error 1.
    Missing,
}

impl LssStorage {
    /// Whether something can be stored.
    ///
    /// # Errors
    /// What the master is told if not.
    pub const fn check(self) -> Result<(), StoreError> {
        match self {
            Self::Works => Ok(()),
            Self::Fails => Err(StoreError::Access),
            Self::Missing => Err(StoreError::NotSupported),
        }
    }
}

/// A node as an LSS slave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LssPlan {
    /// Object 1018h.
    pub address: LssAddress,
    /// Whether it takes index 9; a mini-master never does.
    pub automatic: Automatic,
    /// From the reception of a command until the answer waits in the controller.
    pub processing: Span,
    /// Its memory.
    pub storage: LssStorage,
}

/// A CANopen node that finds its own way into the network, as a scenario describes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AutonomousPlan {
    /// Its node-ID; none without one.
    pub node_id: CanopenId,
    /// The bit rate that it has stored, or index 9.
    pub rate: RateSetting,
    /// The bit rate that was right in another life.
    pub remembers: Option<Bitrate>,
    /// Object 1F80h.
    pub start_up: StartUp,
    /// How its controller listens.
    pub listening: Listening,
    /// Its capture timer.
    pub timer_hz: Option<u64>,
    /// T_cc: off, new timing, on again.
    pub reconfiguration: Span,
    /// What it does where nobody talks; `None`: waits.
    pub silence: Option<BreakSilence>,
    /// Time between two heartbeats; `None`: none.
    pub heartbeat: Option<Span>,
    /// Time between two process data objects while it is operational.
    pub pdo: Option<Span>,
    /// Time between two SYNC messages while it is operational.
    pub sync: Option<Span>,
    /// As an LSS slave.
    pub lss: Option<LssPlan>,
}

/// Makes the software of autonomous nodes.
pub trait Supplier: Sync {
    /// The software of `node`, without power; `config` is its controller, switched off, and `seed`
    /// is of all its chance.
    ///
    /// # Errors
    /// [`ClockError`] if its timer is impossible.
    fn software(
        &self,
        plan: &AutonomousPlan,
        node: NodeId,
        config: &NodeConfig,
        seed: u64,
    ) -> Result<Box<dyn Software>, ClockError>;
}
