//! `canbaud detect`.

use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::thread;

use canbaud_capture::{CaptureError, open};

use super::failure::{source_name, unreadable, unwritable};
use super::live::{LiveSource, live};
use super::progress::{Audience, Progress};
use super::queue::in_order;
use crate::args::{DetectArgs, When};
use crate::exit::Exit;
use crate::judge;
use crate::output::{Detail, Paint, push_report, push_unreadable, render};
use crate::printable::printable;
use crate::report::ChannelReport;
use crate::tell::{self, tell};

type Judged = Result<Vec<ChannelReport>, CaptureError>;

/// Judges every source and prints what was found, in the order given.
pub(crate) fn detect(args: &DetectArgs, color: When) -> Exit {
    match args.sources.iter().find_map(|source| LiveSource::parse(source).transpose()) {
        Some(Ok(source)) => return live(args, &source, color),
        Some(Err(refusal)) => {
            tell!("error: {}", printable(&refusal));
            return Exit::Usage;
        }
        None => {}
    }
    if args.live.is_used() {
        tell!("error: an option for live buses was given with a capture file");
        return Exit::Usage;
    }
    let stdout = io::stdout();
    let audience = match args.json || args.quiet {
        false if stdout.is_terminal() && io::stderr().is_terminal() => Audience::Person,
        _ => Audience::Nobody,
    };
    let view = View::new(args, paint(color, stdout.is_terminal()));
    let progress = Progress::new(&args.sources, audience);
    let work = |index: usize| {
        let mut part = progress.source(index);
        judge_source(&args.sources[index], args, &mut |done, total| part.set(done, total))
    };
    let mut exit = Exit::Found;
    in_order(args.sources.len(), threads(args), work, |index, judged| {
        let shown = view.show(index, &source_name(&args.sources[index]), &judged);
        let written = progress.print(|| {
            tell::error(&shown.stderr);
            stdout.lock().write_all(shown.stdout.as_bytes())
        });
        exit = exit.max(shown.exit);
        match written {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                exit = exit.max(unwritable("standard output", &error));
                ControlFlow::Break(())
            }
        }
    });
    progress.finish();
    exit
}

fn judge_source(path: &Path, args: &DetectArgs, progress: &mut dyn FnMut(u64, u64)) -> Judged {
    let mut capture = open(path, &args.reading.open_options())?;
    judge::detect(&mut capture, &args.reading.judge_options(), progress)
}

fn threads(args: &DetectArgs) -> usize {
    match args.jobs {
        Some(jobs) => usize::from(jobs),
        None => thread::available_parallelism().map_or(1, std::num::NonZero::get),
    }
}

/// Colours as asked for; by itself only on a terminal without NO_COLOR [no-color.org].
pub(super) fn paint(color: When, terminal: bool) -> Paint {
    let wanted = match color {
        When::Always => true,
        When::Never => false,
        When::Auto => terminal && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
    };
    if wanted { Paint::Coloured } else { Paint::Plain }
}

/// What is printed for one source, and what it does to the exit code.
#[derive(Debug, PartialEq, Eq)]
struct Shown {
    stdout: String,
    stderr: String,
    exit: Exit,
}

/// How results are shown.
struct View<'a> {
    args: &'a DetectArgs,
    paint: Paint,
}

impl<'a> View<'a> {
    const fn new(args: &'a DetectArgs, paint: Paint) -> Self {
        Self { args, paint }
    }

    fn show(&self, index: usize, source: &str, judged: &Judged) -> Shown {
        match judged {
            Ok(channels) => Shown {
                stdout: if self.args.json {
                    self.json(source, channels)
                } else {
                    self.text(index, source, channels)
                },
                stderr: String::new(),
                exit: channels.first().map_or(Exit::NoTraffic, |bus| bus.outcome.into()),
            },
            Err(error) => {
                let mut stdout = String::new();
                if self.args.json {
                    push_unreadable(&mut stdout, source, &error.to_string());
                }
                let stderr = unreadable(source, error);
                Shown { stdout, stderr, exit: Exit::Unreadable }
            }
        }
    }

    fn json(&self, source: &str, channels: &[ChannelReport]) -> String {
        let mut lines = String::new();
        for report in channels {
            push_report(&mut lines, source, report, self.args.expected);
        }
        lines
    }

    fn text(&self, index: usize, source: &str, channels: &[ChannelReport]) -> String {
        let detail = if self.args.quiet { Detail::Brief } else { Detail::Full };
        let named = (self.args.sources.len() > 1).then_some(source);
        let text = render(named, channels, detail, self.args.expected, self.paint);
        match detail {
            // An empty line between sources.
            Detail::Full if index > 0 => format!("\n{text}"),
            Detail::Full | Detail::Brief => text,
        }
    }
}

#[cfg(test)]
mod tests;
