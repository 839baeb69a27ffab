//! What came out, as text.

use crate::args::Args;
use crate::run::Outcome;
use crate::support::bound::Estimate;
use crate::support::judge::{Truth, ticks};
use crate::tally::{CLASSES, Count, Tally};
use canbaud::detect::Verdict;
use std::fmt::Write;

/// Appends formatted text; a `String` takes all of it.
macro_rules! part {
    ($out:expr, $($text:tt)*) => { write!($out, $($text)*).expect("a String takes all text") };
}

/// Appends a formatted line.
macro_rules! line {
    ($out:expr, $($text:tt)*) => { writeln!($out, $($text)*).expect("a String takes all text") };
}

/// All about one trial.
pub(crate) fn one(args: &Args, outcome: &Outcome) -> String {
    let mut out = String::new();
    describe_outcome(&mut out, args, outcome);
    let recording = &outcome.recording;
    line!(out, "  begin {} {:?}", recording.begin, recording.initial);
    let edges: Vec<String> =
        recording.edges.iter().map(|edge| (edge.at - recording.begin).to_string()).collect();
    line!(out, "  edges (ticks after begin): {}", edges.join(" "));
    line!(out, "  finish {}", recording.finish - recording.begin);
    out
}

/// The tables.
pub(crate) fn table(args: &Args, tally: &Tally) -> String {
    let mut out = String::new();
    line!(out, "{} trials, {}", args.trials, args.repeat());
    line!(
        out,
        "right: bit time within {} ppm; rms/bound: error over least-squares bound",
        args.tolerance_ppm
    );
    heading(&mut out, "scene");
    for (scene, count) in &tally.scenes {
        row(&mut out, scene, count);
    }
    heading(&mut out, "ticks per bit");
    for (&class, count) in &tally.classes {
        row(&mut out, &class_name(class), count);
    }
    let data = &tally.data_precision;
    if data.measured > 0 {
        line!(
            out,
            "data bit time: {} measured, rms/bound {:.3}, rms {:.1} ppm, {} beyond 5 sigma",
            data.measured,
            data.ratio(),
            data.ppm(),
            data.far
        );
    }
    for (need, number) in &tally.needs {
        line!(out, "undecided, needs {need}: {number}");
    }
    for outcome in tally.undecided.iter().take(args.show_undecided) {
        describe_outcome(&mut out, args, outcome);
    }
    line!(out, "wrong verdicts: {}, shown {}", tally.wrong_count(), tally.wrong.len());
    for outcome in &tally.wrong {
        describe_outcome(&mut out, args, outcome);
    }
    out
}

fn heading(out: &mut String, first: &str) {
    line!(
        out,
        "\n{first:<16}{:>10}{:>10}{:>7}{:>10}{:>10}{:>10}{:>10}{:>9}",
        "trials",
        "right",
        "wrong",
        "undecided",
        "right %",
        "rms/bound",
        "rms ppm",
        "> 5 sd"
    );
}

fn row(out: &mut String, name: &str, count: &Count) {
    let percent = 100.0 * count.right as f64 / count.total() as f64;
    part!(
        out,
        "{name:<16}{:>10}{:>10}{:>7}{:>10}{percent:>10.3}",
        count.total(),
        count.right,
        count.wrong,
        count.undecided
    );
    let precision = &count.precision;
    if precision.measured > 0 {
        part!(out, "{:>10.3}{:>10.1}{:>9}", precision.ratio(), precision.ppm(), precision.far);
    }
    out.push('\n');
}

fn class_name(class: usize) -> String {
    match (class.checked_sub(1).and_then(|below| CLASSES.get(below)), CLASSES.get(class)) {
        (Some(from), Some(to)) => format!("{from} to {to}"),
        (Some(from), None) => format!("{from} and more"),
        (None, Some(to)) => format!("below {to}"),
        (None, None) => String::new(),
    }
}

fn describe_outcome(out: &mut String, args: &Args, outcome: &Outcome) {
    line!(out, "\n{:?}", outcome.judgement);
    line!(out, "  repeat: {} --trial {}", args.repeat(), outcome.number);
    line!(out, "  truth: {:?}", outcome.trial.truth());
    line!(out, "  verdict: {}", describe(&outcome.verdict, &outcome.trial.truth()));
    line!(out, "  best nominal: {}", best(outcome.bound.nominal));
    line!(out, "  best data: {}", best(outcome.bound.data));
    line!(out, "  ticks per bit: {:.4}", outcome.trial.ticks_per_bit());
    line!(out, "  {:?}", outcome.trial);
}

fn describe(verdict: &Verdict, truth: &Truth) -> String {
    match (verdict, truth) {
        (Verdict::Found(found), Truth::Bus { nominal, .. }) => {
            let measured = ticks(found.nominal);
            format!("{measured:.5} ticks, {:.5} of the truth; {found:?}", measured / nominal)
        }
        _ => format!("{verdict:?}"),
    }
}

fn best(estimate: Option<Estimate>) -> String {
    match estimate {
        Some(best) => format!("{:.5} ticks, standard deviation {:.5}", best.ticks, best.sigma),
        None => "not determined by the edges".into(),
    }
}
