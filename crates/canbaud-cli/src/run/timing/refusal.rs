//! Why there is no answer: one line, a hint, and the exit code.

use canbaud::timing::physics_fit::BusError;
use canbaud::timing::{Rate, SolveError, fd::PhasesError};

use crate::exit::Exit;
use crate::tell::tell;

/// A refusal on its way to the user.
#[derive(Debug)]
pub(super) struct Refusal {
    pub(super) exit: Exit,
    pub(super) line: String,
    pub(super) hint: Option<String>,
    /// The nearest reachable bit rate in bit/s.
    pub(super) nearest: Option<f64>,
}

impl Refusal {
    /// The command line is wrong.
    pub(super) fn usage(line: impl Into<String>, hint: Option<String>) -> Self {
        Self { exit: Exit::Usage, line: line.into(), hint, nearest: None }
    }

    /// The request cannot be met.
    pub(super) fn impossible(line: impl Into<String>, nearest: Option<Rate>) -> Self {
        let nearest = nearest.map(|rate| rate.millibits_per_second() as f64 / 1e3);
        Self { exit: Exit::Impossible, line: line.into(), hint: None, nearest }
    }

    /// With a hint.
    pub(super) fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The same for programs.
    pub(super) fn json(&self) -> Result<String, Self> {
        super::json::line(&super::json::ErrorRecord {
            kind: "error",
            message: &self.line,
            hint: self.hint.as_deref(),
            nearest_bitrate: self.nearest,
        })
    }

    /// Tells the user, as JSON too if that is what is read.
    pub(super) fn tell(&self, json: bool) -> Exit {
        tell!("canbaud: {}", self.line);
        if let Some(hint) = &self.hint {
            tell!("  hint: {hint}");
        }
        if json && let Ok(line) = self.json() {
            super::text::print(&line);
        }
        self.exit
    }
}

impl From<SolveError> for Refusal {
    fn from(error: SolveError) -> Self {
        let refusal = Self::impossible(error.to_string(), error.nearest());
        match error {
            SolveError::TooFast { nearest, .. } if nearest.clock() < 1_000_000 => {
                let clock = nearest.clock();
                refusal
                    .with_hint(format!("the clock is {clock} Hz; {clock} MHz is written {clock}M"))
            }
            SolveError::NotClose { .. } => {
                refusal.with_hint("--tolerance PPM accepts a larger bit rate error")
            }
            _ => refusal,
        }
    }
}

impl From<PhasesError> for Refusal {
    fn from(error: PhasesError) -> Self {
        match error {
            PhasesError::Phase(phase, inner) => {
                let refusal = Self::from(inner);
                Self { line: format!("{phase} phase: {}", refusal.line), ..refusal }
            }
            PhasesError::NoPhase(_) | PhasesError::DataSlower(_) | PhasesError::Clocks => {
                Self::usage(error.to_string(), None)
            }
            _ => Self::impossible(error.to_string(), None),
        }
    }
}

impl From<BusError> for Refusal {
    fn from(error: BusError) -> Self {
        match error {
            BusError::Solve(inner) => inner.into(),
            _ => Self::impossible(error.to_string(), None),
        }
    }
}
