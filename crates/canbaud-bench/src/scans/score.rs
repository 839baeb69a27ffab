//! What came of many trials.

use canbaud_link::sim::trial::Report;

/// Sums over trials.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Score {
    /// Trials.
    pub trials: u64,
    /// The rate was found.
    pub right: u64,
    /// Another rate was announced.
    pub wrong: u64,
    /// Errors made the scan leave the right rate.
    pub left: u64,
    /// It lasted longer than it had promised.
    pub late: u64,
    /// Dominant bits of scanners.
    pub dominant: u64,
    /// Frames that began while the scanner listened, of trials that found the rate.
    pub frames: u64,
    /// Time until the verdict in microseconds, of trials that found the rate.
    pub time: u64,
    /// The longest share of the bound that was used, in thousandths.
    pub of_bound: u64,
}

impl Score {
    /// One more trial.
    pub fn add(&mut self, report: &Report) {
        self.trials += 1;
        self.wrong += u64::from(report.wrong);
        self.left += u64::from(report.left);
        self.dominant += report.dominant;
        if let Some(bound) = report.bound {
            self.late += u64::from(report.elapsed > bound);
            self.of_bound = self.of_bound.max(report.elapsed.0 * 1000 / bound.0.max(1));
        }
        if report.right {
            self.right += 1;
            self.frames += report.heard;
            self.time += report.elapsed.0;
        }
    }

    /// Both together.
    pub fn join(&mut self, other: &Self) {
        self.trials += other.trials;
        self.right += other.right;
        self.wrong += other.wrong;
        self.left += other.left;
        self.late += other.late;
        self.dominant += other.dominant;
        self.frames += other.frames;
        self.time += other.time;
        self.of_bound = self.of_bound.max(other.of_bound);
    }

    /// Frames until the verdict on average, with two decimals.
    #[must_use]
    pub fn frames_text(&self) -> String {
        match self.right {
            0 => "-".to_owned(),
            right => {
                let hundredths = (self.frames * 100 + right / 2) / right;
                format!("{}.{:02}", hundredths / 100, hundredths % 100)
            }
        }
    }

    /// Time until the verdict on average.
    #[must_use]
    pub fn time_text(&self) -> String {
        match self.right {
            0 => "-".to_owned(),
            right => format!("{} ms", (self.time / right + 500) / 1000),
        }
    }

    /// A share of the trials in per cent, with two decimals.
    #[must_use]
    pub fn percent(&self, part: u64) -> String {
        let share = part * 10_000 / self.trials.max(1);
        format!("{}.{:02} %", share / 100, share % 100)
    }
}
