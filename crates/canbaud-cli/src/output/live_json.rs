//! `detect --json` on a live bus: events, one object a line, described by
//! `schemas/scan.schema.json`.

use canbaud::detect::scan::{Acknowledgement, Candidate, Capture, FdSeen, Standing};
use canbaud::units::{Bitrate, Micros};
use canbaud_link::{ErrorKind, LinkError};
use serde::Serialize;

use super::report_json::{CaveatRecord, push_line, rounded, verdict_name};
use crate::report::{LiveRate, LiveReport};

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Event<'a> {
    Start { source: &'a str, adapter: &'a str, policy: &'a str, candidates: Vec<RateRecord> },
    Remark { text: &'a str },
    Listening { t: f64, rate: RateRecord },
    Evidence { t: f64, standing: StandingRecord },
    Verdict(VerdictRecord<'a>),
    Configuration { form: &'a str, text: &'a str },
    Error { source: &'a str, kind: &'static str, text: String },
}

#[derive(Serialize)]
struct RateRecord {
    nominal: u32,
    data: Option<u32>,
    wide: bool,
}

#[derive(Serialize)]
struct StandingRecord {
    rate: RateRecord,
    refused: bool,
    visits: u32,
    listened_s: f64,
    frames: u32,
    errors: u32,
    unacknowledged: u32,
}

#[derive(Serialize)]
struct VerdictRecord<'a> {
    source: &'a str,
    adapter: &'a str,
    verdict: &'static str,
    need: Option<&'a str>,
    found: Option<FoundRecord<'a>>,
    elapsed_s: f64,
    bound_s: Option<f64>,
    visits: u32,
    tried: Vec<StandingRecord>,
    caveats: Vec<CaveatRecord<'a>>,
}

#[derive(Serialize)]
struct FoundRecord<'a> {
    nominal: u32,
    data: Option<u32>,
    known_as: Option<&'a str>,
    frames: u32,
    distinct: u8,
    errors: u32,
    acknowledged: bool,
    fd: &'static str,
}

/// The scan begins.
pub(crate) fn push_start(
    out: &mut String,
    source: &str,
    adapter: &str,
    candidates: &[Candidate],
    policy: &str,
) {
    let candidates = candidates.iter().map(rate).collect();
    push_line(out, &Event::Start { source, adapter, policy, candidates });
}

/// Something that the user should know.
pub(crate) fn push_remark(out: &mut String, text: &str) {
    push_line(out, &Event::Remark { text });
}

/// The adapter listens at another rate.
pub(crate) fn push_listening(out: &mut String, now: Micros, candidate: &Candidate) {
    push_line(out, &Event::Listening { t: seconds(now), rate: rate(candidate) });
}

/// Something was heard.
pub(crate) fn push_evidence(out: &mut String, now: Micros, one: &Standing) {
    push_line(out, &Event::Evidence { t: seconds(now), standing: standing(one) });
}

/// The scan is over.
pub(crate) fn push_verdict(out: &mut String, report: &LiveReport) {
    let caveats = report.caveats.iter();
    push_line(
        out,
        &Event::Verdict(VerdictRecord {
            source: &report.source,
            adapter: &report.adapter,
            verdict: verdict_name(report.outcome),
            need: report.need.as_deref(),
            found: report.found.as_ref().map(found),
            elapsed_s: seconds(report.elapsed),
            bound_s: report.bound.map(seconds),
            visits: report.visits,
            tried: report.tried.iter().map(standing).collect(),
            caveats: caveats.map(|c| CaveatRecord { code: c.code, text: &c.text }).collect(),
        }),
    );
}

/// What `--save` prints.
pub(crate) fn push_configuration(out: &mut String, form: &str, text: &str) {
    push_line(out, &Event::Configuration { form, text });
}

/// The adapter failed.
pub(crate) fn push_error(out: &mut String, source: &str, error: &LinkError) {
    let kind = match error.kind() {
        ErrorKind::Permission => "permission",
        ErrorKind::Unusable => "unusable",
        ErrorKind::Unreadable => "unreadable",
    };
    push_line(out, &Event::Error { source, kind, text: error.to_string() });
}

fn seconds(time: Micros) -> f64 {
    rounded(time.0 as f64 / 1e6, 6)
}

fn rate(candidate: &Candidate) -> RateRecord {
    RateRecord {
        nominal: candidate.nominal.bits_per_second(),
        data: candidate.data.map(Bitrate::bits_per_second),
        wide: candidate.capture == Capture::Wide,
    }
}

fn standing(one: &Standing) -> StandingRecord {
    StandingRecord {
        rate: rate(&one.candidate),
        refused: one.refused,
        visits: one.visits,
        listened_s: seconds(one.listened),
        frames: one.frames,
        errors: one.errors,
        unacknowledged: one.unacknowledged,
    }
}

const fn found(rate: &LiveRate) -> FoundRecord<'_> {
    FoundRecord {
        nominal: rate.nominal,
        data: rate.data,
        known_as: rate.known_as,
        frames: rate.frames,
        distinct: rate.distinct,
        errors: rate.errors,
        acknowledged: matches!(rate.acknowledgement, Acknowledgement::Presumed),
        fd: match rate.fd {
            FdSeen::No => "no",
            FdSeen::NeverSwitched => "never_switched",
            FdSeen::Switched => "switched",
            FdSeen::Suspected => "suspected",
        },
    }
}

#[cfg(test)]
mod tests;
