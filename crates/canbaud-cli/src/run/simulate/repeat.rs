//! Many runs with seeds one after the other, on all cores: statistics.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use anyhow::{Result, anyhow};
use canbaud_lab::Autonomous;
use canbaud_sim::Blind;
use canbaud_sim::check::Checker;
use canbaud_sim::scenario::{NodeStats, Run, Scenario, Statistics};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use super::Outcome;
use super::args::SimulateArgs;
use crate::output::{bitrate, count};

/// One run of many.
struct Result1 {
    statistics: Statistics,
    misses: Vec<String>,
    violations: u64,
}

fn one(scenario: &Scenario, seed: u64, check: bool) -> Result<Result1> {
    let mut run = Run::with(scenario, seed, &Autonomous)?;
    let violations = if check {
        let mut checker = Checker::new(run.sim());
        run.finish(&mut checker);
        checker.violations()
    } else {
        run.finish(&mut Blind);
        0
    };
    let misses = run.misses().iter().map(ToString::to_string).collect();
    Ok(Result1 { statistics: run.statistics().clone(), misses, violations })
}

fn progress(args: &SimulateArgs, count: u64) -> ProgressBar {
    if args.json || args.quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(count).with_style(style)
}

pub(super) fn run(args: &SimulateArgs, scenario: &Scenario, count: u64) -> Result<Outcome> {
    let first = args.seed.unwrap_or(scenario.seed);
    let cores = thread::available_parallelism().map_or(1, usize::from) as u64;
    let jobs = args.jobs.map_or(cores, u64::from).min(count);
    let bar = progress(args, count);
    let next = AtomicU64::new(0);
    let work = || -> Result<Vec<(u64, Result1)>> {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return Ok(done);
            }
            let seed = first.wrapping_add(index);
            done.push((seed, one(scenario, seed, args.check)?));
            bar.inc(1);
        }
    };
    let parts = thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().map_err(|_| anyhow!("a run ended by itself"))?)
            .collect::<Result<Vec<_>>>()
    })?;
    bar.finish_and_clear();
    let mut runs: Vec<_> = parts.into_iter().flatten().collect();
    runs.sort_by_key(|(seed, _)| *seed);
    report(args, &runs)
}

/// Least, mean and greatest of a number.
fn spread(values: &[f64]) -> serde_json::Value {
    if values.is_empty() {
        return serde_json::Value::Null;
    }
    let min = values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    json!({ "min": min, "mean": values.iter().sum::<f64>() / values.len() as f64, "max": max })
}

/// `; found 250 kbit/s in 48 runs, nothing in 2`; nothing of a node that looks for none.
fn found_in_words(found: &serde_json::Value) -> String {
    let all = found.as_object().into_iter().flatten();
    let (none, rates): (Vec<_>, Vec<_>) = all.partition(|(rate, _)| *rate == "none");
    if rates.is_empty() {
        return String::new();
    }
    let runs = |times: &serde_json::Value| times.as_u64().unwrap_or(0);
    let rates = rates.into_iter().map(|(rate, times)| {
        let rate = bitrate(rate.parse().unwrap_or(0));
        format!("{rate} in {}", count(runs(times), "run", "runs"))
    });
    let none = none.into_iter().map(|(_, times)| format!("nothing in {}", runs(times)));
    format!("; found {}", rates.chain(none).collect::<Vec<_>>().join(", "))
}

/// `seed 7: what was missed; 2 laws broken`.
fn miss_in_words(miss: &serde_json::Value) -> String {
    let misses = miss["misses"].as_array().into_iter().flatten().filter_map(|one| one.as_str());
    let mut parts: Vec<String> = misses.map(str::to_owned).collect();
    match miss["violations"].as_u64() {
        None | Some(0) => {}
        Some(times) => {
            parts.push(format!("the law of the bus broken {}", count(times, "time", "times")));
        }
    }
    format!("seed {}: {}", miss["seed"], parts.join("; "))
}

