//! The command line.

use crate::support::judge::TOLERANCE_PPM;
use crate::support::trial::{LEAST_TICKS, Resolution, Scene};

/// What there is to say.
pub(crate) const USAGE: &str = "\
usage: accuracy [--trials N] [--seed S] [--trial N] [--scene all|NAME] [--ticks-per-bit X]
                [--threads N] [--show-wrong N] [--show-undecided N]
                [--tolerance-ppm X] [--detector pulse|least-squares|interval]
scenes: clean asymmetry jitter unacknowledged arbitration glitch glitches error-flag cut
        fd fd-asymmetry mixed foreign";

/// Who gives the verdicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Detector {
    /// `canbaud::detect::PulseDetector`.
    Pulse,
    /// Least squares that is told the bit number of every edge: checks the bound.
    LeastSquares,
    /// The middle of the bit times that the stamps allow, told the bit number of every edge: the
    /// best that can be done without asymmetry and jitter.
    Interval,
}

/// The parsed command line.
#[derive(Debug, Clone)]
pub(crate) struct Args {
    pub(crate) trials: u64,
    pub(crate) seed: u64,
    pub(crate) only: Option<u64>,
    pub(crate) scenes: Vec<Scene>,
    pub(crate) resolution: Resolution,
    pub(crate) threads: usize,
    pub(crate) tolerance_ppm: f64,
    pub(crate) show_wrong: usize,
    pub(crate) show_undecided: usize,
    pub(crate) detector: Detector,
}

impl Args {
    /// The scene of a trial; it does not depend on how many trials are run.
    pub(crate) fn scene(&self, trial: u64) -> Scene {
        self.scenes[(trial % self.scenes.len() as u64) as usize]
    }

    /// The options that, with a trial number, repeat a trial.
    pub(crate) fn repeat(&self) -> String {
        let mut options = format!("--seed {}", self.seed);
        if let [scene] = self.scenes[..] {
            options += &format!(" --scene {}", scene.name());
        }
        if let Resolution::TicksPerBit(ticks) = self.resolution {
            options += &format!(" --ticks-per-bit {ticks}");
        }
        options
    }
}

/// Parses the arguments.
pub(crate) fn parse(mut words: impl Iterator<Item = String>) -> Result<Args, String> {
    let mut args = Args {
        trials: 100_000,
        seed: 1,
        only: None,
        scenes: Scene::ALL.to_vec(),
        resolution: Resolution::UsualTimers,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        tolerance_ppm: TOLERANCE_PPM,
        show_wrong: 10,
        show_undecided: 0,
        detector: Detector::Pulse,
    };
    while let Some(option) = words.next() {
        let value = words.next().ok_or(format!("{option} needs a value"))?;
        match option.as_str() {
            "--trials" => args.trials = number(&option, &value)?,
            "--seed" => args.seed = number(&option, &value)?,
            "--trial" => args.only = Some(number(&option, &value)?),
            "--scene" => args.scenes = scenes(&value)?,
            "--ticks-per-bit" => args.resolution = resolution(&option, &value)?,
            "--threads" => args.threads = number::<usize>(&option, &value)?.max(1),
            "--tolerance-ppm" => args.tolerance_ppm = number(&option, &value)?,
            "--show-wrong" => args.show_wrong = number(&option, &value)?,
            "--show-undecided" => args.show_undecided = number(&option, &value)?,
            "--detector" => args.detector = detector(&value)?,
            _ => return Err(format!("unknown option {option}")),
        }
    }
    Ok(args)
}

fn number<T: std::str::FromStr>(option: &str, value: &str) -> Result<T, String> {
    value.parse().map_err(|_| format!("{option}: {value:?} is not a number that fits"))
}

fn resolution(option: &str, value: &str) -> Result<Resolution, String> {
    let ticks: f64 = number(option, value)?;
    if (1.0..=1e6).contains(&ticks) {
        Ok(Resolution::TicksPerBit(ticks))
    } else {
        Err(format!("{option}: {value} outside 1 to 1000000 (usual timers: from {LEAST_TICKS})"))
    }
}

fn scenes(value: &str) -> Result<Vec<Scene>, String> {
    if value == "all" {
        return Ok(Scene::ALL.to_vec());
    }
    match Scene::ALL.iter().find(|scene| scene.name() == value) {
        Some(scene) => Ok(vec![*scene]),
        None => Err(format!("--scene: no scene {value:?}")),
    }
}

fn detector(value: &str) -> Result<Detector, String> {
    match value {
        "pulse" => Ok(Detector::Pulse),
        "least-squares" => Ok(Detector::LeastSquares),
        "interval" => Ok(Detector::Interval),
        _ => Err(format!("--detector: not pulse, least-squares or interval: {value:?}")),
    }
}
