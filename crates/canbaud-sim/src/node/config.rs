//! How a node is set up.

use canbaud::units::Permille;
use canbaud::wire::{FdCrc, Level};

use crate::bus::Transceiver;
use crate::clock::{Clock, ClockError};
use crate::timing::{BitTiming, TimingError};

/// Operating mode of a controller [ISO 11898-1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Mode {
    /// Takes part.
    #[default]
    Normal,
    /// Bus monitoring (listen-only): never drives the bus; what it would drive it hears itself.
    BusMonitoring,
    /// Restricted operation: acknowledges, but sends no frame and no flag; an error makes it wait
    /// for an idle bus.
    Restricted,
    /// Internal loopback: hears itself alone, acknowledges itself, drives nothing.
    Loopback,
    /// Switched off.
    Disabled,
}

/// What a controller makes of FDF.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FdSupport {
    /// CAN 2.0: the bit is reserved and either level is taken; a CAN FD frame ends in an error.
    None,
    /// A recessive FDF is a protocol exception: waits for the bus to become idle.
    Tolerant,
    /// Sends and receives CAN FD frames.
    #[default]
    Enabled,
}

/// What becomes of a frame after an error or a lost arbitration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Retransmission {
    /// Sent again until it succeeds.
    #[default]
    Automatic,
    /// Dropped (one-shot).
    OneShot,
}

/// What a node does in bus-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Recovery {
    /// Counts 128 x 11 recessive bits and comes back.
    #[default]
    Automatic,
    /// Stays, until it is set up anew.
    Manual,
}

/// Whether the error counters move in bus monitoring mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum MonitoringCounters {
    /// They stay as they are.
    #[default]
    Frozen,
    /// They count as a receiver's do; the node stays error active.
    Counting,
}

/// The secondary sample point of a transmitter in the data phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Tdc {
    /// Bits are checked at the ordinary sample point.
    #[default]
    Off,
    /// Checked this many data quanta after the measured loop delay.
    Offset(u32),
}

/// The gate circuit for controllers without bus monitoring [Koppe, figure 2].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Gate {
    /// No such circuit.
    #[default]
    Absent,
    /// "Listen-Only" pin high: TXD passes.
    Open,
    /// "Listen-Only" pin low: the transceiver's TXD is recessive, RXD is dominant when the bus or
    /// the controller's own TXD is.
    Closed,
}

impl Gate {
    /// What the transceiver is given when the controller drives `txd`.
    #[must_use]
    pub const fn transceiver_txd(self, txd: Level) -> Level {
        match self {
            Self::Absent | Self::Open => txd,
            Self::Closed => Level::Recessive,
        }
    }

    /// What the controller reads when it drives `txd` and the transceiver says `rxd`
    /// [Koppe, table 3].
    #[must_use]
    pub const fn controller_rxd(self, txd: Level, rxd: Level) -> Level {
        match (self, txd, rxd) {
            (Self::Absent, _, rxd) => rxd,
            (Self::Open | Self::Closed, Level::Recessive, Level::Recessive) => Level::Recessive,
            (Self::Open | Self::Closed, ..) => Level::Dominant,
        }
    }
}

/// Whether the node hangs on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Wire {
    /// Connected.
    #[default]
    Connected,
    /// Both lines cut: reads recessive, drives nothing.
    Cut,
}

/// A clock's nominal frequency and its deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Oscillator {
    /// Nominal frequency, 1 kHz to 1 GHz.
    pub hertz: u64,
    /// How much faster it runs, in parts per billion.
    pub ppb: i64,
}

impl Oscillator {
    /// Whether there is such an oscillator.
    ///
    /// # Errors
    /// [`ClockError`] that says what is out of range.
    pub fn check(self) -> Result<(), ClockError> {
        Clock::new(self.hertz, self.ppb).map(|_| ())
    }
}

