//! Questions and answers in time.

use super::options::{FastscanError, FastscanOptions, FastscanStatistics, Found};
use super::rhythm::Rhythm;
use super::search::{Progress, Search};
use crate::lss::{LssAddress, Part, Request, Response};
use crate::units::Micros;
use crate::wire::Frame;

/// Times that "begin" is asked, to learn how long answers take.
const BEGINNINGS: u8 = 3;
/// How long the first answer is waited behind for those of slower devices; an answer that comes
/// later still is found out, and the full time-out waited.
const WATCH: Micros = Micros::from_ms(50);
/// Times in a row that "begin" may stay without an answer.
const SILENT_BEGINNINGS: u8 = 2;
/// Restarts after which it is given up.
const RESTARTS: u32 = 8;

/// What a fastscan wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: actions live on the stack")]
pub enum FastscanAction {
    /// Send this frame.
    Send(Frame),
    /// It is over. `None`: there is no device without node-ID in waiting.
    Done(Result<Option<Found>, FastscanError>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    /// The next question goes out, not before this.
    Send {
        at: Micros,
    },
    /// Somebody may answer.
    Await {
        sent: Micros,
        until: Micros,
    },
    /// Somebody answered; others may, too.
    Settle {
        first: Micros,
        until: Micros,
    },
    /// The result is to be fetched.
    Done(Result<Option<Found>, FastscanError>),
    Over,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// All slaves begin anew; so many answered and unanswered requests.
    Begin { answered: u8, silent: u8 },
    /// Questions about the address.
    Search,
    /// The last confirmation stayed without an answer: is this device in configuration?
    Inquire { address: LssAddress, part: Part, silent: u8 },
}

/// What a request came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Before {
    /// An answer, or silence for the full time-out.
    Settled,
    /// Silence judged early: an answer may still be on its way.
    GivenUp,
}

/// Finds one device without node-ID and puts it in configuration: driven like
/// [`Exchange`](crate::lss::Exchange).
///
/// All slaves answer alike, and an answer does not say to which request: a late one looks like one
/// to the request behind. So the scan learns how long answers take and takes nothing that comes
/// sooner than possible; it never confirms right behind silence; each part is confirmed as a whole;
/// and if answers do not fit together all slaves begin anew and it asks again with the full time-out,
/// each bit proven by an answer. Answers of several devices to one request are waited for.
///
/// With more than one device, one of them is found; it does not take part in the next scan as long
/// as it is in configuration or has a node-ID.
#[derive(Debug, Clone)]
pub struct Fastscan<'a> {
    options: FastscanOptions<'a>,
    search: Search<'a>,
    rhythm: Rhythm,
    /// What the request before came to.
    before: Before,
    phase: Phase,
    turn: Turn,
    statistics: FastscanStatistics,
}

impl<'a> Fastscan<'a> {
    /// A scan that begins at `now`.
    #[must_use]
    pub fn new(options: FastscanOptions<'a>, now: Micros) -> Self {
        Self {
            options,
            search: Search::new(options.strategy, options.known),
            rhythm: Rhythm::new(),
            before: Before::Settled,
            phase: Phase::Begin { answered: 0, silent: 0 },
            turn: Turn::Send { at: now },
            statistics: FastscanStatistics::default(),
        }
    }

    /// What the scan has taken so far.
    #[must_use]
    pub const fn statistics(&self) -> FastscanStatistics {
        self.statistics
    }

    /// Takes a received frame; what answers no request of a scan is ignored.
    pub fn handle(&mut self, now: Micros, frame: &Frame) {
        if Response::from_frame(frame) != Some(self.expected()) {
            return;
        }
        match self.turn {
            Turn::Await { sent, .. } if self.is_stray(now - sent) => {
                count(&mut self.statistics.stray_answers);
            }
            Turn::Await { sent, .. } => {
                self.rhythm.note(now - sent);
                self.statistics.longest_answer = self.rhythm.longest();
                let wait = match self.phase {
                    // To see whether there are more devices, and how far apart they answer.
                    Phase::Begin { answered: 0, .. } if self.search.is_quick() => {
                        self.rhythm.longest().max(WATCH)
                    }
                    Phase::Begin { answered: 0, .. } => self.options.pace.answer_timeout,
                    Phase::Begin { .. } | Phase::Search | Phase::Inquire { .. } => {
                        self.rhythm.settle()
                    }
                };
                self.turn = Turn::Settle { first: now, until: now + wait };
            }
            Turn::Settle { first, until } => {
                self.rhythm.note_further(now - first);
                let until = until.max(now + self.rhythm.longest());
                self.turn = Turn::Settle { first, until };
            }
            Turn::Send { .. } => self.statistics.stray_answers += 1,
            Turn::Done(_) | Turn::Over => {}
        }
    }

    /// The next thing to do at `now`.
    pub fn poll(&mut self, now: Micros) -> Option<FastscanAction> {
        // At most twice: the end of a turn, and what follows from it.
        loop {
            match self.turn {
                Turn::Send { at } if now >= at => return Some(self.send(now)),
                Turn::Await { sent, until } if now >= until => {
                    count(&mut self.statistics.silences);
                    let in_full = until - sent >= self.options.pace.answer_timeout;
                    self.before = if in_full { Before::Settled } else { Before::GivenUp };
                    self.nobody(now);
                }
                Turn::Settle { until, .. } if now >= until => self.somebody(now),
                Turn::Done(result) => {
                    self.turn = Turn::Over;
                    return Some(FastscanAction::Done(result));
                }
                Turn::Send { .. } | Turn::Await { .. } | Turn::Settle { .. } | Turn::Over => {
                    return None;
                }
            }
        }
    }

