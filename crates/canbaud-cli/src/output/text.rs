//! `detect` for people: the verdict first, then what one would ask next.

use std::fmt::Write as _;

use canbaud::units::Bitrate;

use super::advice::ip_link;
use super::expected;
use super::number::{
    bitrate, bound, count, deviation_ppm, duration, percent, short, thousands, with_uncertainty,
};
use super::paint::Paint;
use super::words::{asymmetry, frames_by_kind, wrap};
use crate::printable::printable;
use crate::report::{Caveat, ChannelReport, FrameCounts, Outcome, Rate};

/// How much to say about a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Detail {
    /// The verdict and everything known.
    Full,
    /// The verdict alone.
    Brief,
}

/// Columns of the labels.
const LABEL: usize = 13;
/// Text is broken before this column.
const WIDTH: usize = 96;

/// The verdict on one channel in one line of plain words.
fn headline(report: &ChannelReport) -> String {
    match report.outcome {
        Outcome::Found => {
            let proven = count(report.proven_frames, "frame", "frames");
            format!("{} — proven by {proven}", rates(report))
        }
        Outcome::Undecided => match &report.need {
            Some(need) => format!("undecided — {need}"),
            None => "undecided".to_owned(),
        },
        Outcome::NoTraffic => {
            let span = duration(report.duration_s);
            match report.edges {
                0 => format!("no traffic — the line never changed in {span}"),
                edges => format!("no traffic — {} in {span}", count(edges, "edge", "edges")),
            }
        }
        Outcome::Conflict => {
            // Where data rates differ, the nominal one is not in question.
            let first = report.data.as_ref().or(report.nominal.as_ref());
            let both: Vec<String> = [first, report.other.as_ref()]
                .into_iter()
                .flatten()
                .map(|rate| bitrate(rate.bitrate))
                .collect();
            format!("conflict — two rates on one line: {}", both.join(" and "))
        }
    }
}

/// The verdict with what was decoded, in one line.
pub(crate) fn summary(report: &ChannelReport) -> String {
    let verdict = headline(report);
    if report.outcome != Outcome::Found {
        return verdict;
    }
    let good = report.frames.classic + report.frames.fd + report.frames.remote;
    let frames = count(good, "good frame", "good frames");
    match report.frames.error {
        0 => format!("{verdict}; {frames}"),
        errors => format!("{verdict}; {frames}, {}", count(errors, "error", "errors")),
    }
}

/// `500 kbit/s, CAN FD data 2 Mbit/s`.
fn rates(report: &ChannelReport) -> String {
    let nominal = report.nominal.as_ref().map_or_else(String::new, |r| bitrate(r.bitrate));
    match &report.data {
        Some(data) => format!("{nominal}, CAN FD data {}", bitrate(data.bitrate)),
        None if report.frames.fd > 0 => {
            format!("{nominal}, CAN FD without bit rate switch (data rate unknown)")
        }
        None => nominal,
    }
}

/// Everything about one source; the first channel is the one that carries the bus.
///
/// `source` is named where there are several.
pub(crate) fn render(
    source: Option<&str>,
    channels: &[ChannelReport],
    detail: Detail,
    expected: Option<Bitrate>,
    paint: Paint,
) -> String {
    let mut text = String::new();
    let Some((bus, others)) = channels.split_first() else { return text };
    if let Some(source) = source {
        let _ = write!(text, "{} ", paint.strong(&format!("{source}:")));
    }
    let verdict = headline(bus);
    text.push_str(&match bus.outcome {
        Outcome::Found => paint.good(&verdict),
        Outcome::Undecided | Outcome::NoTraffic => paint.warn(&verdict),
        Outcome::Conflict => paint.bad(&verdict),
    });
    text.push('\n');
    if detail == Detail::Full {
        let mut sheet = Sheet { text, paint };
        sheet.bus(bus, expected);
        sheet.remarks(&bus.caveats);
        if let Some(line) = ip_link(bus) {
            let _ = write!(sheet.text, "\n  {}\n", paint.strong(&line));
        }
        sheet.others(others);
        text = sheet.text;
    }
    text
}

/// Lines of a label and what it says.
pub(super) struct Sheet {
    text: String,
    paint: Paint,
}

impl Sheet {
    pub(super) const fn new(text: String, paint: Paint) -> Self {
        Self { text, paint }
    }

    pub(super) fn into_text(self) -> String {
        self.text
    }

    /// Dim text below a value.
    pub(super) fn fine_print(&mut self, text: &str) {
        for line in wrap(text, WIDTH - LABEL) {
            let line = self.paint.dim(&line);
            self.line("", &line);
        }
    }

    pub(super) fn line(&mut self, label: &str, value: &str) {
        let label = self.paint.dim(&format!("{label:<LABEL$}"));
        let _ = writeln!(self.text, "  {label}{value}");
    }

