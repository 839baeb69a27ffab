//! A virtual slcan adapter: `canbaud simulate --slcan`, in a process of its own.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::command;

/// Looks at the log for so long, until it fails.
const LOOKS: u32 = 1500;
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// An adapter on a bus of its own; both end with it.
pub(crate) struct Adapter {
    pub(crate) process: Child,
    /// What the command calls it.
    pub(crate) channel: String,
    /// Where the scenario lies, as `bus.toml`.
    pub(crate) directory: tempfile::TempDir,
    log: PathBuf,
}

impl Adapter {
    /// Offers `node` of the scenario.
    pub(crate) fn start(scenario: &str, node: &str) -> Self {
        Self::start_as(scenario, node, &[])
    }

    /// With more options.
    pub(crate) fn start_as(scenario: &str, node: &str, options: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let log = directory.path().join("adapter.log");
        std::fs::write(directory.path().join("bus.toml"), scenario).unwrap();
        let mut process = command(&["simulate", "bus.toml", "-q", "--slcan", node])
            .args(["--log", "adapter.log"])
            .args(options)
            .current_dir(&directory)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut path = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
        Self { process, channel: format!("slcan:{}", path.trim()), directory, log }
    }

    /// What it was told and did so far, without the times.
    pub(crate) fn log(&self) -> Vec<String> {
        let text = std::fs::read_to_string(&self.log).unwrap();
        // The last line may be half written.
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.log().last().is_some_and(|line| line == "C: closed")
    }

    /// Waits for a line that ends like this.
    #[track_caller]
    pub(crate) fn wait_for(&self, what: &str) {
        for _ in 0..LOOKS {
            if self.log().iter().any(|line| line.ends_with(what)) {
                return;
            }
            std::thread::sleep(BETWEEN_LOOKS);
        }
        panic!("no {what}: {:#?}", self.log());
    }

    /// Between two rates of a scan it is closed for a moment only.
    #[track_caller]
    pub(crate) fn wait_until_it_stays_closed(&self) {
        let mut closed = 0;
        for _ in 0..LOOKS {
            closed = if self.is_closed() { closed + 1 } else { 0 };
            if closed == 50 {
                return;
            }
            std::thread::sleep(BETWEEN_LOOKS);
        }
        panic!("it stays open: {:#?}", self.log());
    }

    #[track_caller]
    pub(crate) fn assert_closed(&self) {
        assert!(self.is_closed(), "{:#?}", self.log());
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Sends a signal by its name.
pub(crate) fn signal(name: &str, process: &Child) {
    let pid = process.id().to_string();
    assert!(Command::new("kill").args(["-s", name, &pid]).status().unwrap().success());
}
