//! What an interface can be used for, before anything is changed.

use std::fs;
use std::path::Path;
use std::time::Duration;

use canbaud::detect::scan::{Evidence, FdSupport};
use canbaud::units::Bitrate;

use super::netlink::{CanInfo, Link, ctrlmode};
use crate::LinkError;
use crate::adapters::{ListenOnly, WrongRate, driver_of_controller, known};

/// The bit rates of the kernel's slcan driver, which names itself nowhere.
const SLCAN: [u32; 9] =
    [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
/// Nominal bit rates end here [ISO 11898-1].
const NOMINAL_MAX: u32 = 1_000_000;
const ONE: Bitrate = Bitrate::new(1).unwrap();
/// The driver of PEAK USB adapters.
pub(super) const PEAK_USB: &str = "peak_usb";
/// PCAN-USB: its driver switches silent mode only on hardware revisions above 3.
const PCAN_USB: u16 = 0x000C;
const PCAN_USB_SILENT_FROM: u16 = 4;

/// What is known of the device behind an interface.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Device {
    /// The kernel's driver.
    pub(crate) driver: Option<String>,
    /// Product number and release of a USB device.
    pub(crate) usb: Option<(u16, u16)>,
}

impl Device {
    /// Reads it below `sys`, which is `/sys` but for tests; in a container that may be absent, or
    /// tell of an interface of the same name outside.
    pub(crate) fn read(sys: &Path, link: &Link) -> Self {
        let seen = Self::in_sysfs(sys, link);
        let told = by_controller(link);
        match (told, seen.driver.as_deref()) {
            (Some(told), Some(driver)) if !are_alike(told, driver) => {
                Self { driver: Some(told.to_owned()), usb: None }
            }
            (Some(told), None) => Self { driver: Some(told.to_owned()), ..seen },
            (None, None) => Self { driver: by_rates(link), ..seen },
            (_, Some(_)) => seen,
        }
    }

    fn in_sysfs(sys: &Path, link: &Link) -> Self {
        let interface = sys.join("class/net").join(&link.name);
        let index = fs::read_to_string(interface.join("ifindex")).ok();
        if index.and_then(|index| index.trim().parse().ok()) != Some(link.index) {
            return Self::default();
        }
        let device = interface.join("device");
        let driver = fs::read_link(device.join("driver"))
            .ok()
            .and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        let hex = |name| {
            let text = fs::read_to_string(device.join("..").join(name)).ok()?;
            u16::from_str_radix(text.trim(), 16).ok()
        };
        Self { driver, usb: hex("idProduct").zip(hex("bcdDevice")) }
    }

    /// The hardware revision of a PCAN-USB, as its driver reads it.
    const fn pcan_usb_revision(&self) -> Option<u16> {
        match self.usb {
            Some((PCAN_USB, release)) => Some(release >> 8),
            _ => None,
        }
    }
}

/// The driver, by what it calls its controller.
fn by_controller(link: &Link) -> Option<&'static str> {
    driver_of_controller(controller(link.can.as_ref()?))
}

fn controller(can: &CanInfo) -> &str {
    can.timing_const.as_ref().map_or("", |limits| &limits.name)
}

/// Whether both are the same driver, or of a family that behaves alike.
fn are_alike(one: &str, other: &str) -> bool {
    one == other || known(one).is_some_and(|known| known.drivers.contains(&other))
}

/// The driver, where only its rates tell.
fn by_rates(link: &Link) -> Option<String> {
    let can = link.can.as_ref()?;
    (can.bitrates == SLCAN && can.timing_const.is_none()).then(|| "slcan".to_owned())
}

/// What an interface can be used for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Profile {
    /// The kernel's driver, if it is known.
    pub(crate) driver: Option<String>,
    /// The only rates, if not empty.
    pub(crate) rates: Vec<Bitrate>,
    /// Slowest and fastest.
    pub(crate) range: (Bitrate, Bitrate),
    pub(crate) evidence: Evidence,
    pub(crate) fd: FdSupport,
    /// Whether error frames are to be asked for.
    pub(crate) berr_reporting: bool,
    /// How long frames from before a change of rate may come after it.
    pub(crate) settle: Duration,
}

impl Profile {
    /// What `link` can be used for.
    ///
    /// # Errors
    /// Why it cannot.
    pub(crate) fn of(link: &Link, device: &Device) -> Result<Self, LinkError> {
        let can = usable(link)?;
        may_listen(link, can, device)?;
        let berr_reporting = can.supports(ctrlmode::BERR_REPORTING) == Some(true);
        let rates = can.bitrates.iter().filter_map(|rate| Bitrate::new(*rate)).collect();
        let fd = match can.supports(ctrlmode::FD) {
            Some(true) => FdSupport::Fd,
            Some(false) | None => FdSupport::Classic,
        };
        Ok(Self {
            driver: device.driver.clone(),
            rates,
            range: range(can),
            evidence: evidence(can, device, berr_reporting),
            fd,
            berr_reporting,
            settle: settle(device),
        })
    }
}

