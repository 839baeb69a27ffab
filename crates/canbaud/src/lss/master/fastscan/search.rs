//! Which question is next, and what its answer means. Knows no time.

use super::options::Strategy;
use crate::lss::{LssAddress, Part, Request};

/// Decisions in a row that rest on silence alone.
const UNPROVEN_MAX: u8 = 2;
/// Questions about one bit, half for each value, until its silence is a contradiction.
const DOUBT_MAX: u8 = 6;

/// How far answers are believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Care {
    /// As the document draws it.
    Document,
    /// Likely things first.
    Quick,
    /// Each bit is proven by an answer.
    Careful,
}

/// What is known of ones among the open bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Zeros {
    /// It goes bit by bit.
    NotSought,
    /// A run of zeros is likely.
    Likely,
    /// There is a one among so many next bits.
    OneWithin(u8),
}

/// A question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ask {
    /// Is the part this number, its lowest `open` bits aside?
    Number { number: u32, open: u8 },
    /// Are so many next bits 0?
    Zeros(u8),
    /// Is the next bit this?
    Bit(bool),
    /// Is all right so far?
    Check,
    /// Is the whole part right? Then go on to the next.
    Confirm,
}

/// What an answer led to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// There are more questions.
    Open,
    /// All parts are confirmed.
    Complete(LssAddress),
    /// Answers do not fit together.
    Contradiction,
}

/// The state of the search for one address.
#[derive(Debug, Clone)]
pub(super) struct Search<'a> {
    care: Care,
    known: &'a [LssAddress],
    /// Confirmed up to `part`; behind it what was confirmed before a restart.
    address: LssAddress,
    /// Parts of `address` that were confirmed, also before a restart.
    confirmed: u8,
    part: Part,
    value: u32,
    /// How many low bits of the part are not decided, 0 to 32.
    open: u8,
    zeros: Zeros,
    unproven: u8,
    doubt: u8,
    /// Numbers of this part that were tried, by their place in `known`.
    tried: usize,
}

impl<'a> Search<'a> {
    pub(super) fn new(strategy: Strategy, known: &'a [LssAddress]) -> Self {
        let care = match strategy {
            Strategy::Document => Care::Document,
            Strategy::Adaptive => Care::Quick,
        };
        let mut search = Self {
            care,
            known,
            address: LssAddress::new(0, 0, 0, 0),
            confirmed: 0,
            part: Part::VendorId,
            value: 0,
            open: 32,
            zeros: Zeros::NotSought,
            unproven: 0,
            doubt: 0,
            tried: 0,
        };
        search.begin(Part::VendorId);
        search
    }

    /// From the first part again, every bit proven; the slaves were told to begin anew.
    pub(super) fn restart(&mut self) {
        self.care = Care::Careful;
        self.begin(Part::VendorId);
    }

    /// Whether likely things are tried first.
    pub(super) fn is_quick(&self) -> bool {
        self.care == Care::Quick
    }

    /// Whether silence after the next request may be judged early: a mistake would be found out.
    pub(super) fn may_hurry(&self) -> bool {
        self.is_quick() && !matches!(self.ask(), Ask::Check | Ask::Confirm)
    }

    /// The address that the last confirmation was asked for: if the answer was lost, the device is
    /// in configuration. A known device may be there for long.
    pub(super) fn last_asked(&self) -> Option<LssAddress> {
        let address = self.address.with_part(self.part, self.value);
        let last = self.part == Part::SerialNumber && self.ask() == Ask::Confirm;
        (last && !self.known.contains(&address)).then_some(address)
    }

    fn begin(&mut self, part: Part) {
        self.part = part;
        (self.value, self.open, self.unproven, self.doubt, self.tried) = (0, 32, 0, 0, 0);
        self.zeros = match self.care {
            Care::Quick => Zeros::Likely,
            Care::Document | Care::Careful => Zeros::NotSought,
        };
    }

    fn next_part(&self) -> Part {
        self.part.next().unwrap_or(Part::VendorId)
    }

    fn ask(&self) -> Ask {
        // A confirmation right behind silence could be that of a late answer.
        let shaky = self.unproven >= UNPROVEN_MAX || (self.open == 0 && self.unproven > 0);
        match (self.care, self.open, self.zeros) {
            (Care::Quick, ..) if shaky => Ask::Check,
            (_, 0, _) => Ask::Confirm,
            (Care::Document, ..) => Ask::Bit(false),
            (Care::Careful, 32, _) if self.replay().is_some() => {
                Ask::Number { number: self.replay().unwrap_or_default(), open: 0 }
            }
            (Care::Careful, ..) => Ask::Bit(self.doubt % 2 == 1),
            (Care::Quick, 32, _) if self.candidate().is_some() => {
                let number = self.candidate().map_or(0, |(_, number)| number);
                Ask::Number { number, open: self.left_open() }
            }
            (Care::Quick, open, Zeros::Likely) => Ask::Zeros((open / 2).max(1)),
            (Care::Quick, _, Zeros::OneWithin(window)) => Ask::Zeros((window / 2).max(1)),
            // Ones and zeros come in runs.
            (Care::Quick, open, Zeros::NotSought) => Ask::Bit(self.value >> (open & 31) & 1 == 1),
        }
    }

