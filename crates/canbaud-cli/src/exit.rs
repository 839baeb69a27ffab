//! The exit codes, a promise to scripts.

use std::process::ExitCode;

use crate::report::Outcome;

/// What a run came to, in rising order of how much it asks of the user: the code of a run over
/// many files is that of the highest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Exit {
    /// A rate was found and proven.
    Found,
    /// Nothing moved on the line.
    NoTraffic,
    /// There was activity, but no proof, or two rates.
    Undecided,
    /// No bit timing meets the request.
    Impossible,
    /// A file could not be read, or an output could not be written.
    Unreadable,
    /// The user may not do that to the adapter.
    Permission,
    /// The adapter is absent, gone, or cannot listen.
    Unusable,
    /// The command line was wrong.
    Usage,
    /// A signal of this number ended it; everything was put back.
    Stopped(u8),
}

impl Exit {
    /// The number that the shell sees.
    pub(crate) const fn code(self) -> u8 {
        match self {
            Self::Found => 0,
            Self::Usage => 2,
            Self::Undecided | Self::Impossible => 3,
            Self::NoTraffic => 4,
            Self::Unreadable => 5,
            Self::Permission => 6,
            Self::Unusable => 7,
            // As shells tell of signals.
            Self::Stopped(signal) => 128_u8.saturating_add(signal),
        }
    }
}

impl From<Outcome> for Exit {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Found => Self::Found,
            Outcome::Undecided | Outcome::Conflict => Self::Undecided,
            Outcome::NoTraffic => Self::NoTraffic,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_the_documented_ones() {
        let codes = [Exit::Found, Exit::Usage, Exit::Undecided, Exit::NoTraffic, Exit::Unreadable]
            .map(Exit::code);
        assert_eq!(codes, [0, 2, 3, 4, 5]);
        assert_eq!(Exit::Impossible.code(), 3);
        assert_eq!(
            [Exit::Permission, Exit::Unusable, Exit::Stopped(15)].map(Exit::code),
            [6, 7, 143]
        );
    }

    #[test]
    fn many_files_give_the_code_that_asks_most_of_the_user() {
        assert_eq!(Exit::Found.max(Exit::NoTraffic), Exit::NoTraffic);
        assert_eq!(Exit::NoTraffic.max(Exit::Undecided), Exit::Undecided);
        assert_eq!(Exit::Undecided.max(Exit::Unreadable), Exit::Unreadable);
    }

    #[test]
    fn conflict_counts_as_undecided() {
        assert_eq!(Exit::from(Outcome::Conflict), Exit::Undecided);
    }
}
