//! The method of Infineon's AP2925: the shortest of a hundred dominant levels is one bit.
//!
//! Kept as it is described, for the smallest controllers and as the baseline that the lattice
//! detector is measured against. It needs an acknowledge (the one certain lone dominant bit), so
//! two more nodes, ten or more ticks a bit, and a single glitch spoils it; it proves nothing.

/// Takes dominant lengths, gives the shortest of [`MinimumPulse::MEASUREMENTS`].
///
/// ```
/// use canbaud::detect::MinimumPulse;
/// let mut minimum = MinimumPulse::new();
/// for _ in 0..99 {
///     minimum.push(48);
///     assert_eq!(minimum.shortest(), None);
/// }
/// minimum.push(24);
/// assert_eq!(minimum.shortest(), Some(24));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MinimumPulse {
    count: u32,
    shortest: u32,
}

impl MinimumPulse {
    /// Dominant levels to measure [AP2925, step 2].
    pub const MEASUREMENTS: u32 = 100;

    /// Before the first measurement.
    #[must_use]
    pub const fn new() -> Self {
        Self { count: 0, shortest: u32::MAX }
    }

    /// Takes the length of one dominant level in ticks.
    pub const fn push(&mut self, dominant_ticks: u32) {
        if self.count < Self::MEASUREMENTS {
            self.count += 1;
            if dominant_ticks < self.shortest {
                self.shortest = dominant_ticks;
            }
        }
    }

    /// The shortest level in ticks, once all measurements are made.
    #[must_use]
    pub const fn shortest(&self) -> Option<u32> {
        if self.count < Self::MEASUREMENTS { None } else { Some(self.shortest) }
    }
}

impl Default for MinimumPulse {
    fn default() -> Self {
        Self::new()
    }
}