/// A node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeConfig {
    /// For people.
    pub name: String,
    /// Its clock.
    pub oscillator: Oscillator,
    /// Nominal bit timing.
    pub nominal: BitTiming,
    /// Data bit timing; the nominal one if there is none.
    pub data: Option<BitTiming>,
    /// Operating mode.
    pub mode: Mode,
    /// CAN FD or not.
    pub fd: FdSupport,
    /// Which CRC its CAN FD frames have.
    pub fd_crc: FdCrc,
    /// Transmitter delay compensation.
    pub tdc: Tdc,
    /// Retransmission.
    pub retransmission: Retransmission,
    /// Bus-off recovery.
    pub recovery: Recovery,
    /// Error counters in bus monitoring mode.
    pub monitoring_counters: MonitoringCounters,
    /// The gate circuit.
    pub gate: Gate,
    /// The transceiver and the wire to the star point.
    pub transceiver: Transceiver,
    /// Connected or not.
    pub wire: Wire,
}

impl NodeConfig {
    /// A node of `bitrate` and sample point 87.5 % with an 80 MHz clock that is exact, everything
    /// else by default.
    ///
    /// ```
    /// use canbaud_sim::NodeConfig;
    /// let node = NodeConfig::at("engine", 500_000).unwrap();
    /// assert_eq!(node.nominal.quanta(), 16);
    /// ```
    ///
    /// # Errors
    /// [`TimingError`] if the clock cannot make the rate.
    pub fn at(name: &str, bitrate: u32) -> Result<Self, TimingError> {
        let oscillator = Oscillator { hertz: 80_000_000, ppb: 0 };
        let sample_point = Permille::new(875).unwrap_or_default();
        let nominal = BitTiming::find(oscillator.hertz, bitrate, sample_point)?;
        Ok(Self {
            name: name.to_owned(),
            oscillator,
            nominal,
            data: None,
            mode: Mode::default(),
            fd: FdSupport::default(),
            fd_crc: FdCrc::Iso,
            tdc: Tdc::default(),
            retransmission: Retransmission::default(),
            recovery: Recovery::default(),
            monitoring_counters: MonitoringCounters::default(),
            gate: Gate::default(),
            transceiver: Transceiver::default(),
            wire: Wire::default(),
        })
    }

    /// The same node with another name.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        name.clone_into(&mut self.name);
        self
    }

    /// The same node with another mode.
    #[must_use]
    pub const fn with_mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// The same node with a clock that runs `ppb` parts per billion fast.
    #[must_use]
    pub const fn with_ppb(mut self, ppb: i64) -> Self {
        self.oscillator.ppb = ppb;
        self
    }

    /// The same node with a data bit rate, sample point 80 %, and the nominal timing in quanta of
    /// the same length, if that is possible.
    ///
    /// # Errors
    /// [`TimingError`] if the clock cannot make the rate.
    pub fn with_data_bitrate(mut self, bitrate: u32) -> Result<Self, TimingError> {
        let sample_point = Permille::new(800).unwrap_or_default();
        let data = BitTiming::find(self.oscillator.hertz, bitrate, sample_point)?;
        self.nominal = self.nominal.with_prescaler(data.prescaler()).unwrap_or(self.nominal);
        self.data = Some(data);
        Ok(self)
    }

    /// Whether a dominant level of this node can reach the bus at all.
    #[must_use]
    pub const fn can_drive(&self) -> bool {
        matches!(self.mode, Mode::Normal | Mode::Restricted)
            && matches!(self.wire, Wire::Connected)
            && matches!(self.gate.transceiver_txd(Level::Dominant), Level::Dominant)
    }

    /// What the controller reads when it drives `txd` and the bus says `rxd`.
    #[must_use]
    pub const fn controller_rxd(&self, txd: Level, rxd: Level) -> Level {
        match (self.mode, txd) {
            // Rerouted inside the controller.
            (Mode::BusMonitoring | Mode::Loopback, Level::Dominant) => Level::Dominant,
            _ => self.gate.controller_rxd(txd, rxd),
        }
    }

    /// Whether the controller hears the bus.
    #[must_use]
    pub const fn hears_bus(&self) -> bool {
        matches!(self.mode, Mode::Normal | Mode::BusMonitoring | Mode::Restricted)
            && matches!(self.wire, Wire::Connected)
    }
}
