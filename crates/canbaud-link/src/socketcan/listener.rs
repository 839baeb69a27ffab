//! An interface as a controller that only listens.

use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use canbaud::detect::scan::{
    Candidate, Capabilities, Capture, Configured, Controller, Evidence, Observation, RateChoice,
};
use canbaud::units::{Bitrate, Micros};

use super::hear;
use super::netlink::{CanInfo, Change, Link, LinkChange, TimingConst, TimingInfo, ctrlmode};
use super::raw::RawSocket;
use super::restore::Saved;
use super::rtnl::{LinkLayer, Rtnl};
use super::setup::{Device, Profile};
use super::wide::wide;
use crate::{After, Clock, LinkError, Listener};

/// Changing the rate takes 3 to 21 ms with the adapters that were measured; USB may wait.
const RECONFIGURATION: Micros = Micros::from_ms(300);
/// From the adapter through USB and the kernel to here, on a loaded machine.
const LATENCY: Micros = Micros::from_ms(50);
/// How often error counters are asked for.
const POLL: Micros = Micros::from_ms(10);
/// Things heard at once that say nothing about the rate.
const BURST: usize = 64;
/// The driver of serial adapters.
const SLCAN: &str = "slcan";

/// An interface that only listens; put back as it was found when it goes out of use.
#[derive(Debug)]
pub struct SocketCanListener {
    kernel: Box<dyn LinkLayer>,
    link: Link,
    profile: Profile,
    saved: Saved,
    clock: Clock,
    touched: bool,
    /// Whether it was ever set to a rate.
    had_rates: bool,
    configured: Option<Setting>,
    socket: Option<RawSocket>,
    counter: Counter,
}

/// What the interface was set to, as read back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Setting {
    nominal: TimingInfo,
    data: Option<TimingInfo>,
}

/// The receive error counter, for drivers that report no errors.
#[derive(Debug, Default)]
struct Counter {
    due: Micros,
    last: Option<u16>,
}

impl SocketCanListener {
    /// Prepares to listen on the interface `name`; changes nothing yet.
    ///
    /// # Errors
    /// There is no such interface, or it cannot listen without disturbing the bus.
    pub fn open(name: &str, clock: Clock) -> Result<Self, LinkError> {
        Self::on(Box::new(Rtnl::open()?), Path::new("/sys"), name, clock)
    }

    fn on(
        mut kernel: Box<dyn LinkLayer>,
        sys: &Path,
        name: &str,
        clock: Clock,
    ) -> Result<Self, LinkError> {
        let link = kernel.link(name)?;
        let device = Device::read(sys, &link);
        let profile = Profile::of(&link, &device)?;
        let saved = Saved::of(&link);
        Ok(Self {
            kernel,
            link,
            profile,
            saved,
            clock,
            touched: false,
            had_rates: false,
            configured: None,
            socket: None,
            counter: Counter::default(),
        })
    }

    /// The kernel's driver, if it is known.
    #[must_use]
    pub fn driver(&self) -> Option<&str> {
        self.profile.driver.as_deref()
    }

    fn change(&mut self, change: &LinkChange) -> Result<(), LinkError> {
        self.kernel.change(&self.link, change)
    }

    fn read_back(&mut self) -> Result<Link, LinkError> {
        self.kernel.read_back(&self.link.name, self.link.index)
    }

    /// Down, before anything else is changed.
    fn set_down(&mut self) -> Result<(), LinkError> {
        self.socket = None;
        let result = self.change(&LinkChange::only(Change::Down));
        // Without the permission nothing was changed.
        if !matches!(result, Err(LinkError::Permission { .. })) {
            self.touched = true;
        }
        result
    }

    /// Sets rates and mode; what the kernel took is read back, whatever it answered.
    fn set(&mut self, change: &LinkChange) -> Result<Setting, LinkError> {
        let result = self.change(change);
        let link = self.read_back()?;
        result?;
        self.setting_of(&link)
    }

    fn not_taken(&self, what: impl Into<String>, got: impl Into<String>) -> LinkError {
        let adapter = self.link.name.clone();
        LinkError::NotTaken { adapter, what: what.into(), got: got.into() }
    }

    fn setting_of(&self, link: &Link) -> Result<Setting, LinkError> {
        let can = link.can.clone().unwrap_or_default();
        if can.ctrlmode & ctrlmode::LISTEN_ONLY == 0 {
            return Err(self.not_taken("listen-only", format!("control mode {:#x}", can.ctrlmode)));
        }
        let fd = can.ctrlmode & ctrlmode::FD != 0;
        match can.set_timing() {
            Some(nominal) => Ok(Setting { nominal, data: can.set_data_timing().filter(|_| fd) }),
            None => Err(self.not_taken("a bit rate", "none")),
        }
    }

