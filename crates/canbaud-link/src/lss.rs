//! The LSS master on a live channel: drives the procedures of [`canbaud::lss`].

use std::time::{Duration, Instant};

use canbaud::lss::{
    Activation, ActivationAction, Exchange, ExchangeAction, Fastscan, FastscanAction,
    FastscanError, FastscanOptions, Found, Pace, Reply, Service, ServiceError,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::Frame;

use crate::LinkError;
use crate::bus::FrameBus;

/// Longest wait for one frame, so that no deadline is waited for in one piece.
const SLICE: Duration = Duration::from_millis(100);

/// Why a procedure of the master came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum MasterError {
    /// The channel.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The service.
    #[error("{0}")]
    Service(ServiceError),
    /// The scan.
    #[error("{0}")]
    Fastscan(FastscanError),
}

impl From<ServiceError> for MasterError {
    fn from(error: ServiceError) -> Self {
        Self::Service(error)
    }
}

/// How an activation went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Activated {
    /// How long the own channel took to change its bit rate; `None` if it stayed as it was.
    pub reconfiguration: Option<Duration>,
    /// Whether that was done before anybody could send again.
    pub in_time: bool,
}

/// The LSS master of a network; there must be one alone.
///
/// ```
/// use canbaud::lss::{LssState, Pace, Service};
/// use canbaud::units::Bitrate;
/// use canbaud_link::bus::MemoryNet;
/// use canbaud_link::lss::Master;
/// let net = MemoryNet::new();
/// let mut bus = net.join(Bitrate::new(250_000).unwrap());
/// let mut master = Master::new(&mut bus, Pace::default());
/// master.exchange(Service::SwitchStateGlobal(LssState::Waiting)).unwrap();
/// ```
#[derive(Debug)]
pub struct Master<'a, B: FrameBus + ?Sized> {
    bus: &'a mut B,
    pace: Pace,
    began: Instant,
}

impl<'a, B: FrameBus + ?Sized> Master<'a, B> {
    /// A master on `bus`.
    pub fn new(bus: &'a mut B, pace: Pace) -> Self {
        Self { bus, pace, began: Instant::now() }
    }

    /// Its times.
    #[must_use]
    pub const fn pace(&self) -> Pace {
        self.pace
    }

    fn now(&self) -> Micros {
        let elapsed = self.began.elapsed().as_micros();
        Micros(u64::try_from(elapsed).unwrap_or(u64::MAX))
    }

    fn receive(&mut self, deadline: Micros) -> Result<Option<Frame>, LinkError> {
        let left = Duration::from_micros((deadline - self.now()).0);
        self.bus.receive(left.min(SLICE))
    }

    /// Throws away what was received: nothing of it answers what is asked next.
    fn forget(&mut self) -> Result<(), LinkError> {
        // Bounded, should the bus never fall silent.
        for _ in 0..1000 {
            if self.bus.receive(Duration::ZERO)?.is_none() {
                break;
            }
        }
        Ok(())
    }

    /// One service.
    ///
    /// # Errors
    /// The channel's, or what the slave said, or that none answered.
    pub fn exchange(&mut self, service: Service) -> Result<Reply, MasterError> {
        self.forget()?;
        let mut exchange = Exchange::new(service, self.pace, self.now());
        loop {
            while let Some(action) = exchange.poll(self.now()) {
                match action {
                    ExchangeAction::Send(frame) => self.bus.send(&frame)?,
                    ExchangeAction::Done(result) => return Ok(result?),
                }
            }
            if let Some(frame) = self.receive(exchange.deadline())? {
                exchange.handle(self.now(), &frame);
            }
        }
    }

    /// Finds one device without node-ID; it is in configuration afterwards.
    ///
    /// # Errors
    /// The channel's, or that the scan came to nothing although somebody answered.
    pub fn fastscan(&mut self, options: FastscanOptions<'_>) -> Result<Option<Found>, MasterError> {
        self.forget()?;
        let mut scan = Fastscan::new(options, self.now());
        loop {
            while let Some(action) = scan.poll(self.now()) {
                match action {
                    FastscanAction::Send(frame) => self.bus.send(&frame)?,
                    FastscanAction::Done(result) => return result.map_err(MasterError::Fastscan),
                }
            }
            if let Some(frame) = self.receive(scan.deadline())? {
                scan.handle(self.now(), &frame);
            }
        }
    }

    /// Activates the pending bit timing of all slaves in configuration. The own channel goes to
    /// `own` between the two periods; `None`: it stays, as for slaves that detect.
    ///
    /// # Errors
    /// The channel's.
    pub fn activate(
        &mut self,
        switch_delay_ms: u16,
        own: Option<Bitrate>,
    ) -> Result<Activated, LinkError> {
        let mut activation = Activation::new(switch_delay_ms);
        let mut activated = Activated { reconfiguration: None, in_time: true };
        loop {
            while let Some(action) = activation.poll(self.now()) {
                match (action, own) {
                    (ActivationAction::Send(frame), _) => self.bus.send(&frame)?,
                    (ActivationAction::SwitchBitRate { .. }, None) => {}
                    (ActivationAction::SwitchBitRate { until }, Some(rate)) => {
                        let begin = Instant::now();
                        self.bus.set_bitrate(rate)?;
                        activated.reconfiguration = Some(begin.elapsed());
                        activated.in_time = self.now() < until;
                    }
                    (ActivationAction::Done, _) => return Ok(activated),
                }
            }
            // What others send meanwhile is nothing to a master.
            let _ = self.receive(activation.deadline())?;
        }
    }
}
