//! What lies between a controller and the star point of the bus.

use canbaud::wire::Level;

use crate::rng::mix;
use crate::time::{Span, Time};

/// Delays of a transceiver and of the wire from it to the star point.
///
/// The two delays of a path differ by the asymmetry: with `rx_dominant` shorter than
/// `rx_recessive`, dominant bits read long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transceiver {
    /// TXD to bus, recessive to dominant.
    pub tx_dominant: Span,
    /// TXD to bus, dominant to recessive.
    pub tx_recessive: Span,
    /// Bus to RXD, recessive to dominant.
    pub rx_dominant: Span,
    /// Bus to RXD, dominant to recessive.
    pub rx_recessive: Span,
    /// Wire to the star point, one way.
    pub propagation: Span,
    /// Largest deviation of an edge at RXD to either side.
    pub jitter: Span,
}

impl Default for Transceiver {
    /// 60 ns each way, symmetrical, no wire, no jitter.
    fn default() -> Self {
        Self::symmetrical(Span::from_ns(60))
    }
}

impl Transceiver {
    /// The same delay `one_way` on each path, no wire, no jitter.
    #[must_use]
    pub const fn symmetrical(one_way: Span) -> Self {
        Self {
            tx_dominant: one_way,
            tx_recessive: one_way,
            rx_dominant: one_way,
            rx_recessive: one_way,
            propagation: Span::ZERO,
            jitter: Span::ZERO,
        }
    }

    /// When a change of TXD at `at` reaches the star point.
    #[inline]
    pub(crate) fn to_star(self, at: Time, to: Level) -> Time {
        let delay = match to {
            Level::Dominant => self.tx_dominant,
            Level::Recessive => self.tx_recessive,
        };
        at + delay + self.propagation
    }

    /// The longest way from TXD over the star point back to RXD.
    pub(crate) fn longest_loop(&self) -> Span {
        let dominant = self.tx_dominant + self.rx_dominant;
        let recessive = self.tx_recessive + self.rx_recessive;
        dominant.max(recessive) + self.propagation + self.propagation + self.jitter
    }

    /// The shortest way from TXD to the star point.
    pub(crate) fn shortest_way_out(&self) -> Span {
        self.tx_dominant.min(self.tx_recessive) + self.propagation
    }

    /// When an edge at the star point reaches RXD; `lot` decides on the jitter.
    #[inline]
    pub(crate) fn to_rxd(self, at: Time, to: Level, lot: u64) -> Time {
        let delay = match to {
            Level::Dominant => self.rx_dominant,
            Level::Recessive => self.rx_recessive,
        };
        let arrival = at + delay + self.propagation;
        let jitter = self.jitter.femtoseconds();
        if jitter == 0 {
            return arrival;
        }
        let offset = ((u128::from(mix(lot)) * u128::from(2 * jitter + 1)) >> 64) as u64;
        (arrival + Span::from_fs(offset) - self.jitter).max(at)
    }
}
