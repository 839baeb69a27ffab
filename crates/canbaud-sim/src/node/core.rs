//! A node: its pins, and when it has to be looked at next.

use canbaud::wire::{Frame, Level};

use super::bit_time::{BitTime, SyncOutcome};
use super::config::NodeConfig;
use super::corners::SyncCorners;
use super::fault::FaultConfinement;
use super::protocol::{Protocol, Setup};
use super::sampling::{Rxd, SecondarySampling};
use crate::bus::{EdgeLog, Line};
use crate::clock::{Clock, ClockError};
use crate::event::{Event, FaultState};
use crate::rng::mix;
use crate::time::{Span, Time};

/// A node of the bus.
#[derive(Debug, Clone)]
pub struct Node {
    pub(super) config: NodeConfig,
    pub(super) bit: BitTime,
    pub(super) rxd: Rxd,
    pub(super) protocol: Protocol,
    /// TXD of the controller, before a gate.
    pub(super) txd: Level,
    pub(super) txd_changed: Time,
    /// When TXD takes the level that protocol control drives; `NEVER` if it has it.
    pub(super) change_at: Time,
    /// The next edge that may synchronise.
    pub(super) edge_at: Time,
    /// An edge has synchronised since the last sample point, or none may.
    pub(super) synchronised: bool,
    pub(super) forced_rxd: Option<Level>,
    pub(super) secondary: Option<SecondarySampling>,
    pub(super) loop_delay: Span,
    pub(super) corners: SyncCorners,
    /// Whether bits that nothing can come of may be read late, many at a time.
    pub(super) late_reading: bool,
    /// Whether edges matter before `next`.
    pub(super) heeds_edges: bool,
    /// The node's next event.
    pub(super) due: Time,
    /// When it has to be looked at: at `due`, or later if that is all the same.
    pub(super) next: Time,
}

/// RXD of a node that does not hear the bus is recessive.
fn rxd(config: &NodeConfig, line: &Line, salt: u64) -> Rxd {
    let level = if config.hears_bus() { line.level() } else { Level::Recessive };
    Rxd::new(config.transceiver, salt, &line.log, level)
}

impl Node {
    pub(crate) fn new(
        config: NodeConfig,
        line: &Line,
        now: Time,
        salt: u64,
        fault: FaultConfinement,
    ) -> Result<Self, ClockError> {
        let clock = Clock::new(config.oscillator.hertz, config.oscillator.ppb)?;
        let bit = BitTime::new(clock, config.nominal, config.data, now);
        let mut node = Self {
            rxd: rxd(&config, line, salt),
            protocol: Protocol::new(Setup::from(&config), fault),
            bit,
            config,
            txd: Level::Recessive,
            txd_changed: now,
            change_at: Time::NEVER,
            edge_at: Time::NEVER,
            synchronised: false,
            forced_rxd: None,
            secondary: None,
            loop_delay: Span::ZERO,
            corners: SyncCorners::default(),
            late_reading: false,
            heeds_edges: true,
            due: Time::NEVER,
            next: Time::NEVER,
        };
        node.schedule();
        Ok(node)
    }

    /// How it is set up.
    #[must_use]
    pub const fn config(&self) -> &NodeConfig {
        &self.config
    }

    /// Error counters and state.
    #[must_use]
    pub const fn fault(&self) -> &FaultConfinement {
        self.protocol.fault()
    }

    /// The fault confinement state.
    #[must_use]
    pub const fn state(&self) -> FaultState {
        self.protocol.fault().state()
    }

    /// Requests that have not been sent.
    #[must_use]
    pub fn pending(&self) -> usize {
        self.protocol.pending()
    }

    /// How often each corner of synchronisation was met.
    #[must_use]
    pub const fn sync_corners(&self) -> &SyncCorners {
        &self.corners
    }

    /// What the last edge that may synchronise did.
    #[must_use]
    pub const fn last_sync(&self) -> Option<SyncOutcome> {
        self.bit.last_sync()
    }

    /// The loop delay measured at the last res bit that the node sent.
    #[must_use]
    pub const fn loop_delay(&self) -> Span {
        self.loop_delay
    }

    /// When the node has to be looked at next.
    #[inline]
    pub(crate) const fn next(&self) -> Time {
        self.next
    }

    pub(crate) const fn txd(&self) -> Level {
        self.txd
    }

    #[inline]
    pub(crate) const fn is_transmitting(&self) -> bool {
        self.protocol.is_transmitting()
    }

    pub(crate) fn has_events(&self) -> bool {
        self.protocol.has_events()
    }

    pub(crate) fn take_event(&mut self) -> Option<Event> {
        self.protocol.take_event()
    }

    /// Adds a request to send.
    pub(crate) fn request(&mut self, now: Time, frame: Frame) {
        if self.protocol.request(frame) {
            self.bit.skip_to(now);
            self.change_at = self.bit.start();
            self.schedule();
        }
    }

    pub(crate) fn abort_requests(&mut self) {
        self.protocol.abort_requests();
    }

    /// Holds RXD at a level, or lets it go: a disturbance at this node alone.
    pub(crate) fn force_rxd(&mut self, now: Time, log: &EdgeLog, forced: Option<Level>) {
        let before = self.forced_rxd.unwrap_or_else(|| self.rxd.level_at(log, now));
        self.forced_rxd = forced;
        let after = forced.unwrap_or_else(|| self.rxd.level_at(log, now));
        if (before, after) == (Level::Recessive, Level::Dominant) && !self.synchronised {
            self.synchronise(now);
        }
        self.edge_at = Time::NEVER;
        if !self.synchronised {
            self.look_for_edge(log);
        }
        self.schedule();
    }

    /// The clock runs `ppb` parts per billion fast from the next bit on.
    pub(crate) fn drift(&mut self, ppb: i64) -> Result<(), ClockError> {
        let clock = Clock::new(self.config.oscillator.hertz, ppb)?;
        self.config.oscillator.ppb = ppb;
        self.bit.change_clock(clock);
        if self.change_at != Time::NEVER {
            self.change_at = self.bit.start();
        }
        self.schedule();
        Ok(())
    }

    /// The salt of a node's jitter.
    pub(crate) const fn salt(seed: u64, place: usize) -> u64 {
        mix(seed ^ mix(place as u64 + 1))
    }
}
