//! `detect` on a live bus for people: the verdict first, as for captures.

use std::fmt::Write as _;

use canbaud::detect::scan::{Acknowledgement, Capture, FdSeen, Standing};

use super::advice::sample_point;
use super::number::{bitrate, count};
use super::paint::Paint;
use super::text::{Detail, Sheet};
use crate::report::{LiveRate, LiveReport, Outcome};

/// Rates whose story is told one by one.
const TOLD: usize = 16;

/// Everything about a live bus.
pub(crate) fn render(report: &LiveReport, detail: Detail, paint: Paint) -> String {
    let verdict = headline(report);
    let mut text = match report.outcome {
        Outcome::Found => paint.good(&verdict),
        Outcome::Undecided | Outcome::NoTraffic => paint.warn(&verdict),
        Outcome::Conflict => paint.bad(&verdict),
    };
    text.push('\n');
    if detail == Detail::Brief {
        return text;
    }
    let mut sheet = Sheet::new(text, paint);
    sheet.line("adapter", &report.adapter);
    if let Some(rate) = &report.found {
        found(&mut sheet, rate);
    }
    let most = match report.bound {
        Some(bound) => format!(" of at most {bound}"),
        None => String::new(),
    };
    let tries = count(report.visits.into(), "try", "tries");
    sheet.line("took", &format!("{}{most}, {tries}", report.elapsed));
    tried(&mut sheet, &report.tried);
    sheet.remarks(&report.caveats);
    let mut text = sheet.into_text();
    if let Some(rate) = report.found.as_ref().filter(|rate| !rate.lacks_data_rate()) {
        let interface = if report.source.contains('/') { "can0" } else { &report.source };
        let _ = write!(text, "\n  {}\n", paint.strong(&ip_link(interface, rate)));
    }
    text
}

fn headline(report: &LiveReport) -> String {
    let need = report.need.as_deref().unwrap_or("nothing is known");
    match (report.outcome, &report.found) {
        (Outcome::Found, Some(rate)) => {
            let proven = count(rate.frames.into(), "frame", "frames");
            format!("{} — proven by {proven}", rates(rate))
        }
        (Outcome::NoTraffic, _) => format!("no traffic — {need}"),
        (Outcome::Found | Outcome::Undecided | Outcome::Conflict, _) => {
            format!("undecided — {need}")
        }
    }
}

fn rates(rate: &LiveRate) -> String {
    let nominal = bitrate(rate.nominal);
    match (rate.data, rate.fd) {
        (Some(data), _) => format!("{nominal}, CAN FD data {}", bitrate(data)),
        (None, FdSeen::NeverSwitched) => {
            format!("{nominal}, CAN FD without bit rate switch (data rate unknown)")
        }
        (None, FdSeen::Switched) => format!("{nominal}, CAN FD (data rate unknown)"),
        (None, FdSeen::No | FdSeen::Suspected) => nominal,
    }
}

fn found(sheet: &mut Sheet, rate: &LiveRate) {
    sheet.line("nominal", &bitrate(rate.nominal));
    if let Some(users) = rate.known_as {
        sheet.fine_print(users);
    }
    if let Some(data) = rate.data {
        sheet.line("data", &bitrate(data));
    }
    let frames = count(rate.frames.into(), "frame", "frames");
    let distinct = match rate.distinct {
        2.. => ", not all alike",
        _ if rate.frames > 1 => ", all alike",
        _ => "",
    };
    sheet.line("proof", &format!("the adapter received {frames} without an error{distinct}"));
    let errors = match rate.errors {
        0 => "none".to_owned(),
        errors => count(errors.into(), "error or burst of errors", "errors or bursts of errors"),
    };
    sheet.line("errors", &errors);
    if rate.acknowledgement == Acknowledgement::Missing {
        sheet.line("acknowledge", "missing: the sender is alone on the bus");
    }
}

/// What was heard at each rate.
fn tried(sheet: &mut Sheet, standings: &[Standing]) {
    for (place, one) in standings.iter().take(TOLD).enumerate() {
        let label = if place == 0 { "tried" } else { "" };
        sheet.line(label, &story(one));
    }
    if standings.len() > TOLD {
        let more = (standings.len() - TOLD) as u64;
        sheet.line("", &format!("and {}", count(more, "more rate", "more rates")));
    }
}

