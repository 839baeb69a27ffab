//! What is shown while a scan runs: a line that changes for a person, lines that stay for a log,
//! events for a program.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use canbaud::detect::scan::{Activity, Candidate, Capture, Scan, Standing};
use canbaud::units::Micros;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::plan::{Plan, ROOM};
use super::source::LiveSource;
use crate::args::DetectArgs;
use crate::outlet::Outlet;
use crate::output::{bitrate, count, live_json};

/// A person's line changes, and evidence is told, this often at most.
const REFRESH: Micros = Micros::from_ms(100);

/// Who looks.
#[derive(Debug)]
enum Viewer {
    /// Somebody at a terminal.
    Person(ProgressBar),
    /// Somebody who reads the standard error later.
    Log,
    /// A program.
    Program,
    Nobody,
}

/// Shows a scan.
#[derive(Debug)]
pub(super) struct Watch {
    viewer: Viewer,
    source: String,
    policy: &'static str,
    visit: Option<Visit>,
    standing: Option<Standing>,
    refresh: Micros,
    /// Whether events still have somebody to go to, or the interface is to be set all the same.
    reader: Reader,
    /// The end of the time that was given: longer nobody is waited for.
    until: Option<Instant>,
}

/// The rate that is listened at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Visit {
    candidate: Candidate,
    number: u32,
    since: Micros,
}

impl Visit {
    /// `standing` with the time of the visit that is under way, which the scan adds at its end.
    fn added_to(self, standing: Standing, now: Micros) -> Standing {
        if standing.candidate != self.candidate {
            return standing;
        }
        Standing { listened: standing.listened + (now - self.since), ..standing }
    }
}

/// Who reads the events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reader {
    There,
    Gone,
    /// The scan is wanted for what it sets.
    Needless,
}

impl Watch {
    pub(super) fn new(args: &DetectArgs, source: &LiveSource) -> Self {
        let viewer = if args.json {
            Viewer::Program
        } else if args.quiet {
            Viewer::Nobody
        } else if io::stderr().is_terminal() {
            Viewer::Person(bar())
        } else {
            Viewer::Log
        };
        Self {
            viewer,
            source: source.to_string(),
            policy: args.live.policy.name(),
            visit: None,
            standing: None,
            refresh: Micros(0),
            // No end that can be told is none.
            until: args
                .live
                .limit()
                .and_then(|limit| Instant::now().checked_add(Duration::from_micros(limit.0))),
            reader: if args.live.apply { Reader::Needless } else { Reader::There },
        }
    }

    /// `standing` of a scan that was broken off at `now`.
    pub(super) fn at_the_end(&self, standing: Standing, now: Micros) -> Standing {
        self.visit.map_or(standing, |visit| visit.added_to(standing, now))
    }

    /// Whether whoever read the events has gone away: the scan is for nobody.
    pub(super) fn is_unread(&self) -> bool {
        self.reader == Reader::Gone
    }

    pub(super) fn source(&self) -> &str {
        &self.source
    }

    /// The adapter is open, the scan begins.
    pub(super) fn start(&mut self, adapter: &str, plan: &Plan, remarks: &[String]) {
        match &self.viewer {
            Viewer::Program => {
                let mut lines = String::new();
                let candidates = plan.candidates.as_slice();
                live_json::push_start(&mut lines, &self.source, adapter, candidates, self.policy);
                for remark in remarks {
                    live_json::push_remark(&mut lines, remark);
                }
                self.emit(&lines);
            }
            Viewer::Person(_) | Viewer::Log => {
                for remark in remarks {
                    self.say(&format!("note: {remark}"));
                }
            }
            Viewer::Nobody => {}
        }
    }

