//! The bus behind a slcan adapter on a pty.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use canbaud_lab::Autonomous;
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::slcan::{Adapter, ErrorReports, Firmware, Pty, SilentMode};
use canbaud_sim::{Mode, NodeConfig, NodeId, Span, Time};

use super::Outcome;
use super::args::{
    ErrorReports as ReportsName, FirmwareName, SilentMode as SilentModeName, SimulateArgs,
};
use super::told::Told;

/// The bus runs this far at a time.
const SLICE: Span = Span::from_us(500);
/// Bytes that wait for a host that does not read.
const BACKLOG: usize = 1 << 16;

/// Serves until the end of the scenario, or until the adapter is unplugged.
pub(super) fn serve(args: &SimulateArgs, scenario: &Scenario, name: &str) -> Result<Outcome> {
    let Some((node, config)) = scenario.node(name) else {
        bail!("no node \"{name}\", there are: {}", scenario.node_names().join(", "));
    };
    if scenario.is_autonomous(node) {
        bail!("node \"{name}\" is autonomous, the adapter needs one without software");
    }
    let config = config.clone();
    let mut run = Run::with(scenario, args.seed.unwrap_or(scenario.seed), &Autonomous)?;
    let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
    run.sim_mut().reconfigure_at(Time::ZERO, node, off)?;
    run.hold_news(node);
    let adapter = build(args, node, config);
    let log = args.log.as_deref().map(open_log).transpose()?;
    let pty = Pty::open().context("cannot open a pseudo-terminal")?;
    {
        let mut out = io::stdout().lock();
        writeln!(out, "{}", pty.path().display())?;
        out.flush()?;
    }
    let told = Told::new(scenario.node_names());
    let end = args.unplug_after.map_or(run.end(), |after| run.end().min(Time::ZERO + after));
    let bytes_left = args.unplug_after_bytes.unwrap_or(u64::MAX);
    let pace = if args.fast { Pace::AsFastAsPossible } else { Pace::RealTime };
    Server { run, adapter, pty, backlog: Vec::new(), bytes_left, end, pace, log, told }.serve()?;
    Ok(Outcome::Good)
}

fn build(args: &SimulateArgs, node: NodeId, config: NodeConfig) -> Adapter {
    let firmware = match args.firmware {
        FirmwareName::Lawicel => Firmware::Lawicel,
        FirmwareName::Canable1 => Firmware::Canable1,
        FirmwareName::Canable2 => Firmware::Canable2,
        FirmwareName::Canable2Stock => Firmware::Canable2Stock,
        FirmwareName::Usbtin => Firmware::Usbtin,
    };
    let reports = match args.errors {
        Some(ReportsName::Records) => ErrorReports::Records,
        Some(ReportsName::Flags) => ErrorReports::Flags,
        Some(ReportsName::Silent) => ErrorReports::Silent,
        None => firmware.error_reports(),
    };
    let silent_mode = match args.m1 {
        SilentModeName::Honoured => SilentMode::Honoured,
        SilentModeName::Ignored => SilentMode::Ignored,
    };
    Adapter::new(node, config, firmware).with_error_reports(reports).with_silent_mode(silent_mode)
}

fn open_log(path: &Path) -> Result<Box<dyn Write>> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdout()));
    }
    let file = File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Box::new(file))
}

/// How fast the bus runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pace {
    RealTime,
    AsFastAsPossible,
}

struct Server {
    run: Run,
    adapter: Adapter,
    pty: Pty,
    backlog: Vec<u8>,
    /// Until the adapter is unplugged.
    bytes_left: u64,
    end: Time,
    pace: Pace,
    log: Option<Box<dyn Write>>,
    told: Told,
}

impl Server {
    /// The pseudo-terminal closes at the end, as if the adapter was unplugged.
    fn serve(mut self) -> Result<()> {
        let began = Instant::now();
        while self.run.sim().now() < self.end && self.bytes_left > 0 {
            let until = (self.run.sim().now() + SLICE).min(self.end);
            self.advance(until);
            self.exchange()?;
            if self.pace == Pace::AsFastAsPossible {
                continue;
            }
            let due = began + Duration::from_nanos(until.femtoseconds() / 1_000_000);
            while let Some(left) = due.checked_duration_since(Instant::now()) {
                if self.bytes_left == 0 {
                    break;
                }
                if self.pty.wait(left)? {
                    self.exchange()?;
                } else {
                    break;
                }
            }
        }
        Ok(())
    }

    fn advance(&mut self, until: Time) {
        self.run.advance(until, &mut self.told);
        for (at, _, event) in self.run.take_held_news() {
            self.adapter.notice(at, &event, self.run.sim());
        }
    }

    fn exchange(&mut self) -> Result<()> {
        let mut buffer = [0; 4096];
        loop {
            let count = self.pty.read(&mut buffer)?;
            if count == 0 {
                break;
            }
            self.adapter.command(&buffer[..count], self.run.sim_mut());
        }
        let output = self.adapter.take_output();
        if self.backlog.len() + output.len() > BACKLOG {
            self.adapter.note_overrun();
        } else {
            self.backlog.extend(output);
        }
        // Before the host knows: whoever reads the log then finds there what was answered.
        self.write_log()?;
        let most = usize::try_from(self.bytes_left).unwrap_or(usize::MAX);
        let written = self.pty.write(&self.backlog[..self.backlog.len().min(most)])?;
        self.bytes_left -= written as u64;
        self.backlog.drain(..written);
        Ok(())
    }

    /// Line by line, for whoever reads along or ends this program.
    fn write_log(&mut self) -> Result<()> {
        let (entries, told) = (self.adapter.take_log(), self.told.take());
        if let Some(log) = &mut self.log {
            for line in &told {
                writeln!(log, "{line}").context("cannot write the log")?;
            }
            for entry in &entries {
                writeln!(log, "{entry}").context("cannot write the log")?;
            }
            log.flush().context("cannot write the log")?;
        }
        Ok(())
    }
}
