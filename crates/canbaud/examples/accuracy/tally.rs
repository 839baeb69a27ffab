//! Counts over all trials.

use crate::args::Args;
use crate::run::Outcome;
use crate::support::bound::Estimate;
use crate::support::judge::Judgement;
use crate::support::trial::Scene;
use std::collections::BTreeMap;

/// Upper ends of the classes of ticks per (shortest) bit.
pub(crate) const CLASSES: [f64; 8] = [1.8, 2.1, 2.6, 3.5, 6.0, 12.0, 30.0, 100.0];

/// Counts of one class.
#[derive(Debug, Clone, Default)]
pub(crate) struct Count {
    pub(crate) right: u64,
    pub(crate) wrong: u64,
    pub(crate) undecided: u64,
    pub(crate) precision: Precision,
}

/// Errors of right verdicts relative to the bound of their edges.
#[derive(Debug, Clone, Default)]
pub(crate) struct Precision {
    pub(crate) measured: u64,
    squares: f64,
    ppm_squares: f64,
    /// Errors beyond five times the bound.
    pub(crate) far: u64,
}

impl Precision {
    fn add(&mut self, error: f64, bound: Option<Estimate>) {
        let Some(bound) = bound else { return };
        let ratio = error / bound.sigma;
        self.measured += 1;
        self.squares += ratio * ratio;
        let ppm = error / bound.ticks * 1e6;
        self.ppm_squares += ppm * ppm;
        self.far += u64::from(ratio.abs() > 5.0);
    }

    fn merge(&mut self, other: &Self) {
        self.measured += other.measured;
        self.squares += other.squares;
        self.ppm_squares += other.ppm_squares;
        self.far += other.far;
    }

    /// Root mean square of error over bound; 1 is as good as can be.
    pub(crate) fn ratio(&self) -> f64 {
        (self.squares / self.measured as f64).sqrt()
    }

    /// Root mean square of the error in ppm.
    pub(crate) fn ppm(&self) -> f64 {
        (self.ppm_squares / self.measured as f64).sqrt()
    }
}

impl Count {
    pub(crate) const fn total(&self) -> u64 {
        self.right + self.wrong + self.undecided
    }

    fn merge(&mut self, other: &Self) {
        self.right += other.right;
        self.wrong += other.wrong;
        self.undecided += other.undecided;
        self.precision.merge(&other.precision);
    }
}

/// All counts.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) scenes: BTreeMap<&'static str, Count>,
    pub(crate) classes: BTreeMap<usize, Count>,
    pub(crate) needs: BTreeMap<String, u64>,
    pub(crate) data_precision: Precision,
    pub(crate) wrong: Vec<Outcome>,
    pub(crate) undecided: Vec<Outcome>,
}

impl Tally {
    /// Counts one trial; a [`Scene::Foreign`] one that was rejected counts as right.
    pub(crate) fn add(&mut self, outcome: &Outcome, args: &Args) {
        let scene = self.scenes.entry(outcome.trial.scene.name()).or_default();
        count(scene, outcome);
        if outcome.trial.scene != Scene::Foreign {
            let ticks = outcome.trial.ticks_per_bit();
            let class = CLASSES.iter().take_while(|&&end| ticks >= end).count();
            count(self.classes.entry(class).or_default(), outcome);
        }
        match outcome.judgement {
            Judgement::Right { data: Some(error), .. } => {
                self.data_precision.add(error, outcome.bound.data);
            }
            Judgement::Undecided(need) => {
                *self.needs.entry(format!("{need:?}")).or_default() += 1;
                keep(&mut self.undecided, outcome, args.show_undecided);
            }
            Judgement::Wrong(_) => keep(&mut self.wrong, outcome, args.show_wrong),
            Judgement::Right { data: None, .. } | Judgement::Rejected => {}
        }
    }

    /// Adds the counts of another thread.
    pub(crate) fn merge(&mut self, other: Self, args: &Args) {
        for (name, counts) in other.scenes {
            self.scenes.entry(name).or_default().merge(&counts);
        }
        for (class, counts) in other.classes {
            self.classes.entry(class).or_default().merge(&counts);
        }
        for (need, number) in other.needs {
            *self.needs.entry(need).or_default() += number;
        }
        self.data_precision.merge(&other.data_precision);
        // Each thread kept its first ones, so the first ones of all are among them.
        merge_kept(&mut self.wrong, other.wrong, args.show_wrong);
        merge_kept(&mut self.undecided, other.undecided, args.show_undecided);
    }

    pub(crate) fn wrong_count(&self) -> u64 {
        self.scenes.values().map(|count| count.wrong).sum()
    }
}

fn count(count: &mut Count, outcome: &Outcome) {
    match outcome.judgement {
        Judgement::Right { nominal, .. } => {
            count.right += 1;
            count.precision.add(nominal, outcome.bound.nominal);
        }
        Judgement::Rejected => count.right += 1,
        Judgement::Wrong(_) => count.wrong += 1,
        Judgement::Undecided(_) => count.undecided += 1,
    }
}

fn keep(kept: &mut Vec<Outcome>, outcome: &Outcome, most: usize) {
    if kept.len() < most {
        kept.push(outcome.clone());
    }
}

fn merge_kept(kept: &mut Vec<Outcome>, other: Vec<Outcome>, most: usize) {
    kept.extend(other);
    kept.sort_by_key(|outcome| outcome.number);
    kept.truncate(most);
}