fn story(one: &Standing) -> String {
    let about = if one.candidate.capture == Capture::Wide { "about " } else { "" };
    let mut name = format!("{about}{}", bitrate(one.candidate.nominal.bits_per_second()));
    if let Some(data) = one.candidate.data {
        let _ = write!(name, ", data {}", bitrate(data.bits_per_second()));
    }
    if one.refused {
        return format!("{name}: refused by the adapter");
    }
    let heard = match (one.frames, one.errors) {
        (0, 0) => "nothing".to_owned(),
        (0, errors) => count(errors.into(), "error", "errors"),
        (frames, 0) => count(frames.into(), "frame", "frames"),
        (frames, errors) => format!(
            "{}, {}",
            count(frames.into(), "frame", "frames"),
            count(errors.into(), "error", "errors")
        ),
    };
    format!("{name}: {heard} in {}", one.listened)
}

/// The command that sets a Linux interface to what was found.
pub(crate) fn ip_link(interface: &str, rate: &LiveRate) -> String {
    let mut line = format!(
        "ip link set {interface} type can bitrate {} sample-point {}",
        rate.nominal,
        sample_point(rate.nominal)
    );
    if let Some(data) = rate.data {
        let _ = write!(line, " dbitrate {data} dsample-point {} fd on", sample_point(data));
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::live;

    #[test]
    fn a_rate_that_was_found_is_told_with_what_was_tried() {
        let want = [
            "250 kbit/s — proven by 2 frames",
            "  adapter      can0 (gs_usb)",
            "  nominal      250 kbit/s",
            "               SAE J1939",
            "  proof        the adapter received 2 frames without an error, not all alike",
            "  errors       none",
            "  took         41.000 ms of at most 9.000 s, 2 tries",
            "  tried        500 kbit/s: 3 errors in 20.000 ms",
            "               250 kbit/s: 2 frames in 20.000 ms",
            "",
            "  ip link set can0 type can bitrate 250000 sample-point 0.875",
            "",
        ];
        assert_eq!(render(&live(), Detail::Full, Paint::Plain), want.join("\n"));
    }

    #[test]
    fn a_lone_sender_and_a_data_rate_are_told() {
        let mut report = live();
        let rate = report.found.as_mut().unwrap();
        rate.acknowledgement = Acknowledgement::Missing;
        (rate.data, rate.fd) = (Some(2_000_000), FdSeen::Switched);
        let text = render(&report, Detail::Full, Paint::Plain);
        assert!(text.starts_with("250 kbit/s, CAN FD data 2 Mbit/s — "), "{text}");
        assert!(text.contains("acknowledge  missing: the sender is alone"), "{text}");
        assert!(text.ends_with("dbitrate 2000000 dsample-point 0.750 fd on\n"), "{text}");
    }

    /// A classic node would destroy every CAN FD frame.
    #[test]
    fn can_fd_without_a_data_rate_is_told_and_has_no_command() {
        let mut report = live();
        for (fd, want) in [
            (FdSeen::Switched, "250 kbit/s, CAN FD (data rate unknown) — "),
            (FdSeen::NeverSwitched, "250 kbit/s, CAN FD without bit rate switch (data rate un"),
            (FdSeen::Suspected, "250 kbit/s — "),
        ] {
            report.found.as_mut().unwrap().fd = fd;
            let text = render(&report, Detail::Full, Paint::Plain);
            assert!(text.starts_with(want), "{text}");
            assert!(!text.contains("ip link"), "{text}");
        }
    }

    #[test]
    fn without_a_rate_there_is_no_command() {
        let mut report = live();
        (report.outcome, report.found) = (Outcome::Undecided, None);
        report.need = Some("there is traffic".to_owned());
        let text = render(&report, Detail::Full, Paint::Plain);
        assert!(text.starts_with("undecided — there is traffic\n"), "{text}");
        assert!(!text.contains("ip link"), "{text}");
    }
}
