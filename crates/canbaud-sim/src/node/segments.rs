//! A bit timing in the quanta of one clock.

use crate::clock::{Clock, Quantum};
use crate::timing::BitTiming;

/// Equal bits in a row that stuffing allows.
const RUN: usize = 5;

/// Lengths that a bit time is put together from.
#[derive(Debug, Clone)]
pub(super) struct Segments {
    pub(super) quantum: Quantum,
    /// So many whole bits, as often as stuffing allows equal ones.
    pub(super) bits: [Quantum; RUN + 1],
    /// From a sample point to the start of the next bit.
    pub(super) to_start: Quantum,
    /// Quanta from the start of the bit to its sample point.
    pub(super) sample: u64,
    pub(super) phase_seg2: u64,
    pub(super) sjw: u64,
}

impl Segments {
    pub(super) fn new(clock: &Clock, timing: &BitTiming) -> Self {
        let quanta = |count: u32| clock.quantum(timing.prescaler() * count);
        Self {
            quantum: quanta(1),
            bits: core::array::from_fn(|bits| quanta(bits as u32 * timing.quanta())),
            to_start: quanta(timing.phase_seg2()),
            sample: timing.sample_quanta().into(),
            phase_seg2: timing.phase_seg2().into(),
            sjw: timing.sjw().into(),
        }
    }

    /// Quanta of the bit.
    pub(super) const fn total(&self) -> u64 {
        self.sample + self.phase_seg2
    }
}