/// How many runs left an autonomous node in which stage; null for any other node.
fn stages(all: &[&NodeStats]) -> serde_json::Value {
    let mut stages: BTreeMap<&str, u64> = BTreeMap::new();
    for stage in all.iter().filter_map(|node| node.stage.as_deref()) {
        *stages.entry(stage).or_default() += 1;
    }
    if stages.is_empty() { serde_json::Value::Null } else { json!(stages) }
}

/// `; in the end operational in 48 runs, detecting in 2`.
fn stages_in_words(stages: &serde_json::Value) -> String {
    let all = stages.as_object().into_iter().flatten();
    let all = all.map(|(stage, times)| {
        format!("{stage} in {}", count(times.as_u64().unwrap_or(0), "run", "runs"))
    });
    let words = all.collect::<Vec<_>>().join(", ");
    if words.is_empty() { words } else { format!("; in the end {words}") }
}

fn report(args: &SimulateArgs, runs: &[(u64, Result1)]) -> Result<Outcome> {
    let missed: Vec<_> = runs
        .iter()
        .filter(|(_, run)| !run.misses.is_empty() || run.violations > 0)
        .map(|(seed, run)| json!({ "seed": seed, "misses": run.misses, "violations": run.violations }))
        .collect();
    let nodes = runs.first().map_or(0, |(_, run)| run.statistics.nodes.len());
    let mut table = Vec::new();
    for place in 0..nodes {
        let all: Vec<_> = runs.iter().map(|(_, run)| &run.statistics.nodes[place]).collect();
        let numbers =
            |of: fn(&NodeStats) -> f64| -> Vec<f64> { all.iter().map(|node| of(node)).collect() };
        let mut found: BTreeMap<String, u64> = BTreeMap::new();
        for node in &all {
            let key = node.found_bitrate.map_or_else(|| "none".to_owned(), |rate| rate.to_string());
            *found.entry(key).or_default() += 1;
        }
        let times: Vec<f64> = all.iter().filter_map(|node| node.found_at_s).collect();
        table.push(json!({
            "name": all.first().map(|node| node.name.as_str()),
            "transmitted": spread(&numbers(|node| node.transmitted as f64)),
            "received": spread(&numbers(|node| node.received as f64)),
            "errors": spread(&numbers(|node| node.errors as f64)),
            "bus_off": spread(&numbers(|node| node.bus_off as f64)),
            "dominant": spread(&numbers(|node| node.dominant as f64)),
            "broken_silence": spread(&numbers(|node| node.broken_silence as f64)),
            "stage": stages(&all),
            "found_bitrate": found,
            "found_at_s": spread(&times),
        }));
    }
    let good = missed.is_empty();
    let mut out = io::stdout().lock();
    if args.json {
        let all = json!({ "runs": runs.len(), "missed": missed, "nodes": table });
        writeln!(out, "{}", serde_json::to_string_pretty(&all)?)?;
    } else {
        writeln!(out, "{} runs, {} not as expected", runs.len(), missed.len())?;
        for node in &table {
            let mean = |key: &str| node[key]["mean"].as_f64().unwrap_or(0.0);
            writeln!(
                out,
                "{}: sent {:.1}, received {:.1}, errors {:.1}, bus-off {:.2} on average{}{}",
                node["name"].as_str().unwrap_or("?"),
                mean("transmitted"),
                mean("received"),
                mean("errors"),
                mean("bus_off"),
                found_in_words(&node["found_bitrate"]),
                stages_in_words(&node["stage"])
            )?;
        }
        for miss in &missed {
            writeln!(out, "{}", miss_in_words(miss))?;
        }
    }
    Ok(if good { Outcome::Good } else { Outcome::Missed })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_is_said_in_words() {
        assert_eq!(found_in_words(&json!({ "none": 50 })), "");
        assert_eq!(
            found_in_words(&json!({ "250000": 47, "500000": 1, "none": 2 })),
            "; found 250 kbit/s in 47 runs, 500 kbit/s in 1 run, nothing in 2"
        );
        let miss = json!({ "seed": 7, "misses": ["node a: late", "b"], "violations": 1 });
        assert_eq!(
            miss_in_words(&miss),
            "seed 7: node a: late; b; the law of the bus broken 1 time"
        );
    }
}
