//! Scenarios: a bus, its traffic and its troubles as a TOML file.

mod autonomous;
mod build;
mod expect;
mod lss;
mod model;
mod run;
mod software;
mod stats;
mod text;
mod timeline;

use std::path::Path;

pub use build::Scenario;
pub use expect::Miss;
pub use run::{Run, RunError};
pub use stats::{NodeStats, Statistics};
pub use timeline::Timeline;

/// Why a scenario cannot be run: one line for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {what}")]
pub struct ScenarioError {
    /// The file as it was named.
    pub file: String,
    /// From 1.
    pub line: usize,
    /// What is wrong, with the allowed values.
    pub what: String,
}

impl Scenario {
    /// Reads a scenario; `name` is what errors call it. Files that it names are looked up beside
    /// `name`.
    ///
    /// ```
    /// let text = "title = 'x'\nduration = '1ms'\n[[node]]\nname = 'a'\nbitrate = '500k'\nmoed = 1\n";
    /// let error = canbaud_sim::scenario::Scenario::parse("x.toml", text).unwrap_err();
    /// assert!(error.to_string().starts_with("x.toml:6: unknown field `moed`, expected one of"));
    /// ```
    ///
    /// # Errors
    /// [`ScenarioError`] with the line.
    pub fn parse(name: &str, text: &str) -> Result<Self, ScenarioError> {
        let file: model::File = toml::from_str(text).map_err(|error| ScenarioError {
            file: name.to_owned(),
            line: error.span().map_or(1, |span| line_of(text, span.start)),
            what: error.message().replace('\n', ", "),
        })?;
        build::build(name, text, &file)
    }

    /// Reads a scenario file.
    ///
    /// # Errors
    /// [`ScenarioError`]; line 0 if the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| ScenarioError {
            file: name.clone(),
            line: 0,
            what: format!("cannot be read: {error}"),
        })?;
        Self::parse(&name, &text)
    }
}

/// The line (from 1) that byte `at` of `text` lies in.
fn line_of(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|byte| *byte == b'\n').count() + 1
}
