//! `canbaud simulate`: runs a scenario and shows what happened.

mod adapter;
mod args;
mod bridge;
mod files;
mod once;
mod repeat;
mod told;

use anyhow::Result;
use canbaud_sim::scenario::Scenario;

pub(crate) use args::SimulateArgs;

use crate::exit::Exit;

/// How a simulation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    /// Everything as expected.
    Good,
    /// An expectation of the scenario was not met, or the law of the bus was broken.
    Missed,
}

/// Exit codes: 0 good, 2 bad scenario, 3 expectation missed, 5 a file cannot be written.
pub(crate) fn simulate(args: &SimulateArgs) -> Exit {
    let mut scenario = match Scenario::read(&args.scenario) {
        Ok(scenario) => scenario,
        Err(error) => {
            eprintln!("canbaud: {error}");
            eprintln!("hint: docs/scenarios.md describes every key");
            return Exit::Usage;
        }
    };
    scenario.duration = args.duration.unwrap_or(scenario.duration);
    if let (Some(channel), false) = (&args.on, args.transmit) {
        eprintln!("canbaud: this transmits on {channel}: say --transmit");
        return Exit::Usage;
    }
    match dispatch(args, &scenario) {
        Ok(Outcome::Good) => Exit::Found,
        Ok(Outcome::Missed) => Exit::Undecided,
        // A reader that has seen enough is no trouble.
        Err(error) if is_closed_pipe(&error) => Exit::Found,
        Err(error) => {
            eprintln!("canbaud: {error:#}");
            Exit::Unreadable
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

fn dispatch(args: &SimulateArgs, scenario: &Scenario) -> Result<Outcome> {
    if let Some(node) = &args.slcan {
        adapter::serve(args, scenario, node)
    } else if let (Some(node), Some(channel)) = (&args.bridge, &args.on) {
        bridge::serve(args, scenario, node, channel)
    } else if let Some(count) = args.repeat {
        repeat::run(args, scenario, count)
    } else {
        once::run(args, scenario)
    }
}
