//! Error confinement of a CAN node \[ISO 11898-1\]: two counters, three states, twelve rules.
//!
//! | rule | what happens | here |
//! |---|---|---|
//! | 1 | a receiver detects an error: REC + 1 | [`Occurrence::ReceiverError`] |
//! | 2 | a receiver sees dominant right after its error flag: REC + 8 | [`Occurrence::DominantAfterFlag`] |
//! | 3 | a transmitter sends an error flag: TEC + 8, but for two exceptions | [`Occurrence::TransmitterError`] |
//! | 4, 5 | bit error in one's own active error or overload flag: TEC or REC + 8 | [`Occurrence::FlagBitError`] |
//! | 6 | too many dominant bits after a flag: TEC or REC + 8 | [`Occurrence::DominantRun`] |
//! | 7 | successful transmission: TEC - 1 | [`Occurrence::Transmitted`] |
//! | 8 | successful reception: REC - 1, or to 119 to 127 | [`Occurrence::Received`] |
//! | 9, 10 | error passive above 127, error active again when both are below 128 | [`State`] |
//! | 11 | bus-off from TEC 256 on | [`State::BusOff`] |
//! | 12 | error active with both counters 0 after 128 times 11 recessive bits | [`ErrorConfinement::bit`] |
//!
//! Rows D1 and D2 of `docs/mission.md`: the DS80C390 does not raise REC past the passive limit,
//! clears it at bus-off and then counts the 11 recessive bits in it.

use crate::wire::Level;

/// A counter above this makes a node error passive \[ISO 11898-1, rule 9\].
pub const ERROR_ACTIVE_MAX: u16 = 127;
/// A counter at or above this is worth a warning to people \[ISO 11898-1, CiA 303-3\].
pub const WARNING_LIMIT: u16 = 96;
/// A transmit error counter at or above this is bus-off \[ISO 11898-1, rule 11\].
pub const BUS_OFF_LIMIT: u16 = 256;
/// Recessive bits in a row that count as one occurrence on the way out of bus-off.
pub const RECOVERY_BITS: u8 = 11;
/// Occurrences after which bus-off ends \[ISO 11898-1, rule 12\].
pub const RECOVERY_OCCURRENCES: u8 = 128;

/// What a node may do on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum State {
    /// Takes part, and tells errors with dominant flags.
    ErrorActive,
    /// Takes part, and tells errors with recessive flags.
    ErrorPassive,
    /// Drives nothing.
    BusOff,
}

impl State {
    /// The state that error counters stand for, as a controller's registers show them.
    ///
    /// ```
    /// use canbaud::fault::State;
    /// assert_eq!(State::of(127, 127), State::ErrorActive);
    /// assert_eq!(State::of(0, 128), State::ErrorPassive);
    /// assert_eq!(State::of(256, 0), State::BusOff);
    /// ```
    #[must_use]
    pub const fn of(tec: u16, rec: u16) -> Self {
        if tec >= BUS_OFF_LIMIT {
            Self::BusOff
        } else if tec > ERROR_ACTIVE_MAX || rec > ERROR_ACTIVE_MAX {
            Self::ErrorPassive
        } else {
            Self::ErrorActive
        }
    }
}

/// What a node is in the frame at hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// It sends the frame.
    Transmitter,
    /// It receives the frame.
    Receiver,
}

/// What kind of error a transmitter flags; two kinds may leave TEC alone \[rule 3\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FlagCause {
    /// Nobody acknowledged, and all bits of the flag were recessive: no count if the node is
    /// error passive.
    NobodyThere,
    /// A stuff error in the arbitration field: a recessive stuff bit was overwritten. No count.
    OverwrittenStuffBit,
    /// Any other.
    Other,
}