    /// When to call [`Fastscan::poll`] next if no frame comes; [`Micros::MAX`] once it is over.
    #[must_use]
    pub const fn deadline(&self) -> Micros {
        match self.turn {
            Turn::Send { at } => at,
            Turn::Await { until, .. } | Turn::Settle { until, .. } => until,
            Turn::Done(_) => Micros(0),
            Turn::Over => Micros::MAX,
        }
    }

    fn send(&mut self, now: Micros) -> FastscanAction {
        let hurry = self.phase == Phase::Search && self.search.may_hurry();
        let wait = if hurry {
            self.rhythm.silence(&self.options.pace)
        } else {
            self.options.pace.answer_timeout
        };
        count(&mut self.statistics.requests);
        self.turn = Turn::Await { sent: now, until: now + wait };
        let request = match self.phase {
            Phase::Begin { .. } => Request::Fastscan {
                id_number: 0,
                bit_checked: Request::FASTSCAN_BEGIN,
                lss_sub: 0,
                lss_next: 0,
            },
            Phase::Search => self.search.request(),
            Phase::Inquire { part, .. } => Request::InquireIdentity { part },
        };
        FastscanAction::Send(request.to_frame())
    }

    fn somebody(&mut self, now: Micros) {
        self.before = Before::Settled;
        match self.phase {
            Phase::Begin { answered, .. } => {
                let answered = answered + 1;
                self.phase = if answered < self.beginnings() {
                    Phase::Begin { answered, silent: 0 }
                } else {
                    Phase::Search
                };
                self.ask_next(now);
            }
            Phase::Search => {
                let progress = self.search.yes();
                self.go_on(progress, now);
            }
            Phase::Inquire { address, part, .. } => match part.next() {
                Some(part) => {
                    self.phase = Phase::Inquire { address, part, silent: 0 };
                    self.ask_next(now);
                }
                None => self.go_on(Progress::Complete(address), now),
            },
        }
    }

    fn nobody(&mut self, now: Micros) {
        match self.phase {
            Phase::Begin { answered, silent } => {
                let silent = silent + 1;
                self.phase = Phase::Begin { answered, silent };
                if silent < SILENT_BEGINNINGS {
                    self.ask_next(now);
                } else if answered == 0 && self.statistics.restarts == 0 {
                    self.turn = Turn::Done(Ok(None));
                } else {
                    self.turn = Turn::Done(Err(FastscanError::Lost));
                }
            }
            Phase::Search => {
                let last_asked = self.search.last_asked();
                let progress = self.search.no();
                match last_asked {
                    Some(address) => {
                        let part = Part::VendorId;
                        self.phase = Phase::Inquire { address, part, silent: 0 };
                        self.ask_next(now);
                    }
                    None => self.go_on(progress, now),
                }
            }
            Phase::Inquire { address, part, silent: 0 } => {
                self.phase = Phase::Inquire { address, part, silent: 1 };
                self.ask_next(now);
            }
            Phase::Inquire { .. } => self.go_on(Progress::Contradiction, now),
        }
    }

    /// Whether an answer so soon belongs to the request before, which was given up early.
    fn is_stray(&self, round_trip: Micros) -> bool {
        // Each "begin" means the same: whichever this one answers, it teaches how long they take.
        let begins = matches!(self.phase, Phase::Begin { .. });
        !begins && self.before == Before::GivenUp && self.rhythm.is_too_early(round_trip)
    }

    /// What answers the request that is out.
    const fn expected(&self) -> Response {
        match self.phase {
            Phase::Begin { .. } | Phase::Search => Response::IdentifySlave,
            Phase::Inquire { address, part, .. } => {
                Response::InquireIdentity { part, number: address.part(part) }
            }
        }
    }

    /// One suffices where nothing is to be learned from it.
    fn beginnings(&self) -> u8 {
        if self.search.is_quick() { BEGINNINGS } else { 1 }
    }

    fn go_on(&mut self, progress: Progress, now: Micros) {
        match progress {
            Progress::Open => self.ask_next(now),
            Progress::Complete(address) => {
                self.turn = Turn::Done(Ok(Some(Found { address, statistics: self.statistics })));
            }
            Progress::Contradiction if self.statistics.restarts >= RESTARTS => {
                self.turn = Turn::Done(Err(FastscanError::Inconsistent));
            }
            Progress::Contradiction => {
                count(&mut self.statistics.restarts);
                self.search.restart();
                self.phase = Phase::Begin { answered: 0, silent: 0 };
                // What is still on its way arrives while the answers to that are waited for.
                self.ask_next(now);
            }
        }
    }

    fn ask_next(&mut self, now: Micros) {
        self.turn = Turn::Send { at: now + self.options.pace.inhibit };
    }
}

const fn count(number: &mut u32) {
    *number = number.saturating_add(1);
}
