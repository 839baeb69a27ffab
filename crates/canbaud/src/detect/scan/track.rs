//! What is known about each candidate.

use crate::units::Micros;
use crate::wire::{Frame, FrameKind};

/// Sixteenths of a bit: the unit of all weights. 16 is twice as likely.
pub(super) const BIT: i32 = 16;

/// What is known about a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Track {
    /// Logarithm of how likely it is, by what was heard at it and from the beginning.
    pub(super) weight: i32,
    /// The same, by what was heard at the others.
    pub(super) hint: i32,
    pub(super) visits: u32,
    pub(super) listened: Micros,
    pub(super) frames: u32,
    /// Up to 2.
    pub(super) distinct: u8,
    /// Of the first good frame.
    print: u32,
    /// Bursts of errors.
    pub(super) errors: u32,
    /// Of them, those with an error in the arbitration field.
    pub(super) in_arbitration: u32,
    /// Errors at the ACK delimiter.
    pub(super) unacknowledged: u32,
    /// Steps at its full length in which nothing was heard.
    pub(super) silences: u32,
    pub(super) fd: bool,
    pub(super) switched: bool,
    pub(super) refused: bool,
    /// Another nominal rate is proven.
    pub(super) ruled_out: bool,
}

impl Track {
    pub(super) const fn standing(&self) -> i32 {
        self.weight.saturating_add(self.hint)
    }

    /// A good frame.
    pub(super) fn note_frame(&mut self, frame: &Frame) {
        let print = fingerprint(frame);
        match self.distinct {
            0 => (self.print, self.distinct) = (print, 1),
            1 if self.print != print => self.distinct = 2,
            _ => {}
        }
        self.frames = self.frames.saturating_add(1);
        if let FrameKind::Fd { brs, .. } = frame.kind() {
            self.fd = true;
            self.switched |= brs;
        }
    }
}

/// FNV-1a over identifier, kind, DLC and data. ESI is left out: it is about the sender's state.
fn fingerprint(frame: &Frame) -> u32 {
    let kind = match frame.kind() {
        FrameKind::Data => 0,
        FrameKind::Remote => 1,
        FrameKind::Fd { brs: false, .. } => 2,
        FrameKind::Fd { brs: true, .. } => 3,
    };
    let head = [kind, u8::from(frame.id().is_extended()), frame.dlc()];
    let bytes = frame.id().raw().to_be_bytes().into_iter().chain(head);
    let step = |hash: u32, byte: u8| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
    frame.data().iter().copied().fold(bytes.fold(0x811C_9DC5, step), step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Id;

    #[test]
    fn equal_frames_count_once_and_different_ones_twice() {
        let frame = |id, data: &[u8]| {
            Frame::new(id, FrameKind::Data, data.len() as u8, data).expect("a frame")
        };
        let first = frame(Id::Base(0x705), &[5]);
        let others = [
            frame(Id::Base(0x706), &[5]),
            frame(Id::Extended(0x705), &[5]),
            frame(Id::Base(0x705), &[4]),
            frame(Id::Base(0x705), &[5, 0]),
            Frame::new(Id::Base(0x705), FrameKind::Remote, 1, &[]).expect("a frame"),
        ];
        for other in others {
            let mut track = Track::default();
            track.note_frame(&first);
            track.note_frame(&first);
            assert_eq!((track.frames, track.distinct), (2, 1));
            track.note_frame(&other);
            assert_eq!((track.frames, track.distinct), (3, 2), "{other:?}");
        }
    }
}
