//! Runs many cases on all cores; what comes out does not depend on how many there are.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::case::Draw;
use crate::judge::{self, Outcome};

/// Cases that a thread takes at once.
const CHUNK: usize = 32;

/// What comes of each, in order.
pub(crate) fn run(draws: &[Draw]) -> Vec<Option<Outcome>> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let first = next.fetch_add(CHUNK, Ordering::Relaxed);
            let Some(rest) = draws.get(first..) else { return done };
            if rest.is_empty() {
                return done;
            }
            let outcomes: Vec<_> = rest.iter().take(CHUNK).map(judge::run).collect();
            done.push((first, outcomes));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut done: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let join = |thread: std::thread::ScopedJoinHandle<'_, _>| match thread.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        threads.into_iter().flat_map(join).collect()
    });
    done.sort_by_key(|(first, _)| *first);
    done.into_iter().flat_map(|(_, outcomes)| outcomes).collect()
}
