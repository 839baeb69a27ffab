//! The acceptance filter that `M` (code) and `m` (mask, 1 is "don't care") set.

use canbaud::wire::Id;

use super::firmware::Firmware;

/// Code, mask and what their bits mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Filter {
    pub(super) code: u32,
    pub(super) mask: u32,
    layout: Layout,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// One filter of a SJA1000: a base identifier in bits 31 to 21, an extended one in 31 to 3.
    Single,
    /// Bit 31 tells base identifiers, bits 28 to 0 are the identifier.
    Simple,
    /// Two filters for the first eleven bits of an identifier: bits 31 to 21 and 15 to 5.
    Dual,
}

impl Filter {
    /// Everything passes.
    pub(super) const fn new(firmware: Firmware) -> Self {
        let layout = match firmware {
            Firmware::Lawicel | Firmware::Canable1 => Layout::Single,
            Firmware::Canable2 | Firmware::Canable2Stock => Layout::Simple,
            Firmware::Usbtin => Layout::Dual,
        };
        Self { code: 0, mask: u32::MAX, layout }
    }

    pub(super) const fn accepts(self, id: Id) -> bool {
        match self.layout {
            Layout::Single => {
                let (value, used) = match id {
                    Id::Base(id) => ((id as u32) << 21, 0xFFE0_0000),
                    Id::Extended(id) => (id << 3, 0xFFFF_FFF8),
                };
                self.agrees(value, used)
            }
            Layout::Simple => {
                let (value, used) = match id {
                    Id::Base(id) => (0x8000_0000 | id as u32, 0x8000_07FF),
                    Id::Extended(id) => (id, 0x9FFF_FFFF),
                };
                self.agrees(value, used)
            }
            Layout::Dual => {
                let first = match id {
                    Id::Base(id) => id as u32,
                    Id::Extended(id) => id >> 18,
                };
                self.agrees(first << 21, 0xFFE0_0000) || self.agrees(first << 5, 0x0000_FFE0)
            }
        }
    }

    const fn agrees(self, value: u32, used: u32) -> bool {
        (value ^ self.code) & !self.mask & used == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(firmware: Firmware, code: u32, mask: u32, id: Id) -> bool {
        Filter { code, mask, ..Filter::new(firmware) }.accepts(id)
    }

    #[test]
    fn simple_filter_passes_what_its_document_says() {
        let simple = |code, mask, id| passes(Firmware::Canable2, code, mask, id);
        let (base, extended) = (Id::Base(0x100), Id::Extended(0x18DB_33F1));
        assert!(simple(0, u32::MAX, base) && simple(0, u32::MAX, extended));
        assert!(simple(0x8000_0100, 0, base));
        assert!(!simple(0x8000_0100, 0, Id::Base(0x101)));
        assert!(!simple(0x8000_0100, 0, Id::Extended(0x100)));
        assert!(simple(0x18DB_0000, 0xFFFF, extended));
        assert!(!simple(0x18DB_0000, 0xFFFF, Id::Extended(0x18DA_33F1)));
        assert!(!simple(0x18DB_0000, 0xFFFF, base));
    }

    #[test]
    fn dual_filter_passes_either_of_two() {
        let dual = |id| passes(Firmware::Usbtin, 0x2460_0000 | 0x123 << 5, 0x001F_001F, id);
        assert!(dual(Id::Base(0x123)) && !dual(Id::Base(0x124)));
        let two = |id| passes(Firmware::Usbtin, 0x2460_0000 | 0x7FF << 5, 0x001F_001F, id);
        assert!(two(Id::Base(0x123)) && two(Id::Base(0x7FF)) && !two(Id::Base(0x7FE)));
        assert!(two(Id::Extended(0x123 << 18 | 5)));
    }
}
