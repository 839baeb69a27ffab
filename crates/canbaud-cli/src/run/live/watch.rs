//! What is shown while a scan runs: a line that changes for a person, lines that stay for a log,
//! events for a program.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use canbaud::detect::scan::{Activity, Candidate, Capture, Scan, Standing};
use canbaud::units::Micros;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::plan::{Plan, ROOM};
use super::source::LiveSource;
use crate::args::DetectArgs;
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
    listening: Option<Candidate>,
    standing: Option<Standing>,
    refresh: Micros,
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
            listening: None,
            standing: None,
            refresh: Micros(0),
        }
    }

    pub(super) fn source(&self) -> &str {
        &self.source
    }

    /// The adapter is open, the scan begins.
    pub(super) fn start(&self, adapter: &str, plan: &Plan, remarks: &[String]) {
        match &self.viewer {
            Viewer::Program => {
                let mut lines = String::new();
                let candidates = plan.candidates.as_slice();
                live_json::push_start(&mut lines, &self.source, adapter, candidates, self.policy);
                for remark in remarks {
                    live_json::push_remark(&mut lines, remark);
                }
                emit(&lines);
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
        let standing = scan.standings().find(|one| one.candidate == candidate);
        let changed = self.listening != Some(candidate);
        if changed {
            self.listening = Some(candidate);
            self.standing = None;
            match &self.viewer {
                Viewer::Program => {
                    let mut line = String::new();
                    live_json::push_listening(&mut line, now, &candidate);
                    emit(&line);
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
            emit(&line);
            self.standing = Some(standing);
            self.refresh = now + REFRESH;
        }
        if let Viewer::Person(bar) = &self.viewer
            && (changed || now >= self.refresh)
        {
            bar.set_message(line(scan, now, &candidate, standing.as_ref(), confirming));
            bar.tick();
            self.refresh = now + REFRESH;
        }
    }

    /// Takes the changing line away.
    pub(super) fn finish(&self) {
        if let Viewer::Person(bar) = &self.viewer {
            bar.finish_and_clear();
        }
    }

    fn say(&self, text: &str) {
        match &self.viewer {
            Viewer::Person(bar) => bar.suspend(|| eprintln!("{text}")),
            _ => eprintln!("{text}"),
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(250));
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

/// Writes events at once; a program that stopped reading is told by the last one.
fn emit(lines: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(lines.as_bytes()).and_then(|()| out.flush());
}
