//! Counts over cases, and how they read in a table.

use crate::case::Draw;
use crate::judge::{Answer, Outcome};

/// A wrong answer and the case that it came of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// The case.
    pub draw: Draw,
    /// What was wrong.
    pub what: String,
}

/// Counts over the cases of one row or cell.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Cases.
    pub cases: u64,
    /// Right answers.
    pub right: u64,
    /// Answers that name the rate of the babbler alone, and those that name both.
    pub babbler: (u64, u64),
    /// No answer.
    pub undecided: u64,
    /// Wrong answers.
    pub wrong: Vec<Mistake>,
    /// Right and wrong answers of the minimum pulse method.
    pub minimum: (u64, u64),
    bits: Vec<u64>,
    attempts: Vec<u64>,
}

impl Tally {
    /// Counts what came of `draw`.
    pub fn add(&mut self, draw: &Draw, outcome: &Outcome) {
        self.cases += 1;
        match &outcome.answer {
            Answer::Right => self.right += 1,
            Answer::Babbler => self.babbler.0 += 1,
            Answer::Both => self.babbler.1 += 1,
            Answer::None => self.undecided += 1,
            Answer::Wrong(what) => self.wrong.push(Mistake { draw: *draw, what: what.clone() }),
        }
        match &outcome.minimum {
            Answer::Right => self.minimum.0 += 1,
            Answer::Wrong(_) => self.minimum.1 += 1,
            Answer::Babbler | Answer::Both | Answer::None => {}
        }
        if let Some(decision) = outcome.decided {
            self.bits.push(decision.bits);
            self.attempts.push(decision.attempts);
        }
    }

    /// Adds the counts of another.
    pub fn merge(&mut self, other: &Self) {
        self.cases += other.cases;
        self.right += other.right;
        self.babbler.0 += other.babbler.0;
        self.babbler.1 += other.babbler.1;
        self.undecided += other.undecided;
        self.wrong.extend(other.wrong.iter().cloned());
        self.minimum.0 += other.minimum.0;
        self.minimum.1 += other.minimum.1;
        self.bits.extend(&other.bits);
        self.attempts.extend(&other.attempts);
    }

    /// The columns of [`Tally::row`].
    pub const HEADING: &'static str = "cases | right | undecided | wrong | bits: median | 95 % | \
        attempts: median | 95 % | AP2925: right | wrong | none";
    /// Columns in [`Tally::HEADING`].
    pub const COLUMNS: usize = 11;

    /// One row of a table.
    #[must_use]
    pub fn row(&self) -> String {
        let none = self.cases - self.minimum.0 - self.minimum.1;
        format!(
            "{} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {}",
            self.cases,
            percent(self.right, self.cases),
            percent(self.undecided, self.cases),
            self.wrong.len(),
            quantile(&self.bits, 50),
            quantile(&self.bits, 95),
            quantile(&self.attempts, 50),
            quantile(&self.attempts, 95),
            percent(self.minimum.0, self.cases),
            percent(self.minimum.1, self.cases),
            percent(none, self.cases),
        )
    }
}

impl Tally {
    /// The columns of [`Tally::babbler_row`].
    pub const BABBLER_HEADING: &'static str = "cases | rate of the bus | of the babbler | both, as \
        a conflict | undecided | wrong | AP2925: right | wrong | none";
    /// Columns in [`Tally::BABBLER_HEADING`].
    pub const BABBLER_COLUMNS: usize = 9;

    /// One row of the table of the babbler.
    #[must_use]
    pub fn babbler_row(&self) -> String {
        let none = self.cases - self.minimum.0 - self.minimum.1;
        let shares = [self.right, self.babbler.0, self.babbler.1, self.undecided];
        let minimum = [self.minimum.0, self.minimum.1, none];
        let text = |counts: &[u64]| {
            let shares: Vec<_> = counts.iter().map(|count| percent(*count, self.cases)).collect();
            shares.join(" | ")
        };
        format!("{} | {} | {} | {}", self.cases, text(&shares), self.wrong.len(), text(&minimum))
    }
}

/// Tenths of a percent, rounded down but for what is left of 0.
fn percent(part: u64, whole: u64) -> String {
    if whole == 0 {
        return "-".into();
    }
    match part * 1_000 / whole {
        0 if part > 0 => "< 0.1 %".into(),
        permille => format!("{}.{} %", permille / 10, permille % 10),
    }
}

/// The smallest value that so many percent do not exceed.
fn quantile(values: &[u64], percent: usize) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    let rank = (sorted.len() * percent).div_ceil(100).max(1);
    sorted.get(rank - 1).map_or_else(|| "-".into(), u64::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_never_rounded_up_to_everything_or_down_to_nothing() {
        assert_eq!(percent(1_999, 2_000), "99.9 %");
        assert_eq!(percent(2_000, 2_000), "100.0 %");
        assert_eq!(percent(1, 2_000), "< 0.1 %");
        assert_eq!(percent(0, 2_000), "0.0 %");
        assert_eq!(percent(0, 0), "-");
    }

    #[test]
    fn quantiles_are_values_that_occurred() {
        let values: Vec<u64> = (1..=100).rev().collect();
        assert_eq!(quantile(&values, 50), "50");
        assert_eq!(quantile(&values, 95), "95");
        assert_eq!(quantile(&[7], 95), "7");
        assert_eq!(quantile(&[], 50), "-");
    }
}
