//! Whether a controller would have read what the decoder read.
//!
//! The decoder takes any clock that it can make sense of; a controller has a sample point and an
//! SJW, and loses count of the bits a few percent off [ISO 11898-1, 10.4].

use canbaud::detect::scan::{Candidate, Capture};
use canbaud::timing::default_sample_point;
use canbaud::wire::{Frame, Level};

use super::track::Track;

/// Bits before the sample point of BRS, at least: where all bits are nominal ones.
const NOMINAL_BITS_BASE: u64 = 16;
const NOMINAL_BITS_EXTENDED: u64 = 35;

/// The bit timing of a controller, in ticks times 2^20.
#[derive(Debug, Clone, Copy)]
pub(super) struct Receiver {
    bit: i128,
    sample_point: i128,
    sjw: i128,
}

impl Receiver {
    /// With SJW of a sixteenth of a bit; of a fifth, for a sweep.
    pub(super) fn new(candidate: &Candidate, bit_q20: u64) -> Self {
        let bit = i128::from(bit_q20);
        let (permille, sjw) = match candidate.capture {
            Capture::Usual => (default_sample_point(candidate.nominal).permille(), bit / 16),
            Capture::Wide => (800, bit / 5),
        };
        Self { bit, sample_point: bit * i128::from(permille) / 1000, sjw }
    }

    /// Whether it keeps in step with the edges of `frame`, from `start` to `end`.
    pub(super) fn reads(&self, track: &Track, frame: &Frame, start: u64, end: u64) -> bool {
        let nominal = match (frame.kind().is_fd(), frame.id().is_extended()) {
            (false, _) => u64::MAX,
            (true, false) => NOMINAL_BITS_BASE,
            (true, true) => NOMINAL_BITS_EXTENDED,
        };
        let first = track.edges.partition_point(|edge| *edge < start);
        let last = track.edges.partition_point(|edge| *edge <= end);
        let edges = track.edges.get(first..last).unwrap_or_default();
        let (mut synchronized, mut late) = (start, 0);
        for (index, edge) in edges.iter().enumerate().skip(1) {
            let since = i128::from(edge - synchronized) << 20;
            let bits = (since + self.bit / 2) / self.bit;
            if (i128::from(edge - start) << 20) > i128::from(nominal).saturating_mul(self.bit) {
                break;
            }
            let error = late + since - bits * self.bit;
            if error >= self.sample_point || error <= self.sample_point - self.bit {
                return false;
            }
            if Self::level(track, first + index) == Level::Dominant {
                late = error - error.clamp(-self.sjw, self.sjw);
                synchronized = *edge;
            }
        }
        true
    }

    /// The level behind edge `index`.
    fn level(track: &Track, index: usize) -> Level {
        if index.is_multiple_of(2) { track.level.toggled() } else { track.level }
    }
}
