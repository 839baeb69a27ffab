//! The LSS slave of a device.

use canbaud::lss::{
    Automatic, Configuration, LssAddress, RateSet, Slave, SlaveOptions, StoreError,
};
use canbaud::node::{Settings, Startup};
use canbaud_sim::software::LssStorage;

use crate::config::DeviceConfig;

/// What LSS has stored, and whether it can store.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StoredConfiguration {
    pub(crate) kept: Option<Configuration>,
    pub(crate) storage: LssStorage,
}

impl canbaud::lss::Storage for StoredConfiguration {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        self.storage.check()?;
        self.kept = Some(configuration);
        Ok(())
    }
}

/// A slave as at power-on.
pub(crate) fn slave(address: LssAddress, config: &DeviceConfig, settings: &Settings) -> Slave {
    let automatic = match settings.startup {
        Startup::Slave => config.lss_automatic,
        Startup::MiniMaster => Automatic::Refused,
    };
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic };
    Slave::new(options, Configuration { node_id: settings.node_id, rate: settings.rate })
}
