//! How a node looks for the rate, in silence.

use super::measure::{Measure, Measured};
use super::settings::{Means, Settings};
use crate::detect::scan::{
    Action as ScanAction, Candidate, Candidates, Capabilities, Configured, ErrorClass, ErrorPlace,
    ErrorSeen, FrameSeen, Observation, Origin, Outcome, Scan, Settings as ScanSettings,
};
use crate::units::{Bitrate, Micros};
use crate::wire::Frame;

/// Different frames that a controller has to accept where the timer knows no rate.
const FRAMES_WITHOUT_MEASUREMENT: u8 = 2;

/// What a search wants of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wish {
    /// To be off.
    Stop,
    /// To listen.
    Listen(Candidate),
}

/// What the controller said about the rate at which it listens.
#[derive(Debug, Clone, Copy, Default)]
struct Confirmation {
    /// A frame came in, or one whose CRC was right before it was destroyed.
    seen: bool,
    /// How many different ones, up to 2.
    distinct: u8,
    last: Option<Frame>,
}

impl Confirmation {
    fn add(&mut self, frame: &Frame) {
        self.seen = true;
        if self.last.as_ref() != Some(frame) {
            self.distinct = self.distinct.saturating_add(1).min(FRAMES_WITHOUT_MEASUREMENT);
            self.last = Some(*frame);
        }
    }
}

/// The method that the device has the means for.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "no_std: there is one, and it stays where it is")]
enum Method<const N: usize, const R: usize> {
    /// The timer measures, and nothing confirms but taking part.
    Measure(Measure<N>),
    /// The timer measures, the controller confirms.
    MeasureAndListen {
        measure: Measure<N>,
        listening: Candidate,
        confirmation: Confirmation,
        told: bool,
    },
    /// The controller listens at one rate after the other.
    Scan {
        scan: Scan<R>,
        candidates: Candidates<R>,
        capabilities: Capabilities<'static>,
        wish: Option<Wish>,
    },
}

/// A search under way.
#[derive(Debug, Clone)]
pub(super) struct Search<const N: usize, const R: usize> {
    method: Method<N, R>,
    rates: &'static [Bitrate],
    /// There was a sign of life since [`Search::take_sign`].
    sign: bool,
    measured: Measured,
}

impl<const N: usize, const R: usize> Search<N, R> {
    /// Looks among the rates of `settings`, at `first` first.
    pub(super) fn new(settings: &Settings, first: Bitrate) -> Self {
        let method = match settings.means {
            Means::Timer(timebase) => Method::Measure(Measure::new(timebase)),
            Means::Both(timebase) => Method::MeasureAndListen {
                measure: Measure::new(timebase),
                listening: Candidate::classic(first),
                confirmation: Confirmation::default(),
                told: false,
            },
            Means::Controller(capabilities) => {
                // The list was checked to fit when the node was made.
                let candidates = Candidates::of_rates(settings.rates).unwrap_or_default();
                let settings = ScanSettings { last_known: Some(first), ..ScanSettings::default() };
                Method::Scan {
                    scan: Scan::new(&candidates, &capabilities, settings),
                    candidates,
                    capabilities,
                    wish: None,
                }
            }
        };
        Self { method, rates: settings.rates, sign: false, measured: Measured::Nothing }
    }

    /// Whether somebody has sent something since the last call.
    pub(super) const fn take_sign(&mut self) -> bool {
        core::mem::replace(&mut self.sign, false)
    }

    /// Whether the bus has a rate that the device cannot be set to.
    pub(super) const fn is_foreign(&self) -> bool {
        matches!(self.measured, Measured::Foreign)
    }

    /// What the controller should do now, told once.
    pub(super) const fn take_wish(&mut self) -> Option<Wish> {
        match &mut self.method {
            Method::Measure(_) => None,
            Method::MeasureAndListen { listening, told, .. } => {
                if core::mem::replace(told, true) {
                    None
                } else {
                    Some(Wish::Listen(*listening))
                }
            }
            Method::Scan { wish, .. } => wish.take(),
        }
    }

    pub(super) fn edge(&mut self, ticks: u64, level: crate::wire::Logic) {
        if let Method::Measure(measure) | Method::MeasureAndListen { measure, .. } =
            &mut self.method
        {
            self.sign = true;
            measure.edge(ticks, level);
        }
    }