    /// Mask and values of the control mode for a scan.
    fn mode(&self, can: &CanInfo, data: Option<Bitrate>) -> (u32, u32) {
        let mut values = can.ctrlmode & !TDC & !NOT_WHILE_LISTENING | ctrlmode::LISTEN_ONLY;
        if self.profile.berr_reporting {
            values |= ctrlmode::BERR_REPORTING;
        }
        if data.is_some() {
            values |= ctrlmode::FD;
        }
        // Bits that stay set are named, too: drivers with fixed ones insist on it.
        ((can.ctrlmode | values) & !TDC, values)
    }

    /// Moves the sample point to the middle and takes the largest SJW.
    fn widen(&mut self, setting: Setting, limits: &TimingConst) -> Result<Setting, LinkError> {
        let Some(nominal) = wide(setting.nominal, limits) else { return Ok(setting) };
        let change = LinkChange { timing: Some(nominal), ..LinkChange::default() };
        self.set(&change)
    }

    fn poll_counter(&mut self, now: Micros) -> Result<Option<Observation>, LinkError> {
        if self.profile.evidence != Evidence::Counter || now < self.counter.due {
            return Ok(None);
        }
        self.counter.due = now + POLL;
        let link = self.read_back()?;
        let count = link.can.and_then(|can| can.counters).map(|counters| counters.receive);
        if count == self.counter.last {
            return Ok(None);
        }
        self.counter.last = count;
        Ok(count.map(Observation::ReceiveErrors))
    }

    /// Hears what comes, once the kernel confirms that it listens as it was set.
    fn listen(&mut self, setting: Setting) -> Result<(), LinkError> {
        let after = self.read_back()?;
        if !matches!(self.setting_of(&after), Ok(real) if real == setting) || !after.flags.is_up() {
            return Err(self.state("somebody else changed the interface during the scan"));
        }
        self.socket = Some(RawSocket::open(&self.link.name, self.link.index)?);
        self.settle()?;
        self.counter = Counter { due: self.clock.now(), last: None };
        Ok(())
    }

    /// Throws away what the adapter still had in its queue.
    fn settle(&mut self) -> Result<(), LinkError> {
        let end = Instant::now() + self.profile.settle;
        let Some(socket) = &self.socket else { return Ok(()) };
        let drain = || loop {
            while socket.receive()?.is_some() && Instant::now() < end {}
            match end.checked_duration_since(Instant::now()) {
                None | Some(Duration::ZERO) => return Ok(()),
                Some(left) => socket.wait(left)?,
            }
        };
        drain().map_err(|error| self.broken(error))
    }

    /// Why the socket does not work any more.
    fn broken(&mut self, error: io::Error) -> LinkError {
        match self.read_back() {
            Ok(link) if !link.flags.is_up() => LinkError::State {
                adapter: self.link.name.clone(),
                what: "somebody else set the interface down during the scan",
            },
            Ok(_) => LinkError::io(format!("cannot read from {}", self.link.name), error),
            Err(error) => error,
        }
    }

    fn state(&self, what: &'static str) -> LinkError {
        LinkError::State { adapter: self.link.name.clone(), what }
    }
}

const TDC: u32 = ctrlmode::TDC_AUTO | ctrlmode::TDC_MANUAL;
/// Own frames are not heard, and nothing is acknowledged by anybody else's leave; FD as wanted.
const NOT_WHILE_LISTENING: u32 = ctrlmode::LOOPBACK | ctrlmode::PRESUME_ACK | ctrlmode::FD;

/// A bit rate that the kernel makes a bit timing for.
fn rate_alone(rate: Bitrate) -> TimingInfo {
    TimingInfo { bitrate: rate.bits_per_second(), ..TimingInfo::default() }
}

impl Controller for SocketCanListener {
    type Error = LinkError;

