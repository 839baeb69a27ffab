//! What a device is made of.

use canbaud::detect::scan::{Capabilities, Evidence, FdSupport, RateChoice};
use canbaud::lss::{Automatic, LssAddress, NodeId, RateSetting};
use canbaud::node::{Means, Settings};
use canbaud::units::{Bitrate, Hertz, Micros, Timebase};
use canbaud_sim::Span;
use canbaud_sim::software::LssStorage;

use crate::time::FS_PER_US;

/// How a device can listen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listener {
    /// Its controller has bus monitoring, and says so much.
    Monitoring(Evidence),
    /// Its controller has none, but the gate circuit of Koppe stands before it.
    Gate,
    /// Its controller can only take part or be off; the timer has to do.
    None,
}

/// What a device is made of, and how it is set.
#[derive(Debug, Clone)]
pub struct DeviceConfig {
    /// For people.
    pub name: String,
    /// Its node-ID.
    pub node_id: NodeId,
    /// Frequency of its controller's clock.
    pub clock_hz: u64,
    /// How much faster its clocks run.
    pub ppb: i64,
    /// The capture timer, if it has one.
    pub timer_hz: Option<u64>,
    /// How its controller listens.
    pub listener: Listener,
    /// T_cc: off, new timing, on again.
    pub reconfiguration: Span,
    /// How it is set; [`Settings::means`] is made from what stands above.
    pub settings: Settings,
    /// Time between two process data objects while it is operational.
    pub pdo: Option<Span>,
    /// Time between two SYNC messages, if it is their producer.
    pub sync: Option<Span>,
    /// Its LSS address, if it is an LSS slave.
    pub lss: Option<LssAddress>,
    /// Whether LSS may set it to index 9; a mini-master refuses it in any case.
    pub lss_automatic: Automatic,
    /// From the reception of an LSS command until the answer waits in the controller.
    pub lss_processing: Span,
    /// What comes of "store configuration".
    pub lss_storage: LssStorage,
}

/// The lowest and the highest rate of CANopen.
const RANGE: (u32, u32) = (10_000, 1_000_000);

impl DeviceConfig {
    /// A device with everything: bus monitoring that reports errors, an 8 MHz timer, and automatic
    /// detection.
    #[must_use]
    pub fn automatic(id: u8) -> Self {
        let node_id = NodeId::new(id).unwrap_or(NodeId::UNCONFIGURED);
        let mut config = Self {
            name: format!("node-{id}"),
            node_id,
            clock_hz: 16_000_000,
            ppb: 0,
            timer_hz: Some(8_000_000),
            listener: Listener::Monitoring(Evidence::Errors),
            reconfiguration: Span::from_us(100),
            settings: Settings::automatic(
                node_id,
                Means::Timer(Timebase::from_frequency(hertz(8_000_000))),
            ),
            pdo: None,
            sync: None,
            lss: None,
            lss_automatic: Automatic::Offered,
            lss_processing: Span::ZERO,
            lss_storage: LssStorage::Works,
        };
        config.settings.means = config.means();
        config
    }

    /// The device that knows its rate, starts the others, and sends SYNC.
    #[must_use]
    pub fn mini_master(id: u8, bitrate: u32, sync: Span) -> Self {
        let mut config = Self::automatic(id);
        config.name = "manager".into();
        config.settings.startup = canbaud::node::Startup::MiniMaster;
        config.settings.rate = fixed(bitrate);
        config.sync = Some(sync);
        config
    }

    /// The same device with its rate set by hand.
    #[must_use]
    pub fn fixed(mut self, bitrate: u32) -> Self {
        self.settings.rate = fixed(bitrate);
        self
    }

    /// The same device as an LSS slave.
    #[must_use]
    pub const fn with_lss(mut self, address: LssAddress) -> Self {
        self.lss = Some(address);
        self
    }

    /// The same device with another way to listen and another timer.
    #[must_use]
    pub fn with(mut self, listener: Listener, timer_hz: Option<u64>) -> Self {
        (self.listener, self.timer_hz) = (listener, timer_hz);
        self.settings.means = self.means();
        self
    }

    /// The means that timer and listener make.
    fn means(&self) -> Means {
        let timebase = self.timer_hz.map(|hz| Timebase::from_frequency(hertz(hz)));
        let evidence = match self.listener {
            Listener::Monitoring(evidence) => evidence,
            Listener::Gate | Listener::None => Evidence::Errors,
        };
        let rate = |bits| Bitrate::new(bits).unwrap_or(Settings::CANOPEN_RATES[0]);
        match (timebase, self.listener) {
            (Some(timebase), Listener::None) => Means::Timer(timebase),
            (Some(timebase), _) => Means::Both(timebase),
            (None, _) => Means::Controller(Capabilities {
                rates: RateChoice::Between(rate(RANGE.0), rate(RANGE.1)),
                evidence,
                fd: FdSupport::Classic,
                reconfiguration: Micros(self.reconfiguration.femtoseconds() / FS_PER_US),
                latency: Micros(0),
            }),
        }
    }
}

fn fixed(bitrate: u32) -> RateSetting {
    Bitrate::new(bitrate).map_or(RateSetting::Automatic, RateSetting::Fixed)
}

fn hertz(hz: u64) -> Hertz {
    Hertz::new(hz).unwrap_or(Hertz::MAX)
}
