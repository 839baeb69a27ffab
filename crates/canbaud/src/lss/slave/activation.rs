//! Activate bit timing: two periods of silence with the switch between them [CiA 305].

use crate::lss::RateSetting;
use crate::units::Micros;

/// Where a slave is between the command and the end of the second period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Activation {
    /// Not under way.
    Idle,
    /// Commanded; the node was not told yet.
    Commanded { rate: RateSetting, switch_at: Micros, resume_at: Micros },
    /// First period: silent at the old bit rate.
    BeforeSwitch { rate: RateSetting, switch_at: Micros, resume_at: Micros },
    /// Second period: silent at the new bit rate.
    AfterSwitch { resume_at: Micros },
    /// Silent until the bit rate is found, and until the second period is over.
    Detecting { resume_at: Micros },
}

/// What is to be done now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    Stop,
    Switch(RateSetting),
    Resume,
}

impl Activation {
    /// The command came at `now`.
    pub(super) fn begin(rate: RateSetting, now: Micros, switch_delay_ms: u16) -> Self {
        let delay = Micros::from_ms(u64::from(switch_delay_ms));
        let switch_at = now + delay;
        Self::Commanded { rate, switch_at, resume_at: switch_at + delay }
    }

    pub(super) fn poll(&mut self, now: Micros) -> Option<Step> {
        match *self {
            Self::Commanded { rate, switch_at, resume_at } => {
                *self = Self::BeforeSwitch { rate, switch_at, resume_at };
                Some(Step::Stop)
            }
            Self::BeforeSwitch { rate, switch_at, resume_at } if now >= switch_at => {
                *self = match rate {
                    RateSetting::Fixed(_) => Self::AfterSwitch { resume_at },
                    RateSetting::Automatic => Self::Detecting { resume_at },
                };
                Some(Step::Switch(rate))
            }
            Self::AfterSwitch { resume_at } if now >= resume_at => {
                *self = Self::Idle;
                Some(Step::Resume)
            }
            Self::Idle
            | Self::BeforeSwitch { .. }
            | Self::AfterSwitch { .. }
            | Self::Detecting { .. } => None,
        }
    }

    /// The bit rate was found.
    pub(super) fn rate_found(&mut self) {
        if let Self::Detecting { resume_at } = *self {
            *self = Self::AfterSwitch { resume_at };
        }
    }

    pub(super) const fn deadline(&self) -> Micros {
        match *self {
            Self::Commanded { .. } => Micros(0),
            Self::BeforeSwitch { switch_at, .. } => switch_at,
            Self::AfterSwitch { resume_at } => resume_at,
            Self::Idle | Self::Detecting { .. } => Micros::MAX,
        }
    }
}
