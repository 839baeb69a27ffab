//! What a device has, and how it is set.

use core::fmt;

use crate::detect::scan::Capabilities;
use crate::lss::{NodeId, RateSetting};
use crate::timing::tables::CANOPEN;
use crate::units::{Bitrate, Micros, Timebase};

/// Object 1F80h, NMT start-up \[CiA 302-2\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Startup {
    /// Waits for an NMT master.
    #[default]
    Slave,
    /// Goes to operational by itself and starts the others. It must know its bit rate: were it to
    /// wait for traffic, the network would never start \[Koppe\].
    MiniMaster,
}

impl Startup {
    /// What the value of object 1F80h says: bit 0 makes the device the NMT master.
    #[must_use]
    pub const fn from_1f80(value: u32) -> Self {
        if value & 1 == 1 { Self::MiniMaster } else { Self::Slave }
    }
}

/// What the device can look for the bit rate with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Means {
    /// A timer that captures the edges of RXD, and a controller that cannot listen without taking
    /// part \[AP2925 1.2\]: measures, then takes part with care.
    Timer(Timebase),
    /// A controller with bus monitoring or a gate circuit \[AP2925 1.1, Koppe\]: scans.
    Controller(Capabilities<'static>),
    /// Both: measures, sets the controller, lets it confirm in silence, and only then takes part.
    Both(Timebase),
}

/// What to do on a bus without any traffic.
///
/// If all nodes wait, nobody ever talks. Breaking the silence is a risk that the user takes: the
/// rate is a guess, and somebody who begins to talk at another one in that moment is disturbed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Silence {
    /// Waits for traffic for ever. (A frame that nobody acknowledges within a second sends a node
    /// back to listening in any case.)
    #[default]
    Wait,
    /// After `after`, and a random time up to `spread`, without any sign of life takes part at the
    /// rate that was right last, and sends the boot-up message. If nobody has acknowledged it
    /// within `hold`, or with the first error, it listens again; the next time it waits twice as
    /// long, up to 64 times.
    Break {
        /// Where no rate was right yet.
        default: Bitrate,
        /// How long to wait at least.
        after: Micros,
        /// How much longer at random, so that nodes do not break the silence together.
        spread: Micros,
        /// How long to wait for an acknowledgement.
        hold: Micros,
    },
}

/// How a node is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Its node-ID; without one ([`NodeId::UNCONFIGURED`]) it takes part in LSS only.
    pub node_id: NodeId,
    /// One bit rate, or index 9.
    pub rate: RateSetting,
    /// Object 1F80h.
    pub startup: Startup,
    /// What it looks for the rate with.
    pub means: Means,
    /// The rates that it can be set to, in the order in which they are tried.
    pub rates: &'static [Bitrate],
    /// What it does on a silent bus.
    pub silence: Silence,
    /// Time between two heartbeats; `None` for no heartbeat.
    pub heartbeat: Option<Micros>,
    /// A number of this device alone (its serial number), for random waits.
    pub seed: u64,
}

/// Why a node cannot be set like that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SettingsError {
    /// A mini-master (object 1F80h) must not detect its bit rate.
    MiniMasterAutomatic,
    /// There is no rate that it may be set to.
    NoRates,
    /// There are more rates than the node has room for.
    TooManyRates {
        /// How many there may be: the parameter `R` of [`super::Node`].
        room: usize,
    },
    /// This rate is none that it may be set to.
    NotOneOfTheRates(Bitrate),
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MiniMasterAutomatic => {
                f.write_str("a mini-master (object 1F80h) needs a fixed bit rate: with automatic detection the network would never start")
            }
            Self::NoRates => f.write_str("there is no bit rate to choose from"),
            Self::TooManyRates { room } => write!(f, "more than {room} bit rates"),
            Self::NotOneOfTheRates(rate) => {
                write!(f, "{rate}bit/s is none of the bit rates of this device")
            }
        }
    }
}

impl core::error::Error for SettingsError {}

/// Evaluated while compiling: a row that is no rate does not build.
const CANOPEN_RATES: [Bitrate; CANOPEN.len()] = {
    let Some(mut rates) = repeat(CANOPEN[0].bits_per_second) else { panic!("no rate") };
    let mut at = 0;
    while at < rates.len() {
        let Some(rate) = Bitrate::new(CANOPEN[at].bits_per_second) else { panic!("no rate") };
        rates[at] = rate;
        at += 1;
    }
    rates
};

const fn repeat(bits_per_second: u32) -> Option<[Bitrate; CANOPEN.len()]> {
    match Bitrate::new(bits_per_second) {
        Some(rate) => Some([rate; CANOPEN.len()]),
        None => None,
    }
}

impl Settings {
    /// The bit rates of table 1 of Koppe, from fast to slow: a receiver that is too fast notices
    /// sooner than one that is too slow.
    pub const CANOPEN_RATES: &'static [Bitrate] = &CANOPEN_RATES;

    /// An ordinary device with automatic detection: all CANopen rates, waits for traffic, heartbeat
    /// once a second.
    #[must_use]
    pub const fn automatic(node_id: NodeId, means: Means) -> Self {
        Self {
            node_id,
            rate: RateSetting::Automatic,
            startup: Startup::Slave,
            means,
            rates: Self::CANOPEN_RATES,
            silence: Silence::Wait,
            heartbeat: Some(Micros::from_ms(1000)),
            seed: node_id.get() as u64,
        }
    }

    /// Whether a node can be set like that; gives the rate to begin with where none is remembered.
    ///
    /// # Errors
    /// [`SettingsError`] says what cannot be.
    pub fn check(&self) -> Result<Bitrate, SettingsError> {
        if self.rates.is_empty() {
            return Err(SettingsError::NoRates);
        }
        if self.rate == RateSetting::Automatic && self.startup == Startup::MiniMaster {
            return Err(SettingsError::MiniMasterAutomatic);
        }
        let first = self.first_rate();
        if self.rates.contains(&first) {
            Ok(first)
        } else {
            Err(SettingsError::NotOneOfTheRates(first))
        }
    }

    /// The fixed rate, the one to break the silence with, or the first of the list.
    pub(super) const fn first_rate(&self) -> Bitrate {
        match (self.rate, self.silence, self.rates) {
            (RateSetting::Fixed(rate), ..) => rate,
            (RateSetting::Automatic, Silence::Break { default, .. }, _) => default,
            (RateSetting::Automatic, Silence::Wait, [first, ..]) => *first,
            // Refused by `check`.
            (RateSetting::Automatic, Silence::Wait, []) => CANOPEN_RATES[0],
        }
    }

    /// Whether it may leave its rate when that does not fit.
    pub(super) const fn may_detect(&self) -> bool {
        matches!(self.startup, Startup::Slave)
    }
}
