//! `canbaud detect` on a live bus.

mod args;
mod failure;
mod find;
mod plan;
mod save;
mod source;
mod stop;
mod watch;

use std::io::{self, IsTerminal, Write};

use canbaud::detect::scan::{Candidate, Capture};
use canbaud::units::Bitrate;
use canbaud_link::{After, Clock, LinkError, Listener};

use super::failure::unwritable;
use crate::args::{DetectArgs, When};
use crate::exit::Exit;
use crate::output::{Detail, live_json, live_text};
use crate::report::LiveReport;

pub(crate) use args::LiveArgs;
pub(super) use failure::link_error;
pub(crate) use source::LiveSource;
pub(crate) use stop::Stop;

use find::{Ended, Finding};
use plan::Plan;
use watch::Watch;

/// Finds the rate of the bus at `source`.
pub(crate) fn live(args: &DetectArgs, source: &LiveSource, color: When) -> Exit {
    if let Some(refusal) = args.live.refusal(args, source) {
        eprintln!("error: {refusal}");
        return Exit::Usage;
    }
    let stop = match Stop::install() {
        Ok(stop) => stop,
        Err(error) => {
            eprintln!("canbaud: cannot take care of signals: {error}");
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
            eprintln!("error: {refusal}");
            return Exit::Usage;
        }
    };
    let mut watch = Watch::new(args, source);
    let finding = Finding { clock, stop: &stop, limit: args.live.limit() };
    let ended = finding.run(&mut *listener, &plan, &mut watch);
    watch.finish();
    // What is gone cannot be put back, and that was said already.
    let gone = matches!(ended, Err(LinkError::Gone { .. }));
    let exit = conclude(args, source, color, &mut *listener, &stop, ended);
    match listener.restore() {
        Err(error) if !gone => exit.max(fail(args, source, &error)),
        Ok(()) | Err(_) => exit,
    }
}

/// Says what came of it, and leaves the interface as asked for.
fn conclude(
    args: &DetectArgs,
    source: &LiveSource,
    color: When,
    listener: &mut dyn Listener,
    stop: &Stop,
    ended: Result<Ended, LinkError>,
) -> Exit {
    let report = match ended {
        Ok(Ended::Judged(report)) => report,
        Ok(Ended::Stopped(signal)) => {
            eprintln!("canbaud: {source}: stopped by a signal, put back as it was found");
            return Exit::Stopped(signal);
        }
        // What a signal interrupted is its doing.
        Err(error) => match stop.signal() {
            Some(signal) => return Exit::Stopped(signal),
            None => return fail(args, source, &error),
        },
    };
    let exit = Exit::from(report.outcome);
    match write(args, &report, color) {
        Ok(()) => {}
        Err(error) => return exit.max(unwritable("standard output", &error)),
    }
    match (kept(&report), args.live.apply) {
        (Some(candidate), true) => match listener.keep(&candidate, after(args, &report)) {
            Ok(()) => {
                let mode = match after(args, &report) {
                    After::Listening => "listening only",
                    After::Normal => "taking part in the traffic",
                };
                eprintln!("{source} is up at {}bit/s, {mode}", candidate.nominal);
                exit
            }
            Err(error) => fail(args, source, &error),
        },
        _ => exit,
    }
}

/// How to leave it. A node whose rate is known to some percent only would destroy frames.
fn after(args: &DetectArgs, report: &LiveReport) -> After {
    if report.caveats.iter().any(|caveat| caveat.code == "roughly") {
        After::Listening
    } else {
        args.live.after()
    }
}

/// What to leave set.
fn kept(report: &LiveReport) -> Option<Candidate> {
    let found = report.found.as_ref()?;
    let data = found.data.and_then(Bitrate::new);
    Some(Candidate { nominal: Bitrate::new(found.nominal)?, data, capture: Capture::Usual })
}

fn write(args: &DetectArgs, report: &LiveReport, color: When) -> io::Result<()> {
    let stdout = io::stdout();
    let paint = super::detect::paint(color, stdout.is_terminal());
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
    stdout.lock().write_all(text.as_bytes())
}

fn fail(args: &DetectArgs, source: &LiveSource, error: &LinkError) -> Exit {
    if args.json {
        let mut line = String::new();
        live_json::push_error(&mut line, &source.to_string(), error);
        // Whoever reads is told on the standard error, too.
        let _ = io::stdout().lock().write_all(line.as_bytes());
    }
    link_error(error)
}
