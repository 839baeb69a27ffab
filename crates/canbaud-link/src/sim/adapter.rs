//! What an adapter is like.

use canbaud::detect::scan::{Evidence, FdSupport};
use canbaud::units::Micros;
use canbaud_sim::MonitoringCounters;
use canbaud_sim::around::Fifo;

/// The time stamps of what it tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stamps {
    /// None.
    None,
    /// When it came in from the bus, in whole microseconds.
    Hardware,
    /// When the host got it.
    Arrival,
}

/// What an adapter is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Adapter {
    /// What it tells about a wrong rate.
    pub evidence: Evidence,
    /// Whether its error counter moves while it only listens.
    pub counters: MonitoringCounters,
    /// Its time stamps.
    pub stamps: Stamps,
    /// It hands over what it has at whole multiples of this; 0 for at once.
    pub batch: Micros,
    /// T_cc.
    pub reconfiguration: Micros,
    /// Frames that its FIFO holds.
    pub depth: usize,
    /// What a new bit timing does to the FIFO.
    pub fifo: Fifo,
    /// CAN FD.
    pub fd: FdSupport,
}

impl Adapter {
    /// A microcontroller's own: an interrupt for each error, T_cc 1 ms.
    #[must_use]
    pub const fn embedded() -> Self {
        Self {
            evidence: Evidence::Errors,
            counters: MonitoringCounters::Frozen,
            stamps: Stamps::Hardware,
            batch: Micros(0),
            reconfiguration: Micros::from_ms(1),
            depth: 3,
            fifo: Fifo::Kept,
            fd: FdSupport::Classic,
        }
    }

    /// On a serial line or USB, without time stamps of its own, told once in a millisecond.
    #[must_use]
    pub const fn usb(evidence: Evidence) -> Self {
        Self {
            evidence,
            counters: MonitoringCounters::Counting,
            stamps: Stamps::Arrival,
            batch: Micros::from_ms(1),
            reconfiguration: Micros::from_ms(10),
            depth: 64,
            fifo: Fifo::Cleared,
            fd: FdSupport::Classic,
        }
    }

    /// The same with another T_cc.
    #[must_use]
    pub const fn with_reconfiguration(mut self, reconfiguration: Micros) -> Self {
        self.reconfiguration = reconfiguration;
        self
    }
}
