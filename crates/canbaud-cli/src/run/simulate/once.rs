//! One run: timeline, files, statistics.

use std::io::{self, BufWriter, IsTerminal, Write};

use anyhow::Result;
use canbaud_lab::Autonomous;
use canbaud_sim::check::Checker;
use canbaud_sim::scenario::{Run, Scenario, Timeline};
use canbaud_sim::write::Recorder;
use canbaud_sim::{Blind, Observer};

use super::args::SimulateArgs;
use super::{Outcome, files};
use crate::tell::tell;

pub(super) fn run(args: &SimulateArgs, scenario: &Scenario) -> Result<Outcome> {
    let seed = args.seed.unwrap_or(scenario.seed);
    let mut run = Run::with(scenario, seed, &Autonomous)?;
    let mut recorder = Recorder::default();
    let records = files::any(args);
    let violations = if args.check {
        let mut checker = Checker::new(run.sim());
        observe(args, scenario, &mut run, &mut checker, &mut recorder, records)?;
        for violation in checker.first() {
            tell!("law broken: {violation}");
        }
        checker.violations()
    } else {
        observe(args, scenario, &mut run, &mut Blind, &mut recorder, records)?;
        0
    };
    files::write(args, scenario, &recorder, run.end())?;
    let misses = run.misses();
    if args.json {
        let statistics = serde_json::to_string_pretty(run.statistics())?;
        writeln!(io::stdout().lock(), "{statistics}")?;
    } else {
        summary(&run, seed)?;
    }
    for miss in &misses {
        tell!("expectation missed: {}: {miss}", args.scenario.display());
    }
    let good = misses.is_empty() && violations == 0;
    Ok(if good { Outcome::Good } else { Outcome::Missed })
}

/// Runs to the end with the observers that were asked for, and no others.
fn observe<C: Observer>(
    args: &SimulateArgs,
    scenario: &Scenario,
    run: &mut Run,
    checker: &mut C,
    recorder: &mut Recorder,
    records: bool,
) -> Result<()> {
    let prints = !args.quiet && !args.json;
    if prints {
        let out = BufWriter::new(io::stdout().lock());
        let mut timeline = Timeline::new(out, scenario.node_names());
        run.finish(&mut (checker, (&mut *recorder, &mut timeline)));
        timeline.finish()?;
    } else if records {
        run.finish(&mut (checker, recorder));
    } else {
        run.finish(checker);
    }
    Ok(())
}

fn summary(run: &Run, seed: u64) -> Result<()> {
    let statistics = run.statistics();
    let mut out = io::stdout().lock();
    if io::stdout().is_terminal() {
        writeln!(out)?;
    }
    let width = statistics.nodes.iter().map(|node| node.name.len()).max().unwrap_or(0).max(4);
    writeln!(
        out,
        "{:width$}  {:>8}  {:>8}  {:>6}  {:>7}  {:>7}  state",
        "node", "sent", "received", "errors", "TEC max", "REC max"
    )?;
    for node in &statistics.nodes {
        let at = node.found_at_s.unwrap_or(0.0);
        let found = match (&node.stage, node.found_bitrate) {
            (Some(stage), Some(rate)) => format!(", {stage}, at {rate} bit/s since {at:.6} s"),
            (Some(stage), None) => format!(", {stage}"),
            (None, Some(rate)) => format!(", found {rate} bit/s after {at:.6} s"),
            (None, None) => String::new(),
        };
        writeln!(
            out,
            "{:width$}  {:>8}  {:>8}  {:>6}  {:>7}  {:>7}  {}{found}",
            node.name,
            node.transmitted,
            node.received,
            node.errors,
            node.tec_max,
            node.rec_max,
            node.state
        )?;
    }
    writeln!(
        out,
        "{:.6} s, seed {seed}, {} edges, {:.1} % dominant",
        statistics.duration_s,
        statistics.edges,
        100.0 * statistics.dominant_share
    )?;
    Ok(())
}
