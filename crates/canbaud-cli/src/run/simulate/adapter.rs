//! The bus behind a slcan adapter on a pty.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::slcan::{Adapter, Dialect, ErrorReports, Pty};
use canbaud_sim::{Blind, Mode, NodeConfig, Span, Time};

use super::Outcome;
use super::args::{DialectName, ErrorReports as ReportsName, SimulateArgs};

/// The bus runs this far at a time.
const SLICE: Span = Span::from_us(500);
/// Bytes that wait for a host that does not read.
const BACKLOG: usize = 1 << 16;

/// Serves until the end of the scenario.
pub(super) fn serve(args: &SimulateArgs, scenario: &Scenario, name: &str) -> Result<Outcome> {
    let Some((node, config)) = scenario.node(name) else {
        bail!("no node \"{name}\", there are: {}", scenario.node_names().join(", "));
    };
    let config = config.clone();
    let mut run = Run::new(scenario, args.seed.unwrap_or(scenario.seed))?;
    let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
    run.sim_mut().reconfigure_at(Time::ZERO, node, off)?;
    run.hold_news(node);
    let dialect = match args.dialect {
        DialectName::Lawicel => Dialect::Lawicel,
        DialectName::Canable => Dialect::Canable,
    };
    let reports = match args.errors {
        ReportsName::Records => ErrorReports::Records,
        ReportsName::Flags => ErrorReports::Flags,
        ReportsName::Silent => ErrorReports::Silent,
    };
    let adapter = Adapter::new(node, config, dialect, reports);
    let pty = Pty::open().context("cannot open a pseudo-terminal")?;
    {
        let mut out = io::stdout().lock();
        writeln!(out, "{}", pty.path().display())?;
        out.flush()?;
    }
    Server { run, adapter, pty, backlog: Vec::new(), fast: args.fast }.serve()?;
    Ok(Outcome::Good)
}

struct Server {
    run: Run,
    adapter: Adapter,
    pty: Pty,
    backlog: Vec<u8>,
    fast: bool,
}

impl Server {
    fn serve(mut self) -> Result<()> {
        let began = Instant::now();
        let end = self.run.end();
        while self.run.sim().now() < end {
            let until = (self.run.sim().now() + SLICE).min(end);
            self.advance(until);
            self.exchange()?;
            if self.fast {
                continue;
            }
            let due = began + Duration::from_nanos(until.femtoseconds() / 1_000_000);
            while let Some(left) = due.checked_duration_since(Instant::now()) {
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
        self.run.advance(until, &mut Blind);
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
        let written = self.pty.write(&self.backlog)?;
        self.backlog.drain(..written);
        Ok(())
    }
}
