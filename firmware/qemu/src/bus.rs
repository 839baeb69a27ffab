//! A bus in memory with a controller on it that can only listen.

use canbaud::detect::scan::{
    Candidate, Capabilities, Configured, Controller, ErrorClass, ErrorPlace, ErrorSeen, Evidence,
    FdSupport, FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};

/// What a controller hears on a bus on which somebody sends a frame every 2 ms, at one rate.
#[derive(Debug)]
pub struct MemoryController {
    bus: Bitrate,
    configured: Option<Bitrate>,
    monitoring: bool,
    last: Micros,
    count: u8,
}

/// The controller was used in a way that the hardware would refuse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotStopped;

/// What the controller can do: 10 kbit/s to 1 Mbit/s, and it tells errors.
pub const CAPABILITIES: Capabilities<'static> = Capabilities {
    rates: RateChoice::Between(rate(10_000), rate(1_000_000)),
    evidence: Evidence::Errors,
    fd: FdSupport::Classic,
    reconfiguration: Micros(500),
    latency: Micros(0),
};

const fn rate(bits_per_second: u32) -> Bitrate {
    match Bitrate::new(bits_per_second) {
        Some(rate) => rate,
        None => panic!("evaluated while compiling"),
    }
}

/// Time between two frames.
const PERIOD: Micros = Micros::from_ms(2);

impl MemoryController {
    /// A controller on a bus with this rate.
    #[must_use]
    pub const fn new(bus: Bitrate) -> Self {
        Self { bus, configured: None, monitoring: false, last: Micros(0), count: 0 }
    }

    fn next_frame(&mut self) -> Option<Frame> {
        self.count = self.count.wrapping_add(1);
        Frame::new(Id::base(0x181)?, FrameKind::Data, 1, &[self.count]).ok()
    }
}

impl Controller for MemoryController {
    type Error = NotStopped;

    fn capabilities(&self) -> Capabilities<'_> {
        CAPABILITIES
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, NotStopped> {
        if self.monitoring {
            return Err(NotStopped);
        }
        self.configured = Some(candidate.nominal);
        Ok(Configured { nominal: candidate.nominal, data: None })
    }

    fn start_monitoring(&mut self) -> Result<(), NotStopped> {
        self.monitoring = true;
        Ok(())
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, NotStopped> {
        if !self.monitoring || now < self.last + PERIOD {
            return Ok(None);
        }
        self.last = now;
        if self.configured == Some(self.bus) {
            let received = Some(now);
            let seen = |frame| FrameSeen { frame, origin: Origin::Bus, received };
            return Ok(self.next_frame().map(|frame| Observation::Frame(seen(frame))));
        }
        let (class, place) = (ErrorClass::Stuff, ErrorPlace::Unknown);
        Ok(Some(Observation::Error(ErrorSeen { class, place, received: Some(now) })))
    }

    fn stop(&mut self) -> Result<(), NotStopped> {
        self.monitoring = false;
        Ok(())
    }
}
