//! What pumps a controller for a scan.

use super::{Action, Controller, Outcome, Scan};
use crate::units::Micros;

/// What came of a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: the outcome lives on the stack")]
pub enum Progress {
    /// Call again when the controller has something to tell, and at this time at the latest.
    Listening(Option<Micros>),
    /// The scan is over and the controller stopped.
    Done(Outcome),
}

/// Moves observations from a controller to a scan, and actions back.
///
/// Nothing in it waits, apart from the controller's own calls: [`Driver::turn`] is called from a
/// loop, a task or an interrupt.
///
/// ```no_run
/// # use canbaud::detect::scan::*;
/// # use canbaud::units::Micros;
/// # fn demo<C: Controller>(controller: C, microseconds: fn() -> Micros) -> Result<(), C::Error> {
/// let candidates = Candidates::<8>::canopen().unwrap();
/// let scan = Scan::new(&candidates, &controller.capabilities(), Settings::default());
/// let mut driver = Driver::new(controller, scan, |_| microseconds());
/// let outcome = loop {
///     match driver.turn()? {
///         Progress::Done(outcome) => break outcome,
///         // Firmware sleeps here until an interrupt or until then.
///         Progress::Listening(_until) => {}
///     }
/// };
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Driver<C, T, const N: usize> {
    controller: C,
    scan: Scan<N>,
    clock: T,
}

/// Observations taken in one turn; the next turn takes the rest.
const TAKEN: usize = 64;

impl<C: Controller, T: FnMut(&C) -> Micros, const N: usize> Driver<C, T, N> {
    /// Puts `controller` and `scan` together; `clock` tells the time, which may be the
    /// controller's own.
    pub const fn new(controller: C, scan: Scan<N>, clock: T) -> Self {
        Self { controller, scan, clock }
    }

    /// The scan, for its status.
    pub const fn scan(&self) -> &Scan<N> {
        &self.scan
    }

    /// The controller.
    pub const fn controller(&self) -> &C {
        &self.controller
    }

    /// The controller, to wait on it.
    pub const fn controller_mut(&mut self) -> &mut C {
        &mut self.controller
    }

    /// Gives the controller back, as it is.
    pub fn into_controller(self) -> C {
        self.controller
    }

    fn now(&mut self) -> Micros {
        (self.clock)(&self.controller)
    }

    /// Takes what was heard to the scan and does what it asks for.
    ///
    /// # Errors
    /// The controller's. One that [`Controller::configure`] returns says that the candidate cannot
    /// be had, and is returned only when no candidate can.
    pub fn turn(&mut self) -> Result<Progress, C::Error> {
        if self.scan.listens() {
            self.listen()?;
        }
        let mut refusal = None;
        loop {
            let now = self.now();
            match self.scan.poll(now) {
                Some(Action::Listen(candidate)) => {
                    self.controller.stop()?;
                    match self.controller.configure(&candidate) {
                        Ok(configured) => {
                            self.controller.start_monitoring()?;
                            let now = self.now();
                            self.scan.handle_listening(now, configured);
                        }
                        Err(error) => {
                            let now = self.now();
                            self.scan.handle_refused(now);
                            refusal = Some(error);
                        }
                    }
                }
                Some(Action::Stop) => self.controller.stop()?,
                None => break,
            }
        }
        match (self.scan.outcome(), refusal) {
            (Some(Outcome::Refused), Some(error)) => Err(error),
            (Some(outcome), _) => Ok(Progress::Done(*outcome)),
            (None, _) => Ok(Progress::Listening(self.scan.deadline())),
        }
    }
    fn listen(&mut self) -> Result<(), C::Error> {
        for _ in 0..TAKEN {
            let now = self.now();
            let Some(observation) = self.controller.observe(now)? else { break };
            self.scan.handle(now, &observation);
        }
        Ok(())
    }
}
