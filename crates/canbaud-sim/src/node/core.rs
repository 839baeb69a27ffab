//! A node: its pins, and when it has to be looked at next.

use canbaud::wire::{Frame, Level};

use super::bit_time::{BitTime, Rate, SyncOutcome};
use super::config::{NodeConfig, Tdc};
use super::fault::FaultConfinement;
use super::protocol::{Protocol, Quiet, Setup};
use super::sampling::{Rxd, SecondarySampling};
use crate::bus::{EdgeLog, Line};
use crate::clock::{Clock, ClockError};
use crate::event::{Event, FaultState, Sample};
use crate::rng::mix;
use crate::time::{Span, Time};

/// How often each corner of synchronisation was met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SyncCorners {
    /// Hard synchronisations.
    pub hard: u64,
    /// Edges in SYNC_SEG.
    pub in_sync_seg: u64,
    /// Positive phase errors below, at and above SJW.
    pub positive: [u64; 3],
    /// Negative phase errors below, at and above SJW.
    pub negative: [u64; 3],
    /// Edges that synchronise nothing.
    pub ignored: u64,
}

impl SyncCorners {
    fn note(&mut self, outcome: SyncOutcome, sjw: u32) {
        let corner = |error: u32| match error.cmp(&sjw) {
            core::cmp::Ordering::Less => 0,
            core::cmp::Ordering::Equal => 1,
            core::cmp::Ordering::Greater => 2,
        };
        match outcome {
            SyncOutcome::Hard => self.hard += 1,
            SyncOutcome::InSyncSeg => self.in_sync_seg += 1,
            SyncOutcome::Lengthened { error, .. } => self.positive[corner(error)] += 1,
            SyncOutcome::Shortened { error, .. } => self.negative[corner(error)] += 1,
            SyncOutcome::Ignored => self.ignored += 1,
        }
    }
}

/// What the bus has to do after a step of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// Nothing.
    Quiet,
    /// TXD changed.
    Txd(Level),
    /// A bit was sampled.
    Sampled(Sample),
}

/// A node of the bus.
#[derive(Debug, Clone)]
pub struct Node {
    config: NodeConfig,
    bit: BitTime,
    rxd: Rxd,
    protocol: Protocol,
    /// TXD of the controller, before a gate.
    txd: Level,
    txd_changed: Time,
    /// When TXD takes the level that protocol control drives; `NEVER` if it has it.
    change_at: Time,
    /// The next edge that may synchronise.
    edge_at: Time,
    /// An edge has synchronised since the last sample point, or none may.
    synchronised: bool,
    /// The last sample.
    last_level: Level,
    /// No edge was on its way to RXD then.
    rxd_is_settled: bool,
    forced_rxd: Option<Level>,
    secondary: Option<SecondarySampling>,
    loop_delay: Span,
    corners: SyncCorners,
    /// Whether bits that nothing can come of may be read late, many at a time.
    late_reading: bool,
    /// Whether edges matter before `next`.
    heeds_edges: bool,
    /// The node's next event.
    due: Time,
    /// When it has to be looked at: at `due`, or later if that is all the same.
    next: Time,
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
            last_level: Level::Recessive,
            rxd_is_settled: false,
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

    pub(crate) fn has_events(&self) -> bool {
        self.protocol.has_events()
    }

    pub(crate) fn take_event(&mut self) -> Option<Event> {
        self.protocol.take_event()
    }

    #[inline]
    fn schedule(&mut self) {
        self.note_due();
        self.next = self.due;
        self.heeds_edges = true;
        if !self.late_reading || self.change_at != Time::NEVER || self.forced_rxd.is_some() {
            return;
        }
        match self.protocol.quiet() {
            Quiet::Anyway(0) | Quiet::WhileRecessive(0) | Quiet::WhileDominant(0) => {}
            Quiet::Anyway(bits) => {
                if let Some(later) = self.bit.before_sample(bits).filter(|at| *at > self.due) {
                    self.next = later;
                    self.heeds_edges = false;
                }
            }
            Quiet::WhileRecessive(bits) => {
                // The last sample was recessive, and no edge is on its way.
                if !self.synchronised && self.edge_at == Time::NEVER && self.config.hears_bus() {
                    self.next = self.bit.sample_after(bits);
                }
            }
            Quiet::WhileDominant(bits) => {
                // The last sample was dominant, and so is the line as long as nobody shorts it.
                let dominant = self.last_level == Level::Dominant && self.rxd_is_settled;
                if dominant && self.config.can_drive() {
                    self.next = self.bit.sample_after(bits);
                    self.heeds_edges = false;
                }
            }
        }
    }

