//! What a device is, and what it keeps.

use crate::lss::{LssAddress, NodeId, RateSet, RateSetting};

/// Whether a device can find its bit rate by itself (index 9 of the bit timing table).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Automatic {
    /// It can.
    Offered,
    /// It cannot, or must not: the device that starts the network, the "mini-master" of object
    /// 1F80h, has to send while others listen \[Koppe\].
    Refused,
}

/// Node-ID and bit rate of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Configuration {
    /// Node-ID; [`NodeId::UNCONFIGURED`] as delivered.
    pub node_id: NodeId,
    /// Bit rate, or automatic detection.
    pub rate: RateSetting,
}

/// What a device is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SlaveOptions {
    /// Its address, as in object 1018h.
    pub address: LssAddress,
    /// Bit rates that it can be set to.
    pub rates: RateSet,
    /// Whether it can detect the bit rate.
    pub automatic: Automatic,
}

/// Why a configuration was not stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StoreError {
    /// The device cannot store: error code 1.
    NotSupported,
    /// The storage medium cannot be accessed: error code 2.
    Access,
    /// Anything else: error code 255 and this specific error.
    Manufacturer(u8),
}

/// Memory that outlasts power-off.
pub trait Storage {
    /// Keeps `configuration` for the next power-on. Old or new, never a mixture, may be found there
    /// afterwards, even if power fails meanwhile.
    ///
    /// # Errors
    /// [`StoreError`], which the master is told.
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError>;
}
