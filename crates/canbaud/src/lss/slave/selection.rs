//! Commands that come in several frames: all have to match, in order, with nothing between.

use crate::lss::{Bound, LssAddress, Part};

/// How far a sequence has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sequence {
    /// None has begun.
    Idle,
    /// Switch state selective: this part is next.
    Selecting(Part),
    /// Identify remote slave: this bound is next.
    Identifying(Bound),
}

/// What a frame of a sequence came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// More frames are to come, or it did not match.
    Open,
    /// The last one, and all matched.
    Complete,
}

impl Sequence {
    /// Part `part` of a selective switch.
    pub(super) fn select(&mut self, own: &LssAddress, part: Part, number: u32) -> Progress {
        let due = part == Part::VendorId || *self == Self::Selecting(part);
        if !due || own.part(part) != number {
            *self = Self::Idle;
            return Progress::Open;
        }
        match part.next() {
            Some(next) => {
                *self = Self::Selecting(next);
                Progress::Open
            }
            None => {
                *self = Self::Idle;
                Progress::Complete
            }
        }
    }

    /// Bound `bound` of a search for remote slaves.
    pub(super) fn identify(&mut self, own: &LssAddress, bound: Bound, number: u32) -> Progress {
        let due = bound == Bound::VendorId || *self == Self::Identifying(bound);
        if !due || !within(own, bound, number) {
            *self = Self::Idle;
            return Progress::Open;
        }
        match bound.next() {
            Some(next) => {
                *self = Self::Identifying(next);
                Progress::Open
            }
            None => {
                *self = Self::Idle;
                Progress::Complete
            }
        }
    }
}

const fn within(own: &LssAddress, bound: Bound, number: u32) -> bool {
    match bound {
        Bound::VendorId => own.vendor_id == number,
        Bound::ProductCode => own.product_code == number,
        Bound::RevisionNumberLow => own.revision_number >= number,
        Bound::RevisionNumberHigh => own.revision_number <= number,
        Bound::SerialNumberLow => own.serial_number >= number,
        Bound::SerialNumberHigh => own.serial_number <= number,
    }
}
