//! `detect --json`: one object a line, described by `schemas/detect.schema.json`.

use canbaud::units::Bitrate;
use serde::Serialize;

use super::number::deviation_ppm;
use crate::report::{ChannelReport, FrameCounts, Outcome, Rate};

#[derive(Serialize)]
struct Judged<'a> {
    source: &'a str,
    channel: &'a str,
    inverted: bool,
    verdict: &'static str,
    nominal: Option<RateRecord<'a>>,
    data: Option<RateRecord<'a>>,
    /// The second rate of a conflict.
    other: Option<RateRecord<'a>>,
    /// What is missing for a verdict.
    need: Option<&'a str>,
    proven_frames: u64,
    frames: FramesRecord,
    error_probability: f64,
    bus_load: f64,
    asymmetry_ns: Option<f64>,
    clock_spread_ppm: Option<f64>,
    samples_per_bit: Option<f64>,
    duration_s: f64,
    edges: u64,
    /// Only with `--expected`.
    #[serde(skip_serializing_if = "Option::is_none")]
    expected: Option<ExpectedRecord>,
    caveats: Vec<CaveatRecord<'a>>,
}

#[derive(Serialize)]
struct RateRecord<'a> {
    bitrate: u32,
    measured: f64,
    uncertainty_ppm: f64,
    known_as: Option<&'a str>,
}

#[derive(Serialize)]
struct FramesRecord {
    classic: u64,
    fd: u64,
    remote: u64,
    error: u64,
    truncated: u64,
    overload: u64,
    fd_brs: u64,
    fd_non_iso: u64,
    extended: u64,
    unacknowledged: u64,
}

#[derive(Serialize)]
struct ExpectedRecord {
    bitrate: u32,
    deviation_ppm: Option<f64>,
}

#[derive(Serialize)]
pub(super) struct CaveatRecord<'a> {
    pub(super) code: &'a str,
    pub(super) text: &'a str,
}

#[derive(Serialize)]
struct Unreadable<'a> {
    source: &'a str,
    error: &'a str,
}

/// `value` with so many decimals: more would be digits of the arithmetic, not of the bus.
pub(super) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    // Adding 0 turns -0 into 0.
    (value * scale).round() / scale + 0.0
}

/// Appends the object of one judged channel and a line end.
pub(crate) fn push_report(
    out: &mut String,
    source: &str,
    report: &ChannelReport,
    expected: Option<Bitrate>,
) {
    push_line(out, &judged(source, report, expected));
}

/// Appends the object that stands for a source that cannot be read.
pub(crate) fn push_unreadable(out: &mut String, source: &str, error: &str) {
    push_line(out, &Unreadable { source, error });
}

pub(super) fn push_line(out: &mut String, record: &impl Serialize) {
    // Strings and numbers only: there is nothing in these records that JSON cannot hold.
    out.push_str(&serde_json::to_string(record).unwrap_or_default());
    out.push('\n');
}

fn judged<'a>(source: &'a str, report: &'a ChannelReport, expected: Option<Bitrate>) -> Judged<'a> {
    Judged {
        source,
        channel: &report.channel,
        inverted: report.inverted,
        verdict: verdict_name(report.outcome),
        nominal: report.nominal.as_ref().map(rate),
        data: report.data.as_ref().map(rate),
        other: report.other.as_ref().map(rate),
        need: report.need.as_deref(),
        proven_frames: report.proven_frames,
        frames: frames(&report.frames),
        error_probability: report.error_probability,
        bus_load: rounded(report.bus_load, 6),
        asymmetry_ns: report.asymmetry_ns.map(|value| rounded(value, 3)),
        clock_spread_ppm: report.clock_spread_ppm.map(|value| rounded(value, 3)),
        samples_per_bit: report.samples_per_bit.map(|value| rounded(value, 6)),
        duration_s: rounded(report.duration_s, 9),
        edges: report.edges,
        expected: expected.map(|wanted| ExpectedRecord {
            bitrate: wanted.bits_per_second(),
            deviation_ppm: report
                .nominal
                .as_ref()
                .map(|rate| deviation_ppm(rate.measured, wanted.bits_per_second())),
        }),
        caveats: report
            .caveats
            .iter()
            .map(|caveat| CaveatRecord { code: caveat.code, text: &caveat.text })
            .collect(),
    }
}

pub(super) const fn verdict_name(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Found => "found",
        Outcome::Undecided => "undecided",
        Outcome::NoTraffic => "no_traffic",
        Outcome::Conflict => "conflict",
    }
}

fn rate(rate: &Rate) -> RateRecord<'_> {
    RateRecord {
        bitrate: rate.bitrate,
        measured: rounded(rate.measured, 3),
        uncertainty_ppm: rounded(rate.uncertainty_ppm, 6),
        known_as: rate.known_as,
    }
}

const fn frames(counts: &FrameCounts) -> FramesRecord {
    FramesRecord {
        classic: counts.classic,
        fd: counts.fd,
        remote: counts.remote,
        error: counts.error,
        truncated: counts.truncated,
        overload: counts.overload,
        fd_brs: counts.fd_brs,
        fd_non_iso: counts.fd_non_iso,
        extended: counts.extended,
        unacknowledged: counts.unacknowledged,
    }
}

#[cfg(test)]
mod tests;
