//! What a scan says in the end.

use super::{Candidate, Configured};
use crate::rates::{self, KnownRate};
use crate::units::{Bitrate, Micros};

/// Whether somebody acknowledges the frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Acknowledgement {
    /// Nothing speaks against it; a controller that only listens cannot see more.
    Presumed,
    /// Frames were destroyed at the ACK delimiter, as a lone sender does.
    Missing,
}

/// What is known about CAN FD on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FdSeen {
    /// No CAN FD frame was received.
    No,
    /// CAN FD frames without a bit rate switch: the data rate is unknown.
    NeverSwitched,
    /// CAN FD frames with a bit rate switch: the data rate is [`Found::configured`]'s.
    Switched,
    /// The controller receives classic frames only, and besides good ones there are frames that it
    /// cannot read behind the arbitration field: CAN FD frames look like this to it.
    Suspected,
}

/// A rate that was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// The candidate.
    pub candidate: Candidate,
    /// What the controller was really set to.
    pub configured: Configured,
    /// Frames received at this rate.
    pub frames: u32,
    /// How many of them differ, counted up to 2.
    pub distinct: u8,
    /// Bursts of protocol errors met at this rate.
    pub errors: u32,
    /// From the first poll of the scan to the verdict.
    pub elapsed: Micros,
    /// Candidates listened to, this one included; one that was listened to twice counts twice.
    pub visits: u32,
    /// Whether somebody acknowledges.
    pub acknowledgement: Acknowledgement,
    /// CAN FD.
    pub fd: FdSeen,
    /// How far the bus may be from this rate, in thousandths: what the receiver captures.
    pub reach_permille: u16,
}

impl Found {
    /// The nominal bit rate.
    #[must_use]
    pub const fn nominal(&self) -> Bitrate {
        self.configured.nominal
    }

    /// Between which the bit rate of the bus lies.
    #[must_use]
    pub fn interval(&self) -> (Bitrate, Bitrate) {
        let rate = u64::from(self.nominal().bits_per_second());
        let permille = u64::from(self.reach_permille);
        let bound = |permille: u64| Bitrate::new(u32::try_from(rate * permille / 1000).ok()?);
        let low = bound(1000 - permille).unwrap_or(self.nominal());
        (low, bound(1000 + permille).unwrap_or(self.nominal()))
    }

    /// The rates in use that it may be: a receiver cannot tell 615.385 from 625 kbit/s.
    ///
    /// ```
    /// # use canbaud::detect::scan::*;
    /// # use canbaud::units::{Bitrate, Micros};
    /// # let nominal = Bitrate::new(625_000).unwrap();
    /// # let found = Found {
    /// #     candidate: Candidate::classic(nominal),
    /// #     configured: Configured { nominal, data: None },
    /// #     frames: 2, distinct: 2, errors: 0, elapsed: Micros(0), visits: 1,
    /// #     acknowledgement: Acknowledgement::Presumed, fd: FdSeen::No,
    /// #     reach_permille: 35,
    /// # };
    /// let class: Vec<_> = found.class().map(|known| known.bitrate().to_string()).collect();
    /// assert_eq!(class, ["615.385k", "625k"]);
    /// ```
    pub fn class(&self) -> impl Iterator<Item = &'static KnownRate> + use<> {
        let (low, high) = self.interval();
        rates::nominal().iter().filter(move |known| (low..=high).contains(&known.bitrate()))
    }

    /// The data bit rate, if frames that switch to it were received.
    #[must_use]
    pub const fn data(&self) -> Option<Bitrate> {
        match self.fd {
            FdSeen::Switched => self.configured.data,
            FdSeen::No | FdSeen::NeverSwitched | FdSeen::Suspected => None,
        }
    }
}

/// Why no candidate fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misfit {
    /// The candidate at which a classic-only controller read every frame past the arbitration
    /// field and none to its end: perhaps the rate of a CAN FD bus.
    pub perhaps_fd: Option<Candidate>,
    /// How sure that is.
    pub ground: Ground,
}

/// On what ground it is said that no candidate fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Ground {
    /// Each met so many errors and no frame that it cannot be the rate.
    Refuted,
    /// The time was over: the rate may be one of them whose frames are rare or mostly destroyed.
    OutOfTime,
}

/// What a scan says in the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// This is the rate.
    Found(Found),
    /// Nothing was heard by a controller that would have told errors: nobody sends.
    Silent,
    /// There is traffic, and it was confirmed at none of the rates.
    NoCandidateFits(Misfit),
    /// Nothing was heard, and this controller cannot tell a wrong rate from a silent bus.
    StillOpen,
    /// The controller can be set to none of the candidates.
    Refused,
}
