//! `canbaud detect` on a live bus.

mod args;
mod failure;
mod find;
mod leave;
mod plan;
mod save;
mod source;
mod stop;
mod watch;

use std::io::{self, IsTerminal};

use canbaud::detect::scan::{Candidate, Capture};
use canbaud::units::Bitrate;
use canbaud_link::{After, Clock, LinkError};

use super::failure::unwritable;
use crate::args::{DetectArgs, When};
use crate::exit::Exit;
use crate::outlet::Outlet;
use crate::output::{Detail, live_json, live_text};
use crate::report::{LiveRate, LiveReport};

pub(crate) use args::LiveArgs;
pub(super) use failure::link_error;
pub(crate) use source::LiveSource;
pub(crate) use stop::{Stop, signal};

use crate::tell::tell;
use find::{Ended, Finding};
use leave::{Left, leave};
use plan::Plan;
use watch::Watch;

/// Finds the rate of the bus at `source`.
pub(crate) fn live(args: &DetectArgs, source: &LiveSource, color: When) -> Exit {
    if let Some(refusal) = args.live.refusal(args, source) {
        tell!("error: {refusal}");
        return Exit::Usage;
    }
    let stop = match Stop::install() {
        Ok(stop) => stop,
        Err(error) => {
            tell!("canbaud: cannot take care of signals: {error}");
            return Exit::Unusable;
        }
    };
    let clock = Clock::start();
    let mut listener = match source.open(&args.live, clock) {
        Ok(listener) => listener,
        Err(error) => return fail(args, source, &error),
    };
    let plan = match Plan::new(&args.live, &listener.capabilities()) {
        Ok(plan) => plan,
        Err(refusal) => {
            tell!("error: {refusal}");
            return Exit::Usage;
        }
    };
    let mut watch = Watch::new(args, source);
    let finding = Finding { clock, stop: &stop, limit: args.live.limit() };
    let ended = finding.run(&mut *listener, &plan, &mut watch);
    watch.finish();
    // Before anything is said: who reads may be slow, or gone.
    let left = leave(&mut *listener, wanted(args, &ended));
    // What is gone cannot be put back, and that is said already.
    let gone = matches!(ended, Err(LinkError::Gone { .. })) && stop.signal().is_none();
    let exit = conclude(args, source, color, &stop, ended, &left);
    match left.lost(&source.to_string()) {
        Some((error, lost)) if !gone => {
            fail(args, source, &error);
            if let Some(hint) = left.by_hand() {
                tell!("{hint}");
            }
            lost
        }
        Some(_) | None => exit,
    }
}

/// How to leave the adapter; `None`: as it was found.
fn wanted(args: &DetectArgs, ended: &Result<Ended, LinkError>) -> Option<(Candidate, After)> {
    match ended {
        Ok(Ended::Judged(report)) if args.live.apply => Some((found(report)?, after(args, report))),
        Ok(Ended::Judged(_) | Ended::Stopped(_) | Ended::Unread) | Err(_) => None,
    }
}

/// Says what came of it.
fn conclude(
    args: &DetectArgs,
    source: &LiveSource,
    color: When,
    stop: &Stop,
    ended: Result<Ended, LinkError>,
    left: &Left,
) -> Exit {
    let stopped = |signal| {
        tell!("{}", left.stopped(&source.to_string(), signal));
        Exit::Stopped(signal)
    };
    let report = match ended {
        Ok(Ended::Judged(report)) => report,
        Ok(Ended::Stopped(signal)) => return stopped(signal),
        Ok(Ended::Unread) => return Exit::Found,
        // What a signal interrupted is its doing.
        Err(error) => {
            return stop.signal().map_or_else(|| fail(args, source, &error), stopped);
        }
    };
    let mut exit = Exit::from(report.outcome);
    if let Err(error) = write(args, &report, color) {
        if let (io::ErrorKind::Interrupted, Some(signal)) = (error.kind(), stop.signal()) {
            return stopped(signal);
        }
        exit = exit.max(unwritable("standard output", &error));
    }
    if let Some((candidate, after)) = &left.kept {
        let mode = match after {
            After::Listening => "listening only",
            After::Normal => "taking part in the traffic",
        };
        tell!("{source} is up at {}bit/s, {mode}", candidate.nominal);
    }
    match &left.not_kept {
        Some(error) => exit.max(fail(args, source, error)),
        None => exit,
    }
}

/// How to leave it. A node whose rate is known to some percent only would destroy frames, and so
/// would one that does not know the data bit rate.
fn after(args: &DetectArgs, report: &LiveReport) -> After {
    let lacks_data_rate = report.found.as_ref().is_some_and(LiveRate::lacks_data_rate);
    if lacks_data_rate || report.caveats.iter().any(|caveat| caveat.code == "roughly") {
        After::Listening
    } else {
        args.live.after()
    }
}

/// The rate that was found.
fn found(report: &LiveReport) -> Option<Candidate> {
    let found = report.found.as_ref()?;
    let data = found.data.and_then(Bitrate::new);
    Some(Candidate { nominal: Bitrate::new(found.nominal)?, data, capture: Capture::Usual })
}

fn write(args: &DetectArgs, report: &LiveReport, color: When) -> io::Result<()> {
    let paint = super::detect::paint(color, io::stdout().is_terminal());
    let detail = if args.quiet { Detail::Brief } else { Detail::Full };
    let mut text = String::new();
    if args.json {
        live_json::push_verdict(&mut text, report);
    } else {
        text = live_text::render(report, detail, paint);
    }
    if let (Some(form), Some(found)) = (args.live.save, &report.found) {
        if !args.json {
            text.push('\n');
        }
        let configuration = save::configuration(form, &report.source, found, after(args, report));
        if args.json {
            live_json::push_configuration(&mut text, form.name(), &configuration);
        } else {
            text.push_str(&configuration);
        }
    }
    Outlet::Output.write(&text, None)
}

fn fail(args: &DetectArgs, source: &LiveSource, error: &LinkError) -> Exit {
    if args.json {
        let mut line = String::new();
        live_json::push_error(&mut line, &source.to_string(), error);
        // Whoever reads is told on the standard error, too.
        let _ = Outlet::Output.write(&line, None);
    }
    link_error(error)
}

#[cfg(test)]
mod tests {
    use canbaud::detect::scan::FdSeen;
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};
    use crate::report::{Caveat, samples};

    /// A classic node would destroy every CAN FD frame, one at a rough rate any frame.
    #[test]
    fn nothing_takes_part_that_would_destroy_frames() {
        let line = ["canbaud", "detect", "can0", "--apply", "--normal"];
        let Command::Detect(args) = Cli::try_parse_from(line).unwrap().command else { panic!() };
        let mut report = samples::live();
        assert_eq!(after(&args, &report), After::Normal);
        for fd in [FdSeen::Switched, FdSeen::NeverSwitched, FdSeen::Suspected] {
            let rate = report.found.as_mut().unwrap();
            (rate.fd, rate.data) = (fd, None);
            assert_eq!(after(&args, &report), After::Listening, "{fd:?}");
        }
        let rate = report.found.as_mut().unwrap();
        (rate.fd, rate.data) = (FdSeen::Switched, Some(2_000_000));
        assert_eq!(after(&args, &report), After::Normal);
        report.caveats.push(Caveat { code: "roughly", text: String::new() });
        assert_eq!(after(&args, &report), After::Listening);
    }
}
