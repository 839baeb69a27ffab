//! The acceptance filter of a SJA1000 in single filter mode, as `M` and `m` set it.

use canbaud::wire::Id;

/// Code and mask; a mask bit of 1 is "don't care".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Filter {
    pub(super) code: u32,
    pub(super) mask: u32,
}

impl Filter {
    /// Everything.
    pub(super) const ALL: Self = Self { code: 0, mask: u32::MAX };

    /// A base identifier is compared in bits 31 to 21, an extended one in bits 31 to 3.
    pub(super) const fn accepts(self, id: Id) -> bool {
        let (value, used) = match id {
            Id::Base(id) => ((id as u32) << 21, 0xFFE0_0000),
            Id::Extended(id) => (id << 3, 0xFFFF_FFF8),
        };
        (value ^ self.code) & !self.mask & used == 0
    }
}
