//! A bit-accurate, seeded simulator of CAN and CAN FD buses.
//!
//! [`Simulation`] holds a bus with its nodes ([`NodeConfig`]); an [`Observer`] sees what happens.
//! Time is exact, and one seed reproduces a run bit for bit. `docs/simulator.md` is the tour.
//!
//! In: nodes, requests, disturbances. Out: events, edges, samples. Never: `canbaud::detect`.
#![forbid(unsafe_code)]

pub mod around;
pub mod benchmark;
mod bus;
pub mod check;
mod clock;
pub mod device;
mod event;
pub mod lss_device;
mod node;
mod rng;
pub mod scenario;
mod simulation;
pub mod slcan;
pub mod software;
mod time;
mod timing;
pub mod traffic;
pub mod write;

pub use bus::Transceiver;
pub use clock::{Clock, ClockError, Quantum, Tick};
pub use event::{
    Blind, Disturbance, ErrorKind, Event, FaultState, NodeId, Observer, Place, Role, Rule, Sample,
    SampleRun, Sampling,
};
pub use node::{
    FaultConfinement, FdSupport, Gate, Mode, MonitoringCounters, Node, NodeConfig, Oscillator,
    Recovery, Retransmission, SyncCorners, SyncOutcome, Tdc, Wire,
};
pub use rng::Rng;
pub use simulation::{Pace, Simulation, Stop};
pub use time::{ParseSpanError, Span, Time};
pub use timing::{BitTiming, TimingError};
