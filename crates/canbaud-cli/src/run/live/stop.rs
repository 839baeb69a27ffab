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

impl Stop {
    /// From now on signals are noted instead of ending the program.
    pub(crate) fn install() -> io::Result<Self> {
        let mut wanted = vec![SIGINT, SIGTERM];
        #[cfg(unix)]
        wanted.extend([signal_hook::consts::SIGHUP, signal_hook::consts::SIGQUIT]);
        for number in wanted {
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
