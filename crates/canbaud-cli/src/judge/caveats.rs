//! What a person should know about a verdict, each with what to do about it.

use canbaud_capture::Channel;

use super::channel::ChannelJudge;
use crate::output::count;
use crate::report::{Caveat, ChannelReport, Outcome};

/// Below this, a bit time rests on few ticks.
const SAMPLES_PER_BIT_MIN: f64 = 4.0;
/// Asymmetry worth a remark, as a share of the shortest bit.
const ASYMMETRY_SHARE: f64 = 0.1;
/// A deviation from the known rate worth a remark: what CAN allows for a good clock.
const DEVIATION_PPM: f64 = 1_500.0;
/// Destroyed frames worth a remark, as a share of all.
const ERROR_SHARE: f64 = 0.01;

/// All that apply.
pub(super) fn of(
    report: &ChannelReport,
    judge: &ChannelJudge,
    channel: &Channel,
    notes: &[String],
) -> Vec<Caveat> {
    let mut caveats = Vec::new();
    if matches!(report.outcome, Outcome::Found | Outcome::Conflict) {
        traffic(report, judge, &mut caveats);
        signal(report, channel, &mut caveats);
    }
    caveats
        .extend(notes.iter().map(|note| Caveat { code: "capture_file", text: format!("{note}.") }));
    caveats
}

fn add(caveats: &mut Vec<Caveat>, code: &'static str, text: String) {
    caveats.push(Caveat { code, text });
}

/// What the frames say.
fn traffic(report: &ChannelReport, judge: &ChannelJudge, caveats: &mut Vec<Caveat>) {
    let frames = &report.frames;
    let good = frames.good();
    if report.proven_frames == 1 {
        add(
            caveats,
            "single_frame",
            "The verdict rests on one frame: capture longer for a sharper rate.".to_owned(),
        );
    }
    if frames.fd > 0 && frames.fd_brs == 0 {
        add(
            caveats,
            "data_rate_unseen",
            "CAN FD frames were seen, none with a bit rate switch: the data bit rate is unknown."
                .to_owned(),
        );
    }
    if judge.evidence.data_rate_unknown > 0 {
        add(
            caveats,
            "data_rate_unknown",
            format!(
                "The data bit rate of {} could not be found: sample faster, at least three times \
                 the data bit rate.",
                count(judge.evidence.data_rate_unknown, "CAN FD frame", "CAN FD frames")
            ),
        );
    }
    if frames.fd_non_iso > 0 {
        add(
            caveats,
            "non_iso",
            "CAN FD frames carry the non-ISO CRC: set the controller to non-ISO (fd-non-iso on)."
                .to_owned(),
        );
    }
    let silent = frames.unacknowledged + judge.evidence.acknowledge_errors;
    if silent > 0 && 2 * silent >= good + judge.evidence.acknowledge_errors {
        add(
            caveats,
            "missing_acknowledge",
            format!(
                "{} not acknowledged: no second active node at this rate is on \
                 the bus, or only the sender's TXD was recorded.",
                count(silent, "frame was", "frames were")
            ),
        );
    }
    let errors = frames.error;
    if errors > 0 && errors as f64 >= ERROR_SHARE * (good + errors) as f64 {
        add(
            caveats,
            "error_frames",
            format!(
                "{}: a node at another rate, wiring, termination or noise.",
                count(errors, "destroyed frame", "destroyed frames")
            ),
        );
    }
}

/// What the edges say.
fn signal(report: &ChannelReport, channel: &Channel, caveats: &mut Vec<Caveat>) {
    let Some(nominal) = &report.nominal else { return };
    let fastest = report.data.as_ref().map_or(nominal.measured, |data| data.measured);
    if let Some(per_bit) = report.samples_per_bit {
        let per_shortest = per_bit * nominal.measured / fastest;
        if per_shortest < SAMPLES_PER_BIT_MIN {
            let wanted = fastest * 10.0;
            add(
                caveats,
                "few_samples_per_bit",
                format!(
                    "{per_shortest:.1} samples per bit: frames may be lost; sample at {} or more.",
                    if wanted >= 1e6 {
                        format!("{:.0} MHz", wanted / 1e6)
                    } else {
                        format!("{:.0} kHz", wanted / 1e3)
                    }
                ),
            );
        }
    }
    let bit_ns = 1e9 / fastest;
    if let Some(asymmetry) = report.asymmetry_ns
        && asymmetry.abs() > ASYMMETRY_SHARE * bit_ns
        && !super::conclude::is_difference(channel)
    {
        let (longer, by) =
            if asymmetry > 0.0 { ("longer", asymmetry) } else { ("shorter", -asymmetry) };
        add(
            caveats,
            "asymmetry",
            format!(
                "Dominant bits are {by:.0} ns {longer} than recessive ones would allow: threshold, \
                 termination or transceiver; a detector that takes the shortest pulse is misled."
            ),
        );
    }
    if let Some(known) = nominal.known_as {
        let off = (nominal.measured / f64::from(nominal.bitrate) - 1.0) * 1e6;
        if off.abs() > DEVIATION_PPM + 3.0 * nominal.uncertainty_ppm {
            add(
                caveats,
                "clock_deviation",
                format!(
                    "The bus runs {off:+.0} ppm off the rate of {known}: a poor clock in the \
                     nodes or in the recorder."
                ),
            );
        }
    }
}
