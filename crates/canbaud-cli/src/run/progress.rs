//! A progress bar for a person who waits at a terminal.

use std::path::PathBuf;
use std::sync::Once;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A run shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);

/// Whether anybody would see a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Audience {
    Person,
    Nobody,
}

/// Bytes of all sources read so far, by any number of threads.
pub(super) struct Progress {
    bar: ProgressBar,
    sizes: Vec<u64>,
    audience: Audience,
    since: Instant,
    shown: Once,
}

impl Progress {
    pub(super) fn new(sources: &[PathBuf], audience: Audience) -> Self {
        // A source without a size is reported when it is opened.
        let size = |path: &PathBuf| path.metadata().map_or(0, |data| data.len());
        let sizes: Vec<u64> = sources.iter().map(size).collect();
        let bar =
            ProgressBar::with_draw_target(Some(sizes.iter().sum()), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(
            "{bar:30} {bytes}/{total_bytes}  {bytes_per_sec}  {eta} left",
        ) {
            bar.set_style(style);
        }
        Self { bar, sizes, audience, since: Instant::now(), shown: Once::new() }
    }

    /// The part that one source has in it.
    pub(super) fn source(&self, index: usize) -> SourceProgress<'_> {
        let size = self.sizes.get(index).copied().unwrap_or(0);
        SourceProgress { all: self, size, done: 0 }
    }

    /// Does `print` with the bar out of the way.
    pub(super) fn print<R>(&self, print: impl FnOnce() -> R) -> R {
        self.bar.suspend(print)
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn advance(&self, bytes: u64) {
        self.bar.inc(bytes);
        if self.audience == Audience::Person && self.since.elapsed() > PATIENCE {
            self.shown.call_once(|| self.bar.set_draw_target(ProgressDrawTarget::stderr()));
        }
    }
}

/// The progress of one source.
pub(super) struct SourceProgress<'a> {
    all: &'a Progress,
    size: u64,
    done: u64,
}

impl SourceProgress<'_> {
    /// `done` of `total` of whatever the reader counts; a second pass does not count twice.
    pub(super) fn set(&mut self, done: u64, total: u64) {
        let share = u128::from(self.size) * u128::from(done.min(total)) / u128::from(total.max(1));
        let now = u64::try_from(share).unwrap_or(self.size).max(self.done);
        if now > self.done {
            self.all.advance(now - self.done);
            self.done = now;
        }
    }
}

impl Drop for SourceProgress<'_> {
    fn drop(&mut self) {
        self.set(1, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_source_counts_its_size_once() {
        let directory = tempfile::tempdir().unwrap();
        let sources: Vec<PathBuf> = [1_000, 500]
            .into_iter()
            .map(|size| {
                let path = directory.path().join(size.to_string());
                std::fs::write(&path, vec![0; size]).unwrap();
                path
            })
            .collect();
        let progress = Progress::new(&sources, Audience::Nobody);
        let mut first = progress.source(0);
        // The reader counts inflated bytes, and passes twice.
        first.set(3_000, 6_000);
        assert_eq!(progress.bar.position(), 500);
        first.set(1, 6_000);
        assert_eq!(progress.bar.position(), 500);
        drop(first);
        drop(progress.source(1));
        assert_eq!(progress.bar.position(), 1_500);
    }
}
