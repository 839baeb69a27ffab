//! `detect` for people: the verdict first, then what one would ask next.

use std::fmt::Write as _;

use canbaud::units::Bitrate;

use super::advice::ip_link;
use super::expected;
use super::number::{
    bitrate, bound, count, deviation_ppm, duration, percent, short, thousands, with_uncertainty,
};
use super::paint::Paint;
use crate::printable::printable;
use crate::report::{ChannelReport, FrameCounts, Outcome, Rate};

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
pub(crate) fn headline(report: &ChannelReport) -> String {
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
            let both: Vec<String> = [&report.nominal, &report.other]
                .into_iter()
                .flatten()
                .map(|rate| bitrate(rate.bitrate))
                .collect();
            format!("conflict — two rates on one line: {}", both.join(" and "))
        }
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
        sheet.caveats(bus);
        if let Some(line) = ip_link(bus) {
            let _ = write!(sheet.text, "\n  {}\n", paint.strong(&line));
        }
        sheet.others(others);
        text = sheet.text;
    }
    text
}

/// Lines of a label and what it says.
struct Sheet {
    text: String,
    paint: Paint,
}

impl Sheet {
    fn line(&mut self, label: &str, value: &str) {
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
        if let Some(asymmetry) = report.asymmetry_ns {
            self.line("asymmetry", &asymmetry_words(asymmetry));
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
            let mut value = format!(
                "{measured:>rate_width$} bit/s   {offset:>offset_width$} ppm of {}",
                bitrate(rate.bitrate)
            );
            if let Some(user) = rate.known_as {
                let _ = write!(value, "   {}", self.paint.dim(user));
            }
            self.line(label, &value);
        }
        if let (Some(wanted), Some(rate)) = (expected, &report.nominal) {
            self.line("expected", &expected::words(wanted, rate));
        }
    }

    fn frames(&mut self, frames: &FrameCounts) {
        self.line("frames", &frames_words(frames));
        let good = frames.classic + frames.fd + frames.remote;
        let mut errors = Vec::new();
        if frames.error > 0 {
            errors.push(count(frames.error, "destroyed frame", "destroyed frames"));
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

    fn caveats(&mut self, report: &ChannelReport) {
        for caveat in &report.caveats {
            self.text.push('\n');
            let mark = self.paint.warn("!");
            let lines = wrap(&caveat.text, WIDTH - 4);
            let _ = writeln!(self.text, "  {mark} {}", lines.join("\n    "));
        }
    }

    /// The other channels: the silent ones in one line.
    fn others(&mut self, others: &[ChannelReport]) {
        if others.is_empty() {
            return;
        }
        self.text.push('\n');
        let (silent, busy): (Vec<&ChannelReport>, Vec<_>) =
            others.iter().partition(|report| report.outcome == Outcome::NoTraffic);
        for report in busy {
            self.line("also", &format!("{}: {}", printable(&report.channel), headline(report)));
        }
        if !silent.is_empty() {
            let names: Vec<String> =
                silent.iter().map(|report| printable(&report.channel)).collect();
            self.line("no traffic", &names.join(", "));
        }
    }
}

/// `612 classic, 376 CAN FD (370 with bit rate switch), 12 remote; 30 extended`.
fn frames_words(frames: &FrameCounts) -> String {
    let mut kinds = Vec::new();
    if frames.classic > 0 {
        kinds.push(format!("{} classic", thousands(frames.classic)));
    }
    if frames.fd > 0 {
        let switched = match frames.fd_brs {
            0 => "none switches the bit rate".to_owned(),
            n if n == frames.fd => "all switch the bit rate".to_owned(),
            n => format!("{} switch the bit rate", thousands(n)),
        };
        let non_iso = match frames.fd_non_iso {
            0 => "",
            n if n == frames.fd => ", non-ISO CRC",
            _ => ", ISO and non-ISO CRC mixed",
        };
        kinds.push(format!("{} CAN FD ({switched}{non_iso})", thousands(frames.fd)));
    }
    if frames.remote > 0 {
        kinds.push(format!("{} remote", thousands(frames.remote)));
    }
    let mut text = if kinds.is_empty() { "no good frame".to_owned() } else { kinds.join(", ") };
    if frames.extended > 0 {
        let _ = write!(text, "; {} extended", thousands(frames.extended));
    }
    text
}

fn asymmetry_words(nanoseconds: f64) -> String {
    let size = short(nanoseconds.abs());
    match nanoseconds {
        ns if ns.abs() < 1.0 => "below 1 ns".to_owned(),
        ns if ns > 0.0 => format!("dominant bits {size} ns longer, recessive bits shorter"),
        _ => format!("dominant bits {size} ns shorter, recessive bits longer"),
    }
}

/// Breaks text into lines of at most `width` characters, where there are blanks.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let room = lines.last().map_or(0, |line| line.chars().count());
        if room > 0 && room + 1 + word.chars().count() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

#[cfg(test)]
mod tests;