    pub(super) fn timer(&mut self, ticks: u64, level: crate::wire::Logic) {
        if let Method::Measure(measure) | Method::MeasureAndListen { measure, .. } =
            &mut self.method
        {
            measure.timer(ticks, level);
        }
    }

    /// When [`Search::poll`] wants to be called.
    pub(super) fn deadline(&self) -> Option<Micros> {
        match &self.method {
            Method::Measure(measure) | Method::MeasureAndListen { measure, .. } => {
                measure.deadline()
            }
            Method::Scan { scan, .. } => scan.deadline(),
        }
    }

    /// The controller listens as wished.
    pub(super) fn listening(&mut self, now: Micros, configured: Configured) {
        if let Method::Scan { scan, .. } = &mut self.method {
            scan.handle_listening(now, configured);
        }
    }

    /// The controller cannot listen as wished. How often in a row it may be asked for something else
    /// at once.
    pub(super) fn refused(&mut self, now: Micros) -> u32 {
        match &mut self.method {
            Method::Scan { scan, .. } => {
                scan.handle_refused(now);
                self.rates.len().saturating_sub(1) as u32
            }
            // Perhaps the next measurement says something else.
            Method::Measure(measure) | Method::MeasureAndListen { measure, .. } => {
                measure.restart();
                self.measured = Measured::Nothing;
                0
            }
        }
    }

    /// The controller heard something at the rate that was wished.
    pub(super) fn heard(&mut self, now: Micros, observation: &Observation) {
        self.sign |= match observation {
            Observation::Frame(FrameSeen { origin, .. }) => *origin == Origin::Bus,
            Observation::Error(_) => true,
            Observation::ReceiveErrors(count) => *count > 0,
            Observation::Edges(edges) => *edges > 0,
            Observation::Lost => true,
        };
        match &mut self.method {
            Method::Measure(_) => {}
            Method::Scan { scan, .. } => scan.handle(now, observation),
            Method::MeasureAndListen { measure, confirmation, .. } => match observation {
                Observation::Frame(FrameSeen { frame, origin: Origin::Bus, .. }) => {
                    confirmation.add(frame);
                }
                Observation::Error(error) if is_unacknowledged(error) => confirmation.seen = true,
                // AP2925: on an error, measure again.
                Observation::Error(_) if matches!(self.measured, Measured::Rate { .. }) => {
                    measure.restart();
                    self.measured = Measured::Nothing;
                    *confirmation = Confirmation::default();
                }
                _ => {}
            },
        }
    }

    /// Goes on; a fit is told once.
    pub(super) fn poll(&mut self, now: Micros) -> Option<Candidate> {
        match &mut self.method {
            Method::Measure(measure) => {
                self.measured = measure.poll(now, self.rates).unwrap_or(self.measured);
                let Measured::Rate { rate, certain: true } = self.measured else { return None };
                Some(Candidate::classic(rate))
            }
            Method::MeasureAndListen { measure, listening, confirmation, told } => {
                self.measured = measure.poll(now, self.rates).unwrap_or(self.measured);
                let fits = match self.measured {
                    Measured::Rate { rate, .. } if rate != listening.nominal => {
                        *listening = Candidate::classic(rate);
                        *confirmation = Confirmation::default();
                        *told = false;
                        false
                    }
                    Measured::Rate { .. } => confirmation.seen,
                    Measured::Nothing => confirmation.distinct >= FRAMES_WITHOUT_MEASUREMENT,
                    Measured::Foreign => false,
                };
                fits.then_some(*listening)
            }
            Method::Scan { scan, candidates, capabilities, wish } => {
                while let Some(action) = scan.poll(now) {
                    *wish = Some(match action {
                        ScanAction::Listen(candidate) => Wish::Listen(candidate),
                        ScanAction::Stop => Wish::Stop,
                    });
                }
                match scan.outcome() {
                    Some(Outcome::Found(found)) => Some(found.candidate),
                    // At its bound: what was heard meanwhile fits nothing, perhaps because the rate
                    // has changed. It begins anew, without a memory.
                    Some(_) => {
                        *scan = Scan::new(candidates, capabilities, ScanSettings::default());
                        None
                    }
                    None => None,
                }
            }
        }
    }
}

/// A form error at the ACK delimiter: the CRC was right, and a lone sender tells that nobody has
/// acknowledged.
const fn is_unacknowledged(error: &ErrorSeen) -> bool {
    matches!(
        (error.class, error.place),
        (ErrorClass::Form | ErrorClass::Unknown, ErrorPlace::AckDelimiter)
    )
}
