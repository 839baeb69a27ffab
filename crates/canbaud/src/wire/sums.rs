//! Sums over the edges of one frame from which its bit time follows by least squares.

use crate::fixed::{div_small, ratio_q20};

/// Sums over edges of one polarity: edge `k` lies `m_k` bits and `t_k` ticks after the first
/// edge of the phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct EdgeSums {
    n: u32,
    m: u32,
    mm: u64,
    t: u64,
    mt: u64,
}

impl EdgeSums {
    /// Takes one edge.
    #[inline]
    pub(crate) fn push(&mut self, bits: u32, ticks: u32) {
        self.n += 1;
        self.m += bits;
        self.mm += u64::from(bits) * u64::from(bits);
        self.t += u64::from(ticks);
        self.mt += u64::from(bits) * u64::from(ticks);
    }
}

/// The edges of one phase of a frame; both polarities, because transceivers shift them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PhaseSums {
    /// Recessive to dominant.
    pub(crate) falling: EdgeSums,
    /// Dominant to recessive.
    pub(crate) rising: EdgeSums,
}

/// What least squares says about one phase: a common bit time for both polarities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Fit {
    /// Sum of squared deviations of the bit positions from their mean, times 2^8: the weight.
    pub sxx_q8: u64,
    /// The mixed sum, in ticks times 2^8.
    pub sxy_q8: u64,
    /// Number of edges.
    pub edges: u32,
    /// How much later dominant-to-recessive edges come than recessive-to-dominant ones,
    /// in ticks times 2^8.
    pub asymmetry_q8: i32,
}

impl Fit {
    /// Bit time in ticks times 2^20; `None` if the edges do not determine one.
    #[must_use]
    pub fn ticks_q20(&self) -> Option<u64> {
        ratio_q20(self.sxy_q8, self.sxx_q8)
    }
}

impl PhaseSums {
    /// Least squares with one slope and an intercept for each polarity.
    #[must_use]
    pub fn fit(&self) -> Fit {
        let (fxx, fxy) = self.falling.centred_q8();
        let (rxx, rxy) = self.rising.centred_q8();
        let mut fit = Fit {
            sxx_q8: fxx + rxx,
            sxy_q8: fxy + rxy,
            edges: self.falling.n + self.rising.n,
            asymmetry_q8: 0,
        };
        if let (Some(ticks_q20), true) = (fit.ticks_q20(), self.falling.n > 0 && self.rising.n > 0)
        {
            let difference = self.rising.late_q20(ticks_q20) - self.falling.late_q20(ticks_q20);
            let late_q8 = (difference >> 12).clamp(i64::from(i32::MIN), i64::from(i32::MAX));
            fit.asymmetry_q8 = late_q8 as i32;
        }
        fit
    }
}

impl EdgeSums {
    /// Sums of squares and products about the means, times 2^8.
    ///
    /// A frame has less than 2^10 edges and bits, so every product fits 64 bits.
    fn centred_q8(&self) -> (u64, u64) {
        if self.n < 2 {
            return (0, 0);
        }
        let (n, m) = (u64::from(self.n), u64::from(self.m));
        let xx = n.wrapping_mul(self.mm).wrapping_sub(m.wrapping_mul(m));
        let xy = n.wrapping_mul(self.mt).saturating_sub(m.wrapping_mul(self.t));
        let whole = div_small(xy, self.n);
        let rest = xy - whole * n;
        (div_small(xx << 8, self.n), (whole << 8) + div_small(rest << 8, self.n))
    }

    /// Mean of the ticks that the edges are behind a grid of `ticks_q20`, times 2^20.
    fn late_q20(&self, ticks_q20: u64) -> i64 {
        let grid = ticks_q20.wrapping_mul(u64::from(self.m));
        let late = (self.t << 20).wrapping_sub(grid) as i64;
        let mean = div_small(late.unsigned_abs(), self.n) as i64;
        if late < 0 { -mean } else { mean }
    }
}