    fn bus(&mut self, report: &ChannelReport, expected: Option<Bitrate>) {
        let polarity = if report.inverted { ", inverted (high is dominant)" } else { "" };
        self.line("channel", &format!("{}{polarity}", printable(&report.channel)));
        self.rates(report, expected);
        if report.outcome == Outcome::Found {
            let frames = count(report.proven_frames, "frame", "frames");
            let bound = bound(report.error_probability);
            self.line(
                "proof",
                &format!("CRC and form of {frames}; wrong with probability {bound}"),
            );
        }
        if report.frames != FrameCounts::default() {
            self.frames(&report.frames);
        }
        if report.edges > 0 {
            let span = duration(report.duration_s);
            let edges = count(report.edges, "edge", "edges");
            self.line("bus load", &format!("{}   {edges} in {span}", percent(report.bus_load)));
        }
        if let Some(nanoseconds) = report.asymmetry_ns {
            self.line("asymmetry", &asymmetry(nanoseconds));
        }
        if let Some(spread) = report.clock_spread_ppm {
            self.line("clocks", &format!("the senders differ by {} ppm", short(spread)));
        }
        if let Some(samples) = report.samples_per_bit {
            self.line("sampling", &format!("{} samples per bit", short(samples)));
        }
    }

    /// The measured rates, aligned under each other.
    fn rates(&mut self, report: &ChannelReport, expected: Option<Bitrate>) {
        let label = match report.outcome {
            Outcome::Undecided => "suspected",
            Outcome::Found | Outcome::NoTraffic | Outcome::Conflict => "nominal",
        };
        let rows = [(label, &report.nominal), ("data", &report.data), ("second", &report.other)];
        let rows: Vec<(&str, &Rate, [String; 2])> = rows
            .into_iter()
            .filter_map(|(label, rate)| {
                let rate = rate.as_ref()?;
                let measured = thousands(rate.measured.max(0.0).round() as u64);
                let offset = deviation_ppm(rate.measured, rate.bitrate);
                Some((label, rate, [measured, with_uncertainty(offset, rate.uncertainty_ppm)]))
            })
            .collect();
        let width = |column: usize| {
            rows.iter().map(|(_, _, cells)| cells[column].chars().count()).max().unwrap_or(0)
        };
        let (rate_width, offset_width) = (width(0), width(1));
        for (label, rate, [measured, offset]) in &rows {
            let value = format!(
                "{measured:>rate_width$} bit/s   {offset:>offset_width$} ppm of {}",
                bitrate(rate.bitrate)
            );
            self.line(label, &value);
            if let Some(users) = rate.known_as {
                self.fine_print(users);
            }
        }
        if let (Some(wanted), Some(rate)) = (expected, &report.nominal) {
            self.line("expected", &expected::words(wanted, rate));
        }
    }

    fn frames(&mut self, frames: &FrameCounts) {
        self.line("frames", &frames_by_kind(frames));
        let good = frames.classic + frames.fd + frames.remote;
        let mut errors = Vec::new();
        if frames.error > 0 {
            errors.push(count(frames.error, "destroyed frame", "destroyed frames"));
        }
        if frames.truncated > 0 {
            errors.push(format!(
                "{} cut off by the recording",
                count(frames.truncated, "frame", "frames")
            ));
        }
        if frames.overload > 0 {
            errors.push(count(frames.overload, "overload frame", "overload frames"));
        }
        let errors = if errors.is_empty() { "none".to_owned() } else { errors.join(", ") };
        self.line("errors", &errors);
        let missing = frames.unacknowledged;
        let ack = match missing {
            0 if good > 0 => "every frame".to_owned(),
            0 => return,
            missing if missing == good => "missing on every frame".to_owned(),
            missing => format!("missing on {} of {} frames", thousands(missing), thousands(good)),
        };
        self.line("acknowledge", &ack);
    }

    pub(super) fn remarks(&mut self, caveats: &[Caveat]) {
        if !caveats.is_empty() {
            self.text.push('\n');
        }
        for caveat in caveats {
            let mark = self.paint.warn("!");
            let lines = wrap(&caveat.text, WIDTH - 4);
            let _ = writeln!(self.text, "  {mark} {}", lines.join("\n    "));
        }
    }

    /// The other channels: those without a rate in one line per verdict.
    fn others(&mut self, others: &[ChannelReport]) {
        if others.is_empty() {
            return;
        }
        self.text.push('\n');
        for report in others {
            if matches!(report.outcome, Outcome::Found | Outcome::Conflict) {
                self.line("also", &format!("{}: {}", printable(&report.channel), headline(report)));
            }
        }
        for (label, outcome) in
            [("undecided", Outcome::Undecided), ("no traffic", Outcome::NoTraffic)]
        {
            let names: Vec<String> = others
                .iter()
                .filter(|report| report.outcome == outcome)
                .map(|report| printable(&report.channel))
                .collect();
            if !names.is_empty() {
                let lines = wrap(&names.join(", "), WIDTH - LABEL);
                self.line(label, &lines.join(&format!("\n{:1$}", "", LABEL + 2)));
            }
        }
    }
}

#[cfg(test)]
mod tests;