/// What the rules count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Occurrence {
    /// Rule 1: a receiver detects an error, other than a bit error in its own active flag.
    ReceiverError,
    /// Rule 2: the first bit after a receiver's error flag is dominant.
    DominantAfterFlag,
    /// Rule 3: a transmitter sends an error flag.
    TransmitterError(FlagCause),
    /// Rules 4 and 5: a bit error while sending an active error flag or an overload flag.
    FlagBitError(Role),
    /// Rule 6: the 14th dominant bit in a row from the start of an active error flag or overload
    /// flag on, the 8th after a passive error flag, and each further 8th.
    DominantRun(Role),
    /// Rule 7: a frame was sent, acknowledged and without an error up to the end of EOF.
    Transmitted,
    /// Rule 8: a frame was received without an error up to the ACK slot, and acknowledged.
    Received,
}

/// What REC becomes when an error passive receiver receives well: 119 to 127 \[rule 8\].
///
/// The standard leaves the value to the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ReceiveReturn(u8);

impl ReceiveReturn {
    /// The lowest value that the standard allows, and the one of most controllers.
    pub const LOWEST: Self = Self(119);
    /// The highest value that the standard allows.
    pub const HIGHEST: Self = Self(127);

    /// `value`; `None` outside 119 to 127.
    #[must_use]
    pub const fn new(value: u8) -> Option<Self> {
        if value < Self::LOWEST.0 || value > Self::HIGHEST.0 { None } else { Some(Self(value)) }
    }

    /// The value.
    #[must_use]
    pub const fn value(self) -> u8 {
        self.0
    }
}

impl Default for ReceiveReturn {
    fn default() -> Self {
        Self::LOWEST
    }
}

/// The error confinement of one node.
///
/// ```
/// use canbaud::fault::{ErrorConfinement, FlagCause, Occurrence, State};
/// use canbaud::wire::Level;
/// let mut node = ErrorConfinement::new();
/// let error = Occurrence::TransmitterError(FlagCause::Other);
/// let changes: [_; 32] = core::array::from_fn(|_| node.count(error));
/// assert_eq!(changes[15], Some(State::ErrorPassive)); // TEC 128
/// assert_eq!(changes[31], Some(State::BusOff)); // TEC 256
/// for bit in 1..=128 * 11 {
///     let change = node.bit(Level::Recessive);
///     assert_eq!(change, (bit == 128 * 11).then_some(State::ErrorActive));
/// }
/// assert_eq!((node.tec(), node.rec()), (0, 0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ErrorConfinement {
    tec: u16,
    rec: u16,
    receive_return: ReceiveReturn,
    recovery: Option<Recovery>,
}

