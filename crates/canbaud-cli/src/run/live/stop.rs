//! Signals that end a scan, in order: whatever it changed is put back first.

use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use signal_hook::consts::{SIGINT, SIGTERM};

/// The number of the signal that came, 0 before: signals are those of the whole program.
static SIGNAL: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// The number of the signal that came, if they are noted.
pub(crate) fn signal() -> Option<u8> {
    match SIGNAL.load(Ordering::Relaxed) {
        0 => None,
        number => Some(u8::try_from(number).unwrap_or(u8::MAX)),
    }
}

/// Signals are noted.
#[derive(Debug)]
pub(crate) struct Stop(());

/// A set of signals, signal 1 in bit 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Signals(u64);

impl Signals {
    /// The line `SigIgn` of `/proc/PID/status`.
    fn ignored_in(status: &str) -> Option<Self> {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok().map(Self)
    }

    fn has(self, number: i32) -> bool {
        let bit = number.checked_sub(1).and_then(|bit| u32::try_from(bit).ok());
        bit.and_then(|bit| self.0.checked_shr(bit)).is_some_and(|rest| rest & 1 == 1)
    }
}

/// What whoever started this program wants it to ignore, where the system tells: Linux does.
fn ignored() -> Signals {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    Signals::ignored_in(&status).unwrap_or(Signals(0))
}

impl Stop {
    /// From now on signals are noted instead of ending the program; those that it was started to
    /// ignore (`nohup`) stay ignored.
    pub(crate) fn install() -> io::Result<Self> {
        let mut wanted = vec![SIGINT, SIGTERM];
        #[cfg(unix)]
        wanted.extend([signal_hook::consts::SIGHUP, signal_hook::consts::SIGQUIT]);
        let ignored = ignored();
        for number in wanted.into_iter().filter(|number| !ignored.has(*number)) {
            // Numbers of signals are small and positive.
            let value = usize::try_from(number).unwrap_or(usize::MAX);
            signal_hook::flag::register_usize(number, Arc::clone(&SIGNAL), value)?;
        }
        Ok(Self(()))
    }

    /// The number of the signal that came.
    pub(crate) fn signal(&self) -> Option<u8> {
        signal()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_bits_from_one() {
        // As nohup leaves it: SIGHUP (1), and SIGPIPE (13), which is none of ours.
        let status = "SigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\nSigCgt:\t0\n";
        let ignored = Signals::ignored_in(status).unwrap();
        let has = [0, 1, 2, 3, 13, 15, 64, 65, -1].map(|number| ignored.has(number));
        assert_eq!(has, [false, true, false, false, true, false, false, false, false]);
        assert_eq!(Signals::ignored_in("Name:\tcanbaud\n"), None);
    }
}
