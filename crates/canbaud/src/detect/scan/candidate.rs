//! A rate to listen at.

use crate::units::Bitrate;

/// How far a receiver's clock may be from the sender's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Capture {
    /// The usual bit timing: the default sample point, for a rate that is known.
    #[default]
    Usual,
    /// The widest that the controller offers (largest SJW, long PHASE_SEG2), for a sweep.
    Wide,
}

impl Capture {
    /// How far the bus may be from the receiver's rate and still be read, in thousandths, at most
    /// (`docs/scan.md`); it depends on sample point and SJW.
    #[must_use]
    pub const fn reach_permille(self) -> u16 {
        match self {
            Self::Usual => 35,
            Self::Wide => 60,
        }
    }
}

/// What to set the controller to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Candidate {
    /// The nominal bit rate.
    pub nominal: Bitrate,
    /// The data bit rate, where CAN FD frames are to be received with their rate switch.
    pub data: Option<Bitrate>,
    /// The bit timing to make it with.
    pub capture: Capture,
}

impl Candidate {
    /// `nominal` without a data rate, with the usual bit timing.
    #[must_use]
    pub const fn classic(nominal: Bitrate) -> Self {
        Self { nominal, data: None, capture: Capture::Usual }
    }
}
