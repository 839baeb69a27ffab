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
use crate::printable::printable;
use crate::tell::tell;

/// How a simulation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    /// Everything as expected.
    Good,
    /// An expectation of the scenario was not met, or the law of the bus was broken.
    Missed,
    /// The channel of a bridge is the cause, and that is said.
    Channel(Exit),
}

/// Exit codes: 0 good, 2 bad scenario, 3 expectation missed, 5 a file cannot be read or written;
/// of a bridge also 6 no permission, 7 the channel cannot be used or is not as it was found, and
/// 128 + n when signal n ended it.
pub(crate) fn simulate(args: &SimulateArgs) -> Exit {
    let name = args.scenario.display().to_string();
    let text = match std::fs::read_to_string(&args.scenario) {
        Ok(text) => text,
        Err(error) => {
            tell!("canbaud: {}: cannot read: {error}", printable(&name));
            return Exit::Unreadable;
        }
    };
    let mut scenario = match Scenario::parse(&name, &text) {
        Ok(scenario) => scenario,
        Err(error) => {
            tell!("canbaud: {}", printable(&error.to_string()));
            tell!("  hint: docs/scenarios.md describes every key");
            return Exit::Usage;
        }
    };
    scenario.duration = args.duration.unwrap_or(scenario.duration);
    if let (Some(channel), false) = (&args.on, args.transmit) {
        tell!("canbaud: this transmits on {channel}: say --transmit");
        return Exit::Usage;
    }
    if let Some(node) = args.slcan.as_deref().filter(|node| scenario.node(node).is_none()) {
        let (node, nodes) = (printable(node), scenario.node_names().join(", "));
        tell!("canbaud: {}: no node \"{node}\"; there are {}", printable(&name), printable(&nodes));
        return Exit::Usage;
    }
    match dispatch(args, &scenario) {
        Ok(Outcome::Good) => Exit::Found,
        Ok(Outcome::Missed) => Exit::Undecided,
        Ok(Outcome::Channel(exit)) => exit,
        // A reader that has seen enough is no trouble.
        Err(error) if is_closed_pipe(&error) => Exit::Found,
        Err(error) => {
            tell!("canbaud: {error:#}");
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