/// An adapter behind USB or a serial line has a queue of its own, which outlives the controller's;
/// 64 frames cross full-speed USB in 4 ms.
fn settle(device: &Device) -> Duration {
    let driver = device.driver.as_deref().unwrap_or_default();
    let outside =
        driver.contains("usb") || ["slcan", "etas_es58x", "f81604", "ucan"].contains(&driver);
    let queues = device.usb.is_some() || outside;
    Duration::from_millis(if queues { 20 } else { 0 })
}

fn usable(link: &Link) -> Result<&CanInfo, LinkError> {
    let name = link.name.clone();
    match (link.is_can(), &link.can) {
        (false, _) => Err(LinkError::NotCan { name }),
        (true, _) if link.is_virtual() => Err(LinkError::Virtual { name }),
        (true, Some(can)) if can.timing_const.is_some() || !can.bitrates.is_empty() => Ok(can),
        (true, _) => Err(LinkError::NoListenOnly {
            adapter: name,
            reason: "its driver takes neither bit rate nor control mode from the kernel".to_owned(),
        }),
    }
}

fn may_listen(link: &Link, can: &CanInfo, device: &Device) -> Result<(), LinkError> {
    let driver = device.driver.as_deref().unwrap_or("unknown");
    let refuse =
        |reason: String| Err(LinkError::NoListenOnly { adapter: link.name.clone(), reason });
    let known_not = known(driver).is_some_and(|known| known.listen_only == ListenOnly::No);
    match can.supports(ctrlmode::LISTEN_ONLY) {
        Some(false) => return refuse(format!("its driver ({driver}) has no listen-only mode")),
        None if known_not => return refuse(format!("the driver {driver} has no listen-only mode")),
        Some(true) | None => {}
    }
    match device.pcan_usb_revision() {
        Some(revision) if revision < PCAN_USB_SILENT_FROM => refuse(format!(
            "PCAN-USB of hardware revision {revision} has no silent mode, although its driver \
             offers one; revision {PCAN_USB_SILENT_FROM} and later have it"
        )),
        None if driver == PEAK_USB && !is_silent_pcan(can, device) => refuse(
            "the hardware revision of this PEAK adapter cannot be read (is /sys hidden?), and old \
             ones have no silent mode"
                .to_owned(),
        ),
        _ => Ok(()),
    }
}

/// Whether it is a PEAK adapter that is silent in any revision: every one but PCAN-USB.
fn is_silent_pcan(can: &CanInfo, device: &Device) -> bool {
    match controller(can) {
        "pcan_usb" => false,
        name if driver_of_controller(name) == Some(PEAK_USB) => true,
        _ => device.usb.is_some(),
    }
}

fn evidence(can: &CanInfo, device: &Device, berr_reporting: bool) -> Evidence {
    let known = device.driver.as_deref().and_then(known).map(|known| known.wrong_rate);
    match known {
        Some(WrongRate::ErrorFrames) => Evidence::Errors,
        Some(WrongRate::Counter) if can.counters.is_some() => Evidence::Counter,
        Some(WrongRate::Silence) => Evidence::FramesOnly,
        _ if berr_reporting => Evidence::Errors,
        None if can.counters.is_some() => Evidence::Counter,
        _ => Evidence::FramesOnly,
    }
}

/// Slowest and fastest nominal rate that clock and limits make.
fn range(can: &CanInfo) -> (Bitrate, Bitrate) {
    let fastest = match can.bitrate_max {
        0 => NOMINAL_MAX,
        max => max.min(NOMINAL_MAX),
    };
    let slowest = can.clock.zip(can.timing_const.as_ref()).and_then(|(clock, limits)| {
        let quanta = u64::from(limits.tseg1.1) + u64::from(limits.tseg2.1) + 1;
        let clocks = quanta.checked_mul(u64::from(limits.brp.1)).filter(|clocks| *clocks > 0)?;
        u32::try_from(u64::from(clock).div_ceil(clocks)).ok()
    });
    let slowest = slowest.unwrap_or(1).min(fastest);
    (Bitrate::new(slowest).unwrap_or(ONE), Bitrate::new(fastest).unwrap_or(ONE))
}

#[cfg(test)]
mod tests;
