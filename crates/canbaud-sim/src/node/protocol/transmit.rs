//! Requests and the frame that is being sent.

use canbaud::wire::{BitString, EncodedFrame, Frame, FrameKind, Level, encode};

use super::machine::{Protocol, Request, State};
use crate::event::{Event, FaultState, Role, Rule};
use crate::node::config::{Mode, Retransmission};

/// A frame on its way out.
#[derive(Debug, Clone)]
pub(super) struct Sending {
    frame: Frame,
    encoded: EncodedFrame,
    /// The bit whose sample point comes next.
    index: usize,
}

impl Sending {
    #[inline]
    pub(super) fn level(&self) -> Level {
        self.encoded.bits.level(self.index)
    }

    /// Goes on to the next bit and returns it.
    #[inline]
    pub(super) fn advance(&mut self) -> Level {
        self.index += 1;
        self.level()
    }

    /// The level of bit `index`, and how many equal bits it begins (up to 32).
    #[inline]
    pub(super) fn run_from(&self, index: usize) -> (Level, u32) {
        let ahead = self.encoded.bits.bits(index, 32);
        if ahead >> 31 == 1 {
            (Level::Recessive, ahead.leading_ones())
        } else {
            (Level::Dominant, ahead.leading_zeros())
        }
    }

    pub(super) const fn bits(&self) -> &BitString {
        &self.encoded.bits
    }

    pub(super) const fn bits_before_crc_delimiter(&self) -> u32 {
        self.encoded.crc_delimiter.saturating_sub(self.index) as u32
    }

    /// Whether the rate changes in the frame.
    pub(super) const fn switches_rate(&self) -> bool {
        self.encoded.brs.is_some()
    }

    /// The level `bits` bits after the present one.
    pub(super) fn level_ahead(&self, bits: u32) -> Level {
        self.encoded.bits.level(self.index + bits as usize)
    }

    /// Goes on to bit `index`, which is not SOF; returns the level of the one before it.
    pub(super) fn go_to(&mut self, index: usize) -> Level {
        self.index = index;
        self.encoded.bits.level(index.saturating_sub(1))
    }

    pub(super) const fn index(&self) -> u32 {
        self.index as u32
    }

    pub(super) const fn before_sof(&self) -> bool {
        self.index == 0
    }

    pub(super) const fn frame(&self) -> &Frame {
        &self.frame
    }
}

impl Protocol {
    /// Adds a request. True if the node is idle and begins with SOF at its next bit.
    pub(crate) fn request(&mut self, frame: Frame) -> bool {
        self.queue.push_back(Request { frame, attempts: 0, encoded: None });
        self.state == State::Idle && self.start()
    }

    /// Requests that have not been sent.
    pub(crate) fn pending(&self) -> usize {
        self.queue.len()
    }

    /// Takes back all requests that are not being sent.
    pub(crate) fn abort_requests(&mut self) {
        let keep = usize::from(self.sending.is_some());
        self.queue.truncate(keep);
    }

    /// Drops the request that is being sent or comes next.
    fn drop_request(&mut self) {
        self.queue.pop_front();
    }

    /// From idle: SOF of the first request is next. False if there is none or it may not be sent.
    pub(super) fn start(&mut self) -> bool {
        if !self.prepare(0) {
            return false;
        }
        self.state = State::Frame;
        self.reader.reset();
        self.drive = Level::Dominant;
        true
    }

    /// SOF of another node was read in the third bit of the intermission: joins with the first
    /// bit of the identifier.
    pub(super) fn join(&mut self) {
        if self.prepare(1) {
            self.drive = self.sending.as_ref().map_or(Level::Recessive, Sending::level);
        }
    }

    fn prepare(&mut self, index: usize) -> bool {
        let may = matches!(self.setup.mode, Mode::Normal | Mode::Loopback);
        let passive = self.fault.state() == FaultState::ErrorPassive;
        let Some(request) = self.queue.front_mut().filter(|_| may) else { return false };
        request.attempts += 1;
        let frame = with_esi(&request.frame, passive);
        let attempt = request.attempts;
        // A frame that lost arbitration comes again with the same bits.
        let encoded = match request.encoded {
            Some((of, encoded)) if of == frame => encoded,
            Some(_) | None => encode(&frame, self.setup.fd_crc),
        };
        request.encoded = Some((frame, encoded));
        self.sending = Some(Sending { frame, encoded, index });
        self.role = Role::Transmitter;
        self.events.push(Event::TransmissionStarted { frame, attempt });
        true
    }

    /// The attempt failed: the request stays, or is dropped in one-shot mode.
    pub(super) fn give_up_attempt(&mut self) {
        let Some(sending) = self.sending.take() else { return };
        if self.setup.retransmission == Retransmission::OneShot {
            self.drop_request();
            self.events.push(Event::Abandoned { frame: sending.frame });
        }
    }

    /// The end of EOF.
    pub(super) fn succeed(&mut self) {
        let Some(sending) = self.sending.take() else { return };
        self.drop_request();
        self.events.push(Event::Transmitted { frame: sending.frame });
        self.count(Rule::Transmitted);
    }
}

/// The frame with ESI as an error passive node sends it.
fn with_esi(frame: &Frame, passive: bool) -> Frame {
    match frame.kind() {
        FrameKind::Fd { brs, esi } => {
            let kind = FrameKind::Fd { brs, esi: esi || passive };
            Frame::new(frame.id(), kind, frame.dlc(), frame.data()).unwrap_or(*frame)
        }
        FrameKind::Data | FrameKind::Remote => *frame,
    }
}