    #[inline]
    fn note_due(&mut self) {
        let own = if self.change_at != Time::NEVER {
            self.change_at
        } else if self.protocol.sleeps() {
            Time::NEVER
        } else {
            self.bit.sample()
        };
        self.due = own.min(self.edge_at);
    }

    /// Allows or forbids late reading; the node has to be up to date.
    pub(crate) fn set_late_reading(&mut self, allowed: bool, log: &EdgeLog) {
        if self.late_reading != allowed {
            self.late_reading = allowed;
            self.rxd_is_settled = self.rxd.is_settled(log);
            self.schedule();
        }
    }

    /// An edge to dominant is on its way from the star point. True if that changes when the node
    /// has to be looked at.
    #[inline]
    pub(crate) fn notice_edge(&mut self, now: Time, log: &EdgeLog) -> bool {
        if !self.heeds_edges || self.synchronised || self.edge_at != Time::NEVER {
            return false;
        }
        self.catch_up(now, log);
        if self.edge_at == Time::NEVER && !self.is_own_edge(now) {
            self.look_for_edge(log);
            self.due = self.due.min(self.edge_at);
            self.next = self.due;
        }
        true
    }

    /// Whether the edge to dominant that leaves the star point now comes in during a dominant bit
    /// of a transmitter: it does nothing, whoever made it.
    #[inline]
    fn is_own_edge(&mut self, now: Time) -> bool {
        let sends = self.late_reading
            && self.txd == Level::Dominant
            && self.change_at == Time::NEVER
            && self.config.tdc == Tdc::Off
            && self.protocol.is_transmitting();
        let latest = self.config.transceiver.to_rxd(now, Level::Dominant, 0)
            + self.config.transceiver.jitter
            + self.config.transceiver.jitter;
        if sends && latest < self.bit.sample() {
            self.synchronised = true;
            self.corners.ignored += 1;
            return true;
        }
        false
    }

    /// Reads what came in before `now` and was not looked at; a sample at `now` itself may be more
    /// than a quiet one and stays due.
    pub(crate) fn catch_up(&mut self, now: Time, log: &EdgeLog) {
        if self.next > self.due {
            self.read_late(now - Span::from_fs(1), log);
        }
    }

    /// All samples up to `now` are quiet ones: they only go into the frame that is being read.
    fn read_late(&mut self, now: Time, log: &EdgeLog) {
        let mut edge = if self.synchronised { Time::NEVER } else { self.rxd.next_dominant(log) };
        let mut changes_at = self.rxd.next_change(log);
        loop {
            let sample = self.bit.sample();
            if edge <= sample {
                if edge > now {
                    break;
                }
                if self.rxd.level_at(log, edge) == Level::Dominant {
                    self.synchronise(edge);
                    edge = Time::NEVER;
                } else {
                    edge = self.rxd.next_dominant(log);
                }
                changes_at = self.rxd.next_change(log);
                continue;
            }
            if sample > now {
                break;
            }
            if sample >= changes_at {
                self.rxd.level_at(log, sample);
                changes_at = self.rxd.next_change(log);
            }
            let level = self.rxd.level();
            self.protocol.read_quiet(level);
            self.bit.advance(self.bit.rate());
            self.last_level = level;
            if level == Level::Dominant {
                self.synchronised = true;
                edge = Time::NEVER;
            } else if self.synchronised {
                self.synchronised = false;
                edge = self.rxd.next_dominant(log);
            }
        }
        self.edge_at = edge;
        self.rxd_is_settled = self.rxd.is_settled(log);
        if self.protocol.drive() != self.txd {
            self.change_at = self.bit.start();
        }
        self.schedule();
    }