impl ErrorConfinement {
    /// Error active, both counters 0.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_receive_return(ReceiveReturn::LOWEST)
    }

    /// The same, for a controller that sets REC to `receive_return` by rule 8.
    #[must_use]
    pub const fn with_receive_return(receive_return: ReceiveReturn) -> Self {
        Self { tec: 0, rec: 0, receive_return, recovery: None }
    }

    /// The transmit error counter; at bus-off the value that led there.
    #[must_use]
    pub const fn tec(&self) -> u16 {
        self.tec
    }

    /// The receive error counter, 0 in bus-off.
    #[must_use]
    pub const fn rec(&self) -> u16 {
        self.rec
    }

    /// The state.
    #[must_use]
    pub const fn state(&self) -> State {
        match self.recovery {
            Some(_) => State::BusOff,
            None => State::of(self.tec, self.rec),
        }
    }

    /// How often 11 recessive bits were seen since bus-off; the DS80C390 shows this as REC.
    #[must_use]
    pub const fn recovery(&self) -> Option<Recovery> {
        self.recovery
    }

    /// Counts by rules 1 to 8 and gives the state if it is another one now (rules 9 to 11).
    ///
    /// In bus-off nothing counts: such a node takes no part.
    pub const fn count(&mut self, occurrence: Occurrence) -> Option<State> {
        let passive = match self.state() {
            State::BusOff => return None,
            State::ErrorPassive => true,
            State::ErrorActive => false,
        };
        match occurrence {
            Occurrence::ReceiverError => self.raise_rec(1),
            Occurrence::DominantAfterFlag => self.raise_rec(8),
            Occurrence::TransmitterError(FlagCause::OverwrittenStuffBit) => {}
            Occurrence::TransmitterError(FlagCause::NobodyThere) if passive => {}
            Occurrence::TransmitterError(_) => self.tec += 8,
            Occurrence::FlagBitError(Role::Transmitter)
            | Occurrence::DominantRun(Role::Transmitter) => self.tec += 8,
            Occurrence::FlagBitError(Role::Receiver) | Occurrence::DominantRun(Role::Receiver) => {
                self.raise_rec(8);
            }
            Occurrence::Transmitted => self.tec = self.tec.saturating_sub(1),
            Occurrence::Received if self.rec > ERROR_ACTIVE_MAX => {
                self.rec = self.receive_return.0 as u16;
            }
            Occurrence::Received => self.rec = self.rec.saturating_sub(1),
        }
        let after = State::of(self.tec, self.rec);
        if let State::BusOff = after {
            self.rec = 0;
            self.recovery = Some(Recovery::new());
        }
        match (passive, after) {
            (true, State::ErrorPassive) | (false, State::ErrorActive) => None,
            _ => Some(after),
        }
    }

    /// Past the limit REC stays where it is.
    const fn raise_rec(&mut self, by: u16) {
        if self.rec <= ERROR_ACTIVE_MAX {
            self.rec += by;
        }
    }

    /// A bit was sampled; matters in bus-off alone. `Some` when bus-off ends (rule 12).
    pub const fn bit(&mut self, level: Level) -> Option<State> {
        if let Some(recovery) = &mut self.recovery {
            match level {
                Level::Recessive => recovery.recessive(1),
                Level::Dominant => recovery.dominant(),
            }
        }
        self.recover()
    }

    /// `bits` recessive bits in a row were sampled; as [`Self::bit`] so many times.
    pub const fn recessive_bits(&mut self, bits: u32) -> Option<State> {
        if let Some(recovery) = &mut self.recovery {
            recovery.recessive(bits);
        }
        self.recover()
    }

    const fn recover(&mut self) -> Option<State> {
        match &self.recovery {
            Some(recovery) if recovery.is_complete() => {
                *self = Self::with_receive_return(self.receive_return);
                Some(State::ErrorActive)
            }
            _ => None,
        }
    }
}

/// Counts the 128 occurrences of 11 recessive bits that end bus-off \[rule 12\].
///
/// For a controller that counts them itself this is what it does; for one that software starts
/// anew, software has to count, or the node comes back sooner than the standard allows.
///
/// ```
/// use canbaud::fault::Recovery;
/// let mut recovery = Recovery::new();
/// recovery.recessive(10);
/// recovery.dominant();
/// recovery.recessive(127 * 11 + 10);
/// assert_eq!(recovery.occurrences(), 127);
/// recovery.recessive(1);
/// assert!(recovery.is_complete());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Recovery {
    run: u8,
    occurrences: u8,
}

impl Recovery {
    /// Bus-off begins.
    #[must_use]
    pub const fn new() -> Self {
        Self { run: 0, occurrences: 0 }
    }

    /// `bits` recessive bits in a row.
    pub const fn recessive(&mut self, bits: u32) {
        let run = bits.saturating_add(self.run as u32);
        let occurrences = run / RECOVERY_BITS as u32 + self.occurrences as u32;
        self.run = (run % RECOVERY_BITS as u32) as u8;
        self.occurrences = if occurrences < RECOVERY_OCCURRENCES as u32 {
            occurrences as u8
        } else {
            RECOVERY_OCCURRENCES
        };
    }

    /// A dominant bit: the 11 begin anew.
    pub const fn dominant(&mut self) {
        self.run = 0;
    }

    /// Occurrences so far, 0 to 128.
    #[must_use]
    pub const fn occurrences(&self) -> u8 {
        self.occurrences
    }

    /// Whether bus-off may end.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.occurrences >= RECOVERY_OCCURRENCES
    }
}
