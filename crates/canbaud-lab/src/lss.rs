//! The LSS slave of a device.

use canbaud::lss::{Automatic, Configuration, LssAddress, RateSet, Slave, SlaveOptions};
use canbaud::node::{Settings, Startup};

/// What LSS has stored.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StoredConfiguration(pub(crate) Option<Configuration>);

impl canbaud::lss::Storage for StoredConfiguration {
    fn store(&mut self, configuration: Configuration) -> Result<(), canbaud::lss::StoreError> {
        self.0 = Some(configuration);
        Ok(())
    }
}

/// A slave as at power-on.
pub(crate) fn slave(address: LssAddress, settings: &Settings) -> Slave {
    let automatic = match settings.startup {
        Startup::Slave => Automatic::Offered,
        Startup::MiniMaster => Automatic::Refused,
    };
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic };
    Slave::new(options, Configuration { node_id: settings.node_id, rate: settings.rate })
}