    #[inline]
    fn look_for_edge(&mut self, log: &EdgeLog) {
        let deaf = self.forced_rxd.is_some() || !self.config.hears_bus() || self.protocol.is_off();
        self.edge_at = if deaf { Time::NEVER } else { self.rxd.next_dominant(log) };
    }

    /// The node's next event has come.
    #[inline]
    pub(crate) fn step(&mut self, now: Time, log: &EdgeLog) -> Step {
        if self.due < now {
            self.read_late(now - Span::from_fs(1), log);
            if self.next > now {
                return Step::Quiet;
            }
        }
        if self.edge_at <= now {
            self.take_edge(now, log);
            Step::Quiet
        } else if self.change_at <= now {
            self.change_txd(now)
        } else {
            self.take_sample(now, log)
        }
    }

    fn change_txd(&mut self, now: Time) -> Step {
        self.txd = self.protocol.drive();
        self.txd_changed = now;
        self.change_at = Time::NEVER;
        self.schedule();
        Step::Txd(self.txd)
    }

    fn take_edge(&mut self, now: Time, log: &EdgeLog) {
        // The pulse may have been eaten up since.
        if self.forced_rxd.is_none() && self.rxd.level_at(log, now) == Level::Recessive {
            self.look_for_edge(log);
            self.schedule();
            return;
        }
        self.edge_at = Time::NEVER;
        self.synchronise(now);
        self.schedule();
    }

    fn synchronise(&mut self, now: Time) {
        self.synchronised = true;
        if self.protocol.is_transmitting() && self.protocol.is_at_res() {
            self.loop_delay = now.since(self.txd_changed);
        }
        let rule = self.protocol.sync_rule(self.txd);
        let (outcome, position) = self.bit.edge(now, rule);
        let timing = match (self.bit.rate(), &self.config.data) {
            (Rate::Data, Some(data)) => data,
            (Rate::Data, None) | (Rate::Nominal, _) => &self.config.nominal,
        };
        self.corners.note(outcome, timing.sjw());
        if self.change_at != Time::NEVER {
            self.change_at = self.bit.change_after_edge(position);
        }
        self.protocol.wake();
    }

    fn take_sample(&mut self, now: Time, log: &EdgeLog) -> Step {
        let rxd = match self.forced_rxd {
            Some(forced) => forced,
            None if self.config.hears_bus() => self.rxd.level_at(log, now),
            None => Level::Recessive,
        };
        let level = self.config.controller_rxd(self.txd, rxd);
        let late_error = self.secondary.as_mut().map(|s| s.finds_error(log, now));
        let driven = self.txd;
        self.protocol.sample(level, late_error);
        self.bit.advance(self.protocol.rate());
        self.secondary_sampling();
        if self.protocol.drive() != self.txd {
            self.change_at = self.bit.start();
        }
        self.last_level = level;
        self.rxd_is_settled = self.rxd.is_settled(log);
        self.synchronised = level == Level::Dominant;
        self.edge_at = Time::NEVER;
        if !self.synchronised {
            self.look_for_edge(log);
        }
        self.schedule();
        Step::Sampled(Sample { level, driven, busy: self.protocol.is_busy() })
    }

    /// Follows the data phase of a transmitter with TDC: the bit that begins next is to be checked
    /// at the secondary sample point.
    fn secondary_sampling(&mut self) {
        let Tdc::Offset(offset) = self.config.tdc else { return };
        if self.bit.rate() == Rate::Nominal || !self.protocol.is_transmitting() {
            self.secondary = None;
            return;
        }
        let check_at = self.bit.quanta_after(self.bit.start() + self.loop_delay, offset);
        let secondary =
            self.secondary.get_or_insert_with(|| SecondarySampling::new(self.rxd.clone()));
        secondary.sent(self.protocol.drive(), check_at);
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
