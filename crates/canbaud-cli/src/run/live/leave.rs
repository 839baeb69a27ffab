//! How an adapter is left, and what is said of it: what really happened, after it happened.

use canbaud::detect::scan::Candidate;
use canbaud_link::{After, LinkError, Listener};

use crate::exit::Exit;
use crate::printable::printable;

/// How the adapter was left.
#[derive(Debug, Default)]
pub(super) struct Left {
    /// At this rate, as the user asked.
    pub(super) kept: Option<(Candidate, After)>,
    /// Why it was not left so, although the user asked.
    pub(super) not_kept: Option<LinkError>,
    /// Why it is not as it was found.
    lost: Option<LinkError>,
    /// What cannot be put back by anybody.
    left_over: Option<&'static str>,
    by_hand: Option<String>,
}

/// Leaves the adapter as `wanted`; without that, or if it cannot be, as it was found.
pub(super) fn leave(listener: &mut dyn Listener, wanted: Option<(Candidate, After)>) -> Left {
    let mut left = Left::default();
    if let Some((candidate, after)) = wanted {
        match listener.keep(&candidate, after) {
            Ok(()) => {
                left.kept = wanted;
                return left;
            }
            Err(error) => left.not_kept = Some(error),
        }
    }
    left.lost = listener.restore().err();
    left.left_over = listener.left_over();
    left.by_hand = listener.by_hand();
    left
}

impl Left {
    /// What is said when a signal ended the scan.
    pub(super) fn stopped(&self, source: &str, signal: u8) -> String {
        let so = format!("canbaud: {source}: stopped by signal {signal}");
        match (&self.lost, self.left_over) {
            (Some(_), _) => so,
            (None, None) => format!("{so}; put back as it was found"),
            (None, Some(what)) => format!("{so}; put back as it was found, but {what}"),
        }
    }

    /// Why the adapter is not as it was found; it has lines of its own, and its exit code goes
    /// before any other.
    pub(super) fn lost(&self, source: &str) -> Option<(LinkError, Exit)> {
        let error = self.lost.as_ref()?;
        let reason = match error {
            LinkError::NotRestored { reason, .. } => reason.clone(),
            other => other.to_string(),
        };
        let error = LinkError::NotRestored { adapter: source.to_owned(), reason };
        Some((error, Exit::Unusable))
    }

    /// The way out, for a person.
    pub(super) fn by_hand(&self) -> Option<String> {
        Some(format!("  hint: put it back by hand: {}", printable(self.by_hand.as_ref()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud::detect::scan::{
        Capabilities, Configured, Controller, Evidence, FdSupport, Observation, RateChoice,
    };
    use canbaud::units::{Bitrate, Micros};
    use std::io;
    use std::time::Duration;

    /// An adapter that grants what it is told to.
    #[derive(Debug, Default)]
    struct Adapter {
        keeps: bool,
        restores: bool,
        left_over: Option<&'static str>,
        restored: u32,
    }

    fn refused(what: &str) -> LinkError {
        LinkError::Io { what: what.to_owned(), source: io::ErrorKind::Other.into() }
    }

    impl Controller for Adapter {
        type Error = LinkError;

        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities {
                rates: RateChoice::Only(&[]),
                evidence: Evidence::FramesOnly,
                fd: FdSupport::Classic,
                reconfiguration: Micros(0),
                latency: Micros(0),
            }
        }

        fn configure(&mut self, _: &Candidate) -> Result<Configured, LinkError> {
            Err(refused("configuring"))
        }

        fn start_monitoring(&mut self) -> Result<(), LinkError> {
            Ok(())
        }

        fn observe(&mut self, _: Micros) -> Result<Option<Observation>, LinkError> {
            Ok(None)
        }

        fn stop(&mut self) -> Result<(), LinkError> {
            Ok(())
        }
    }

    impl Listener for Adapter {
        fn wait(&mut self, _: Duration) -> Result<(), LinkError> {
            Ok(())
        }

        fn describe(&self) -> String {
            "test".to_owned()
        }

        fn remarks(&self) -> Vec<String> {
            Vec::new()
        }

        fn keep(&mut self, _: &Candidate, _: After) -> Result<(), LinkError> {
            if self.keeps { Ok(()) } else { Err(refused("keeping")) }
        }

        fn left_over(&self) -> Option<&'static str> {
            self.left_over
        }

        fn by_hand(&self) -> Option<String> {
            Some("ip link set can0 down".to_owned())
        }

        fn restore(&mut self) -> Result<(), LinkError> {
            self.restored += 1;
            if self.restores { Ok(()) } else { Err(refused("cannot configure can0")) }
        }
    }

    const WANTED: Option<(Candidate, After)> =
        Some((Candidate::classic(Bitrate::new(500_000).unwrap()), After::Listening));

    #[test]
    fn a_signal_does_not_hide_that_the_interface_was_not_put_back() {
        let left = leave(&mut Adapter::default(), None);
        assert_eq!(left.stopped("can0", 15), "canbaud: can0: stopped by signal 15");
        let (error, exit) = left.lost("can0").unwrap();
        assert_eq!(exit.code(), 7);
        assert!(
            error
                .to_string()
                .starts_with("can0 could not be put back as it was found: cannot configure can0: "),
            "{error}"
        );
        assert_eq!(left.by_hand().unwrap(), "  hint: put it back by hand: ip link set can0 down");
    }

    #[test]
    fn put_back_is_said_of_what_was_put_back() {
        let mut adapter = Adapter { restores: true, ..Adapter::default() };
        let left = leave(&mut adapter, None);
        assert_eq!(
            left.stopped("can0", 2),
            "canbaud: can0: stopped by signal 2; put back as it was found"
        );
        assert!(left.lost("can0").is_none());
        adapter.left_over = Some("the rate stays");
        assert!(
            leave(&mut adapter, None).stopped("can0", 2).ends_with("found, but the rate stays")
        );
    }

    #[test]
    fn what_cannot_be_kept_is_put_back() {
        let mut adapter = Adapter { restores: true, ..Adapter::default() };
        let left = leave(&mut adapter, WANTED);
        assert!(left.kept.is_none() && left.not_kept.is_some() && left.lost("can0").is_none());
        assert_eq!(adapter.restored, 1);
        let mut adapter = Adapter { keeps: true, ..Adapter::default() };
        let left = leave(&mut adapter, WANTED);
        assert_eq!((left.kept, adapter.restored), (WANTED, 0));
    }
}
