//! CAN interfaces of Linux; nothing is changed.

use std::path::Path;

use canbaud::detect::scan::{Evidence, FdSupport};
use canbaud::units::Bitrate;

use super::{KnownDriver, known};
use crate::LinkError;
use crate::socketcan::netlink::{Link, ctrlmode};
use crate::socketcan::{Device, Profile, Rtnl};

/// A CAN interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InterfaceAdapter {
    /// Its name.
    pub name: String,
    /// The kernel's driver, if it is known.
    pub driver: Option<String>,
    /// What is known of that.
    pub known: Option<&'static KnownDriver>,
    /// Whether it is set up.
    pub up: bool,
    /// What it is set to.
    pub bitrate: Option<u32>,
    /// Whether it listens only, as it is set now.
    pub listens: bool,
    /// What a scan could do with it, or why none can.
    pub usable: Result<InterfaceUse, String>,
}

/// What a scan can do with an interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InterfaceUse {
    /// What it tells of a wrong rate.
    pub evidence: Evidence,
    /// CAN FD.
    pub fd: FdSupport,
    /// The only rates, if not empty.
    pub rates: Vec<Bitrate>,
    /// Slowest and fastest.
    pub range: (Bitrate, Bitrate),
}

/// The CAN interfaces of this machine.
///
/// # Errors
/// Whatever the system says.
pub fn interface_adapters() -> Result<Vec<InterfaceAdapter>, LinkError> {
    let links = Rtnl::open()?.links()?;
    Ok(links.iter().filter(|link| link.is_can()).map(InterfaceAdapter::of).collect())
}

impl InterfaceAdapter {
    fn of(link: &Link) -> Self {
        let device = Device::read(Path::new("/sys"), link);
        let usable = Profile::of(link, &device).map_err(|error| error.to_string());
        let can = link.can.as_ref();
        Self {
            name: link.name.clone(),
            known: device.driver.as_deref().and_then(known),
            driver: device.driver.or_else(|| link.kind.clone().filter(|kind| kind != "can")),
            up: link.flags.is_up(),
            bitrate: can.and_then(|can| can.set_timing()).map(|timing| timing.bitrate),
            listens: can.is_some_and(|can| can.ctrlmode & ctrlmode::LISTEN_ONLY != 0),
            usable: usable.map(|profile| InterfaceUse {
                evidence: profile.evidence,
                fd: profile.fd,
                rates: profile.rates,
                range: profile.range,
            }),
        }
    }
}
