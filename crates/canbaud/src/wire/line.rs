//! What a line shows: electrical levels, bus levels, and the polarity between them.

/// The level of a recorded line, as a logic analyser or a timer input sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Logic {
    /// Below the threshold.
    Low,
    /// Above the threshold.
    High,
}

impl Logic {
    /// The other level.
    ///
    /// ```
    /// use canbaud::wire::Logic;
    /// assert_eq!(Logic::Low.toggled(), Logic::High);
    /// ```
    #[must_use]
    pub const fn toggled(self) -> Self {
        match self {
            Self::Low => Self::High,
            Self::High => Self::Low,
        }
    }
}

/// The level of the bus [ISO 11898-1]: dominant (logic 0) wins over recessive (logic 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Level {
    /// Logic 0; any one node can make the bus dominant.
    Dominant,
    /// Logic 1; the bus is recessive only while no node drives it.
    Recessive,
}

impl Level {
    /// The other level.
    ///
    /// ```
    /// use canbaud::wire::Level;
    /// assert_eq!(Level::Dominant.toggled(), Level::Recessive);
    /// ```
    #[must_use]
    pub const fn toggled(self) -> Self {
        match self {
            Self::Dominant => Self::Recessive,
            Self::Recessive => Self::Dominant,
        }
    }
}

/// How a recorded line maps to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Polarity {
    /// High is recessive: RXD and TXD of a transceiver, CAN_L.
    Normal,
    /// High is dominant: CAN_H, CAN_H minus CAN_L, an inverting probe.
    Inverted,
}

impl Polarity {
    /// The bus level that `logic` stands for.
    ///
    /// ```
    /// use canbaud::wire::{Level, Logic, Polarity};
    /// assert_eq!(Polarity::Normal.level(Logic::High), Level::Recessive);
    /// assert_eq!(Polarity::Inverted.level(Logic::High), Level::Dominant);
    /// ```
    #[must_use]
    pub const fn level(self, logic: Logic) -> Level {
        match (self, logic) {
            (Self::Normal, Logic::High) | (Self::Inverted, Logic::Low) => Level::Recessive,
            (Self::Normal, Logic::Low) | (Self::Inverted, Logic::High) => Level::Dominant,
        }
    }
}