    fn capabilities(&self) -> Capabilities<'_> {
        let (slowest, fastest) = self.profile.range;
        let rates = match self.profile.rates.as_slice() {
            [] => RateChoice::Between(slowest, fastest),
            only => RateChoice::Only(only),
        };
        Capabilities {
            rates,
            evidence: self.profile.evidence,
            fd: self.profile.fd,
            reconfiguration: RECONFIGURATION,
            latency: LATENCY,
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, LinkError> {
        self.configured = None;
        self.set_down()?;
        let can = self.read_back()?.can.unwrap_or_default();
        let change = LinkChange {
            timing: Some(rate_alone(candidate.nominal)),
            data_timing: candidate.data.map(rate_alone),
            ctrlmode: Some(self.mode(&can, candidate.data)),
            ..LinkChange::default()
        };
        let mut setting = self.set(&change)?;
        if let (Capture::Wide, Some(limits)) = (candidate.capture, &can.timing_const) {
            setting = self.widen(setting, limits)?;
        }
        self.had_rates = true;
        self.configured = Some(setting);
        let rate = |timing: TimingInfo| Bitrate::new(timing.bitrate);
        match rate(setting.nominal) {
            Some(nominal) => Ok(Configured { nominal, data: setting.data.and_then(rate) }),
            None => Err(self.not_taken("a bit rate", "none")),
        }
    }

    fn start_monitoring(&mut self) -> Result<(), LinkError> {
        let Some(setting) = self.configured else {
            return Err(self.state("it listens only behind being configured"));
        };
        // Whoever else changes the interface must not make it take part in the traffic.
        let before = self.read_back()?;
        if before.flags.is_up() || self.setting_of(&before)? != setting {
            return Err(self.state("somebody else changed the interface during the scan"));
        }
        let up = self.change(&LinkChange::only(Change::Up)).and_then(|()| self.listen(setting));
        if up.is_err() {
            // Whatever it was set to by then, down it drives nothing.
            let _ = self.set_down();
        }
        up
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, LinkError> {
        // Frames that say nothing must not keep the scan from its clock.
        for _ in 0..BURST {
            let Some(socket) = &self.socket else {
                return Err(self.state("it hears only while it listens"));
            };
            match socket.receive() {
                Ok(Some(heard)) => {
                    if let Some(observation) = hear::observation(self.driver(), heard, now) {
                        return Ok(Some(observation));
                    }
                }
                Ok(None) => return self.poll_counter(now),
                Err(error) => return Err(self.broken(error)),
            }
        }
        Ok(None)
    }

    fn stop(&mut self) -> Result<(), LinkError> {
        self.configured = None;
        self.set_down()
    }
}

impl Listener for SocketCanListener {
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError> {
        let timeout = match self.profile.evidence {
            Evidence::Counter => timeout.min(Duration::from_micros(POLL.0)),
            Evidence::Errors | Evidence::FramesOnly => timeout,
        };
        match &self.socket {
            Some(socket) => socket.wait(timeout).map_err(|error| self.broken(error)),
            None => {
                std::thread::sleep(timeout);
                Ok(())
            }
        }
    }

    fn describe(&self) -> String {
        match self.driver() {
            Some(driver) => format!("{} ({driver})", self.link.name),
            None => self.link.name.clone(),
        }
    }

    fn remarks(&self) -> Vec<String> {
        let name = &self.link.name;
        let mut remarks = Vec::new();
        if self.saved.was_up() {
            let rate = self.saved.bitrate().and_then(Bitrate::new);
            let rate = rate.map_or_else(String::new, |rate| format!(" at {rate}bit/s"));
            remarks.push(format!(
                "{name} was up{rate}: it is taken down for the scan, programs that use it notice, \
                 and it is put back afterwards"
            ));
        }
        if self.driver() == Some(SLCAN) {
            remarks.push(format!(
                "{name} is a serial adapter whose answers its driver does not read: one without \
                 listen-only stays closed, which looks like a silent bus; without slcand, \
                 canbaud detect slcan:/dev/tty... asks the adapter itself"
            ));
        }
        if self.saved.bitrate().is_none() && self.saved.ctrlmode() & ctrlmode::LISTEN_ONLY == 0 {
            remarks.push(format!(
                "{name} had no bit rate: Linux cannot take one away again, so the last one tried \
                 stays set, with the interface down"
            ));
        }
        remarks
    }

    fn keep(&mut self, candidate: &Candidate, after: After) -> Result<(), LinkError> {
        Controller::configure(self, candidate)?;
        let can = self.read_back()?.can.unwrap_or_default();
        // What the scan switched for itself goes back; the mode is as the user asked.
        let mut own = ctrlmode::BERR_REPORTING;
        let mut values = can.ctrlmode & !TDC;
        if after == After::Normal {
            own |= ctrlmode::LOOPBACK | ctrlmode::PRESUME_ACK;
            values &= !ctrlmode::LISTEN_ONLY;
        }
        values = values & !own | self.saved.ctrlmode() & own;
        let mask = (can.ctrlmode | values) & !TDC;
        self.change(&LinkChange { ctrlmode: Some((mask, values)), ..LinkChange::default() })?;
        self.change(&LinkChange::only(Change::Up))?;
        self.touched = false;
        Ok(())
    }

    fn by_hand(&self) -> Option<String> {
        Some(self.saved.by_hand(&self.link.name))
    }

    fn left_over(&self) -> Option<&'static str> {
        let rate = "it had no bit rate, and Linux cannot take away the one tried last";
        (self.saved.bitrate().is_none() && self.had_rates).then_some(rate)
    }

    fn restore(&mut self) -> Result<(), LinkError> {
        self.socket = None;
        self.configured = None;
        if !self.touched {
            return Ok(());
        }
        let done =
            self.read_back().and_then(|now| self.saved.clone().restore(&mut *self.kernel, &now));
        // What the kernel refused once it may grant once more; the rest would go the same way.
        self.touched = matches!(done, Err(LinkError::Io { .. }));
        done
    }
}

impl Drop for SocketCanListener {
    fn drop(&mut self) {
        // On a way out that already has something else to say.
        let _ = self.restore();
    }
}

#[cfg(test)]
mod tests;
