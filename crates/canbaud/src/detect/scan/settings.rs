//! What a scan may be told.

use core::fmt;
use core::str::FromStr;

use crate::units::{Bitrate, Micros, Permille};

/// How a scan goes from candidate to candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Policy {
    /// Weighs evidence: what a candidate was heard to be, and what that says about the others.
    #[default]
    Weighing,
    /// Ascending; the first message without an error is the answer, any error is the next
    /// candidate, silence waits for ever [Koppe, figure 1].
    Koppe,
    /// Each candidate in the list's order for [`Settings::dwell`]; the first frame is the answer.
    FixedDwell,
    /// Measures a rate that is known roughly: listens at every candidate once, and the middle of
    /// those that can be read is the answer. For [`Candidates::around`](super::Candidates::around).
    Survey,
}

impl Policy {
    /// All policies.
    pub const ALL: [Self; 4] = [Self::Weighing, Self::Koppe, Self::FixedDwell, Self::Survey];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Weighing => "weighing",
            Self::Koppe => "koppe",
            Self::FixedDwell => "fixed-dwell",
            Self::Survey => "survey",
        }
    }
}

impl fmt::Display for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no policy has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnknownPolicy;

impl fmt::Display for UnknownPolicy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no such policy: allowed are default, weighing, koppe, fixed-dwell, survey")
    }
}

impl core::error::Error for UnknownPolicy {}

impl FromStr for Policy {
    type Err = UnknownPolicy;

    /// `default` is the name of [`Policy::default`], too.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let named = Self::ALL.into_iter().find(|policy| policy.name() == text);
        named.or_else(|| (text == "default").then(Self::default)).ok_or(UnknownPolicy)
    }
}

/// When a scan without a verdict ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum End {
    /// At its bound ([`super::Scan::bound`]).
    #[default]
    AtBound,
    /// Never: it listens until the caller stops it.
    Never,
}

/// What a scan may be told; the defaults suit an unknown bus.
///
/// ```
/// use canbaud::detect::scan::{Policy, Settings};
/// use canbaud::units::{Bitrate, Micros};
/// let settings = Settings {
///     last_known: Bitrate::new(250_000),
///     pause: Micros::from_ms(500),
///     ..Settings::default()
/// };
/// assert_eq!(settings.policy, Policy::Weighing);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// How to go from candidate to candidate. Default: [`Policy::Weighing`].
    pub policy: Policy,
    /// The nominal bit rate of the last time, which is tried first. Default: none.
    pub last_known: Option<Bitrate>,
    /// The longest pause between frames that a scan has to sit out. Default: 1 s, the usual
    /// heartbeat. The bound grows with it, the time to a verdict on a busy bus does not.
    pub pause: Micros,
    /// How often each candidate may be given that long. Default: 3.
    pub rounds: u32,
    /// Share of the frames that may be destroyed at the right rate. Default: 5 %.
    pub destroyed: Permille,
    /// How long [`Policy::FixedDwell`] stays. Default: 600 ms.
    pub dwell: Micros,
    /// When to give up. Default: at the bound.
    pub end: End,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            policy: Policy::default(),
            last_known: None,
            pause: Micros::from_ms(1000),
            rounds: 3,
            destroyed: Permille::new(50).unwrap_or_default(),
            dwell: Micros::from_ms(600),
            end: End::default(),
        }
    }
}
