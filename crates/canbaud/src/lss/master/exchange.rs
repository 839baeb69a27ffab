//! One service: send its frames, take the answer.

use super::pace::Pace;
use super::service::{Reply, Service, ServiceError};
use crate::lss::Response;
use crate::units::Micros;
use crate::wire::Frame;

/// What an exchange wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: actions live on the stack")]
pub enum ExchangeAction {
    /// Send this frame.
    Send(Frame),
    /// It is over.
    Done(Result<Reply, ServiceError>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    /// Frame `place` goes out, not before `at`.
    Send {
        place: usize,
        at: Micros,
    },
    /// All frames are out.
    Await {
        until: Micros,
    },
    /// An answer is there; a different one would mean two slaves.
    Settle {
        result: Result<Reply, ServiceError>,
        until: Micros,
    },
    Over,
}

/// One service of a master: call [`Exchange::handle`] with what is received, [`Exchange::poll`]
/// until it returns `None`, and again at [`Exchange::deadline`].
///
/// ```
/// use canbaud::lss::{Exchange, ExchangeAction, Pace, Reply, Request, Response, Service};
/// use canbaud::units::Micros;
///
/// let mut exchange = Exchange::new(Service::InquireNodeId, Pace::default(), Micros(0));
/// let request = Request::InquireNodeId.to_frame();
/// assert_eq!(exchange.poll(Micros(0)), Some(ExchangeAction::Send(request)));
/// assert_eq!(exchange.poll(Micros(0)), None);
/// exchange.handle(Micros(900), &Response::InquireNodeId { node_id: 5 }.to_frame());
/// let done = exchange.poll(exchange.deadline());
/// assert_eq!(done, Some(ExchangeAction::Done(Ok(Reply::NodeId(5)))));
/// ```
#[derive(Debug, Clone)]
pub struct Exchange {
    service: Service,
    pace: Pace,
    turn: Turn,
}

impl Exchange {
    /// `service`, to begin at `now`.
    #[must_use]
    pub const fn new(service: Service, pace: Pace, now: Micros) -> Self {
        Self { service, pace, turn: Turn::Send { place: 0, at: now } }
    }

    /// Takes a received frame; what is no answer to this service is ignored.
    pub fn handle(&mut self, now: Micros, frame: &Frame) {
        let Some(reply) = Response::from_frame(frame).and_then(|r| self.service.reply(r)) else {
            return;
        };
        match self.turn {
            Turn::Await { .. } => {
                self.turn = Turn::Settle { result: reply, until: now + self.pace.settle };
            }
            Turn::Settle { result, until } if result != reply => {
                self.turn = Turn::Settle { result: Err(ServiceError::SeveralAnswers), until };
            }
            // Whatever comes before the last frame is out answers something older.
            Turn::Send { .. } | Turn::Settle { .. } | Turn::Over => {}
        }
    }

    /// The next thing to do at `now`.
    pub fn poll(&mut self, now: Micros) -> Option<ExchangeAction> {
        match self.turn {
            Turn::Send { place, at } if now >= at => self.send(place, now),
            Turn::Await { until } if now >= until => {
                let waited = self.pace.answer_timeout;
                Some(self.end(Err(ServiceError::NoAnswer(waited))))
            }
            Turn::Settle { result, until } if now >= until => Some(self.end(result)),
            Turn::Send { .. } | Turn::Await { .. } | Turn::Settle { .. } | Turn::Over => None,
        }
    }

    /// When to call [`Exchange::poll`] next if no frame comes; [`Micros::MAX`] once it is over.
    #[must_use]
    pub const fn deadline(&self) -> Micros {
        match self.turn {
            Turn::Send { at, .. } => at,
            Turn::Await { until } | Turn::Settle { until, .. } => until,
            Turn::Over => Micros::MAX,
        }
    }

    fn send(&mut self, place: usize, now: Micros) -> Option<ExchangeAction> {
        let Some(request) = self.service.request(place) else {
            return Some(self.end(Ok(Reply::Done)));
        };
        let last = self.service.request(place + 1).is_none();
        self.turn = if last && self.service.is_answered() {
            Turn::Await { until: now + self.pace.answer_timeout }
        } else {
            Turn::Send { place: place + 1, at: now + self.pace.inhibit }
        };
        Some(ExchangeAction::Send(request.to_frame()))
    }

    const fn end(&mut self, result: Result<Reply, ServiceError>) -> ExchangeAction {
        self.turn = Turn::Over;
        ExchangeAction::Done(result)
    }
}