    /// What this part was before the restart.
    fn replay(&self) -> Option<u32> {
        (self.tried == 0 && self.part.sub() < self.confirmed).then(|| self.address.part(self.part))
    }

    /// Bits that a known number says nothing about: serial numbers of devices bought together are
    /// close to each other.
    fn left_open(&self) -> u8 {
        if self.part == Part::SerialNumber { 8 } else { 0 }
    }

    /// The next number of this part among the known addresses that share the parts before, and
    /// its place.
    fn candidate(&self) -> Option<(usize, u32)> {
        let shares = |known: &LssAddress| {
            let before = Part::ALL.iter().take_while(|part| **part < self.part);
            before.into_iter().all(|part| known.part(*part) == self.address.part(*part))
        };
        let open = self.left_open();
        let number = |known: &LssAddress| known.part(self.part) >> open << open;
        self.known.iter().enumerate().skip(self.tried).find_map(|(place, known)| {
            let seen = self.known.iter().take(self.tried);
            let new =
                shares(known) && !seen.into_iter().any(|k| shares(k) && number(k) == number(known));
            new.then(|| (place, number(known)))
        })
    }

    /// The next request.
    pub(super) fn request(&self) -> Request {
        let lowest = |bits: u8| self.open.saturating_sub(bits);
        let (id_number, bit_checked, next) = match self.ask() {
            Ask::Number { number, open } => (number, open, self.part),
            Ask::Zeros(bits) => (self.value, lowest(bits), self.part),
            Ask::Bit(one) => {
                (self.value | u32::from(one) << (lowest(1) & 31), lowest(1), self.part)
            }
            Ask::Check => (self.value, self.open, self.part),
            Ask::Confirm => (self.value, 0, self.next_part()),
        };
        Request::Fastscan { id_number, bit_checked, lss_sub: self.part.sub(), lss_next: next.sub() }
    }

    /// Somebody answered the request.
    pub(super) fn yes(&mut self) -> Progress {
        let ask = self.ask();
        self.unproven = 0;
        match ask {
            Ask::Number { number, open } => {
                (self.value, self.open) = (number >> open << open, open);
                self.zeros = Zeros::NotSought;
            }
            Ask::Zeros(bits) => {
                self.decide(0, bits);
                if let Zeros::OneWithin(window) = self.zeros {
                    self.one_within(window.saturating_sub(bits));
                }
            }
            Ask::Bit(one) => self.decide_bit(one),
            Ask::Check => {}
            Ask::Confirm => return self.confirm(),
        }
        Progress::Open
    }

    /// Nobody answered the request.
    pub(super) fn no(&mut self) -> Progress {
        match self.ask() {
            Ask::Number { .. } => {
                self.tried = match self.candidate() {
                    Some((place, _)) if self.care == Care::Quick => place + 1,
                    _ => self.tried + 1,
                };
            }
            // Behind a one, bits are no likelier to be zeros than to be anything else.
            Ask::Zeros(bits) if self.value != 0 && bits > 1 => self.zeros = Zeros::NotSought,
            Ask::Zeros(bits) => self.one_within(bits),
            Ask::Bit(_) if self.care == Care::Careful => {
                self.doubt += 1;
                if self.doubt >= DOUBT_MAX {
                    return Progress::Contradiction;
                }
            }
            Ask::Bit(one) => {
                self.decide_bit(!one);
                self.unproven += 1;
            }
            Ask::Check | Ask::Confirm => return Progress::Contradiction,
        }
        Progress::Open
    }

    /// There is a one among so many next bits.
    fn one_within(&mut self, window: u8) {
        self.zeros = Zeros::OneWithin(window);
        if window == 1 {
            self.zeros = Zeros::NotSought;
            self.decide_bit(true);
            self.unproven += 1;
        }
    }

    fn decide_bit(&mut self, one: bool) {
        self.decide(u32::from(one), 1);
        self.doubt = 0;
        // Two numbers of 16 bits in one, as major and minor revision: the lower may be small.
        if self.care == Care::Quick && self.open == 16 && self.zeros == Zeros::NotSought {
            self.zeros = Zeros::Likely;
        }
    }

    /// The next `bits` bits are those of `number`.
    fn decide(&mut self, number: u32, bits: u8) {
        self.open = self.open.saturating_sub(bits);
        self.value |= number << (self.open & 31);
    }

    fn confirm(&mut self) -> Progress {
        self.address = self.address.with_part(self.part, self.value);
        self.confirmed = self.confirmed.max(self.part.sub() + 1);
        match self.part.next() {
            Some(next) => {
                self.begin(next);
                Progress::Open
            }
            None => Progress::Complete(self.address),
        }
    }
}
