//! The standard streams of a program that holds an adapter. Whoever does not read is waited for until
//! a signal comes, or until a time: what was changed must still be put back.

#[cfg(not(unix))]
use std::io;
#[cfg(not(unix))]
use std::time::Instant;

/// A standard stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outlet {
    /// The standard output.
    Output,
    /// The standard error.
    Errors,
}

#[cfg(unix)]
mod wait {
    use std::io;
    use std::os::fd::{AsFd, BorrowedFd};
    use std::time::{Duration, Instant};

    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::io::Errno;
    use rustix::pipe::PIPE_BUF;

    use super::Outlet;
    use crate::run::live::signal;

    /// Signals are looked for this often at least.
    const SLICE: Duration = Duration::from_millis(50);

    impl Outlet {
        /// Writes `text`, at once.
        ///
        /// # Errors
        /// `Interrupted`: a signal came. `TimedOut`: it is `until`. In both cases nobody reads.
        pub(crate) fn write(self, text: &str, until: Option<Instant>) -> io::Result<()> {
            match self {
                Self::Output => write(io::stdout().as_fd(), text.as_bytes(), until),
                Self::Errors => write(io::stderr().as_fd(), text.as_bytes(), until),
            }
        }

        /// Whether somebody reads, so that a little can be written without a wait.
        pub(crate) fn is_read(self) -> bool {
            match self {
                Self::Output => takes(io::stdout().as_fd(), Duration::ZERO),
                Self::Errors => takes(io::stderr().as_fd(), Duration::ZERO),
            }
        }
    }

    fn write(stream: BorrowedFd<'_>, text: &[u8], until: Option<Instant>) -> io::Result<()> {
        let mut rest = text;
        while !rest.is_empty() {
            wait(stream, until)?;
            match rustix::io::write(stream, piece(rest)) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => rest = rest.get(count..).unwrap_or_default(),
                Err(Errno::INTR | Errno::AGAIN) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// What a pipe that takes anything takes whole: lines, if they are not too long.
    pub(super) fn piece(text: &[u8]) -> &[u8] {
        let most = text.get(..PIPE_BUF).unwrap_or(text);
        let lines = most.iter().rposition(|byte| *byte == b'\n').map_or(most.len(), |at| at + 1);
        most.get(..lines).unwrap_or(most)
    }

    fn wait(stream: BorrowedFd<'_>, until: Option<Instant>) -> io::Result<()> {
        loop {
            let left = until.map(|until| until.saturating_duration_since(Instant::now()));
            // Both are looked at before the stream: it is asked once more behind them.
            let over = match (signal(), left) {
                (Some(_), _) => Some(io::ErrorKind::Interrupted),
                (None, Some(Duration::ZERO)) => Some(io::ErrorKind::TimedOut),
                (None, _) => None,
            };
            let slice = if over.is_some() { Duration::ZERO } else { SLICE };
            if takes(stream, left.map_or(slice, |left| left.min(slice))) {
                return Ok(());
            }
            if let Some(kind) = over {
                return Err(kind.into());
            }
        }
    }

    /// Whether it takes something, or has an error to tell, within `time`.
    fn takes(stream: BorrowedFd<'_>, time: Duration) -> bool {
        let time = Timespec::try_from(time).unwrap_or_default();
        match poll(&mut [PollFd::new(&stream, PollFlags::OUT)], Some(&time)) {
            Ok(count) => count > 0,
            Err(Errno::INTR) => false,
            // Not every system can wait for every file.
            Err(_) => true,
        }
    }

    #[cfg(test)]
    mod tests {
        use super::{PIPE_BUF, piece};

        #[test]
        fn pieces_are_whole_lines_that_fit_a_pipe() {
            assert_eq!(piece(b"{}\n{}\n"), b"{}\n{}\n");
            let long = [vec![b'x'; 100], vec![b'\n'], vec![b'y'; PIPE_BUF]].concat();
            assert_eq!(piece(&long).len(), 101);
            assert_eq!(piece(&vec![b'y'; PIPE_BUF + 1]).len(), PIPE_BUF);
        }
    }
}

#[cfg(not(unix))]
impl Outlet {
    /// Writes `text`, at once.
    ///
    /// # Errors
    /// Nobody reads any more.
    pub(crate) fn write(self, text: &str, _: Option<Instant>) -> io::Result<()> {
        use std::io::Write;
        match self {
            Self::Output => {
                let mut out = io::stdout().lock();
                out.write_all(text.as_bytes()).and_then(|()| out.flush())
            }
            Self::Errors => io::stderr().lock().write_all(text.as_bytes()),
        }
    }

    /// Whether somebody reads, as far as is known.
    pub(crate) fn is_read(self) -> bool {
        true
    }
}