    /// Looks at the scan.
    pub(super) fn look(&mut self, scan: &Scan<ROOM>, now: Micros) {
        let (candidate, confirming) = match scan.status(now).activity {
            Activity::Listening(candidate) => (candidate, false),
            Activity::Confirming(candidate) => (candidate, true),
            Activity::Waiting | Activity::Switching(_) | Activity::Done => return,
        };
        let number = scan.status(now).visits;
        let same = |visit: &Visit| (visit.candidate, visit.number) == (candidate, number);
        let visit = self.visit.filter(same).unwrap_or(Visit { candidate, number, since: now });
        let standing = scan.standings().find(|one| one.candidate == candidate);
        let standing = standing.map(|standing| visit.added_to(standing, now));
        let changed = self.visit.is_none_or(|last| last.candidate != candidate);
        self.visit = Some(visit);
        if changed {
            self.standing = None;
            match &self.viewer {
                Viewer::Program => {
                    let mut line = String::new();
                    live_json::push_listening(&mut line, now, &candidate);
                    self.emit(&line);
                }
                Viewer::Log => self.say(&format!("{now}  listening at {}", name(&candidate))),
                Viewer::Person(_) | Viewer::Nobody => {}
            }
        }
        if let (Viewer::Program, Some(standing)) = (&self.viewer, standing)
            && (changed || now >= self.refresh)
            && evidence(&standing) != self.standing.as_ref().map_or([0; 3], evidence)
        {
            let mut line = String::new();
            live_json::push_evidence(&mut line, now, &standing);
            self.emit(&line);
            self.standing = Some(standing);
            self.refresh = now + REFRESH;
        }
        if let Viewer::Person(bar) = &self.viewer
            && (changed || now >= self.refresh)
            && Outlet::Errors.is_read()
        {
            bar.set_message(line(scan, now, &candidate, standing.as_ref(), confirming));
            bar.tick();
            self.refresh = now + REFRESH;
        }
    }

    /// Takes the changing line away.
    pub(super) fn finish(&self) {
        if let Viewer::Person(bar) = &self.viewer {
            // Who has stopped the terminal is not waited for.
            if !Outlet::Errors.is_read() {
                bar.set_draw_target(ProgressDrawTarget::hidden());
            }
            bar.finish_and_clear();
        }
    }

    /// Writes events at once; they are lost where the scan must not wait for its reader any more.
    fn emit(&mut self, lines: &str) {
        let lost = match Outlet::Output.write(lines, self.until) {
            Ok(()) => false,
            Err(error) => !is_impatience(&error),
        };
        if lost && self.reader == Reader::There {
            self.reader = Reader::Gone;
        }
    }

    fn say(&self, text: &str) {
        // Who closed the other end wants no log.
        let say = || drop(Outlet::Errors.write(&format!("{text}\n"), self.until));
        match &self.viewer {
            Viewer::Person(bar) if Outlet::Errors.is_read() => bar.suspend(say),
            Viewer::Person(_) => {}
            _ => say(),
        }
    }
}

/// Whether there is a reader, who could not be waited for.
fn is_impatience(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::Interrupted | io::ErrorKind::TimedOut)
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// What makes an event.
const fn evidence(standing: &Standing) -> [u32; 3] {
    [standing.frames, standing.errors, standing.unacknowledged]
}

/// `listening at 250 kbit/s   1 frame, 0 errors   rate 3   at most 12.3 s left`.
fn line(
    scan: &Scan<ROOM>,
    now: Micros,
    candidate: &Candidate,
    standing: Option<&Standing>,
    confirming: bool,
) -> String {
    let status = scan.status(now);
    let what = if confirming { "confirming" } else { "listening at" };
    let (frames, errors) = standing.map_or((0, 0), |one| (one.frames, one.errors));
    let left = match status.left {
        Some(left) => format!("at most {}.{} s left", left.ms() / 1000, left.ms() / 100 % 10),
        None => format!("{} s", status.elapsed.ms() / 1000),
    };
    format!(
        "{what} {}   {}, {}   {}   {left}",
        name(candidate),
        count(frames.into(), "frame", "frames"),
        count(errors.into(), "error", "errors"),
        count(status.visits.into(), "try", "tries"),
    )
}

/// `500 kbit/s, data 2 Mbit/s`.
pub(super) fn name(candidate: &Candidate) -> String {
    let nominal = bitrate(candidate.nominal.bits_per_second());
    let wide = if candidate.capture == Capture::Wide { "about " } else { "" };
    match candidate.data {
        Some(data) => format!("{wide}{nominal}, data {}", bitrate(data.bits_per_second())),
        None => format!("{wide}{nominal}"),
    }
}
