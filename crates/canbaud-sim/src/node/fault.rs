//! Fault confinement: the two error counters and what follows from them [ISO 11898-1].
//!
//! Rules 1 to 8 change counters; 9 to 12 are [`FaultConfinement::state`] and
//! [`FaultConfinement::recover`].

use crate::event::{FaultState, Role, Rule};

/// REC after a good reception of a node that was past the error passive limit.
const REC_AFTER_PASSIVE: u16 = 119;
/// Sequences of 11 recessive bits after which bus-off ends.
pub(crate) const RECOVERY_SEQUENCES: u8 = 128;

/// TEC, REC and the state that they stand for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FaultConfinement {
    tec: u16,
    rec: u16,
    bus_off: bool,
}

impl FaultConfinement {
    /// Counters as given, for a node that starts with a past; TEC above 255 is bus-off.
    #[must_use]
    pub const fn with_counters(tec: u16, rec: u16) -> Self {
        Self { tec, rec, bus_off: tec > 255 }
    }

    /// The transmit error counter.
    #[must_use]
    pub const fn tec(&self) -> u16 {
        self.tec
    }

    /// The receive error counter.
    #[must_use]
    pub const fn rec(&self) -> u16 {
        self.rec
    }

    /// Rules 9, 10 and 11: error passive above 127, bus-off from TEC 256 on.
    #[must_use]
    pub const fn state(&self) -> FaultState {
        if self.bus_off {
            FaultState::BusOff
        } else if self.tec > 127 || self.rec > 127 {
            FaultState::ErrorPassive
        } else {
            FaultState::ErrorActive
        }
    }

    /// Applies a counting rule; the role matters for rule 6 only.
    pub(crate) fn count(&mut self, rule: Rule, role: Role) {
        match rule {
            Rule::ReceiverError => self.raise_rec(1),
            Rule::DominantAfterFlag | Rule::ReceiverFlagError => self.raise_rec(8),
            Rule::TransmitterError | Rule::TransmitterFlagError => self.raise_tec(),
            Rule::DominantRun => match role {
                Role::Transmitter => self.raise_tec(),
                Role::Receiver => self.raise_rec(8),
            },
            Rule::Transmitted => self.tec = self.tec.saturating_sub(1),
            Rule::Received if self.rec > 127 => self.rec = REC_AFTER_PASSIVE,
            Rule::Received => self.rec = self.rec.saturating_sub(1),
        }
    }

    fn raise_rec(&mut self, by: u16) {
        if self.rec <= 127 {
            self.rec += by;
        }
    }

    fn raise_tec(&mut self) {
        self.tec += 8;
        self.bus_off |= self.tec > 255;
    }

    /// Rule 12: the end of bus-off.
    pub(crate) fn recover(&mut self) {
        *self = Self::default();
    }
}
