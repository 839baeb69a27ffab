//! Which of two settings is better, decided without rounding.

/// One setting under comparison.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    /// `|clock - bit rate * fixed divider * product|`, the rate error as a fraction of `product`.
    pub(super) rate_error: u32,
    /// Prescaler times quanta.
    pub(super) product: u32,
    /// `|1000 * TSEG2 - quanta * (1000 - SP)|`, the sample point error as a fraction of `quanta`.
    pub(super) point_error: u32,
    pub(super) quanta: u32,
    pub(super) tseg2: u32,
    pub(super) prescaler: u32,
}

impl Candidate {
    /// Rate and sample point are exactly what was asked for.
    pub(super) const fn is_perfect(&self) -> bool {
        self.rate_error == 0 && self.point_error == 0
    }

    /// Whether `self` ranks before `other`: rate error, sample point error, more quanta, earlier
    /// sample point, smaller prescaler.
    pub(super) const fn beats(&self, other: &Self) -> bool {
        // A rate error is at most the clock (31 bit) and a product at most twice that: < 2^63.
        let mine = self.rate_error as u64 * other.product as u64;
        let others = other.rate_error as u64 * self.product as u64;
        if mine != others {
            return mine < others;
        }
        let mine = self.point_error as u64 * other.quanta as u64;
        let others = other.point_error as u64 * self.quanta as u64;
        if mine != others {
            return mine < others;
        }
        if self.quanta != other.quanta {
            return self.quanta > other.quanta;
        }
        if self.tseg2 != other.tseg2 {
            return self.tseg2 > other.tseg2;
        }
        self.prescaler < other.prescaler
    }
}
