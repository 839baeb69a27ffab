//! The edge detector on the recordings in `vectors/detect`, which an independent reference made.

use canbaud::detect::{BitTime, CompactDetector, DataPhase, PulseDetector, Verdict};
use canbaud::units::{Hertz, Timebase};
use canbaud::wire::{Logic, Polarity};
use serde::Deserialize;
use std::fs;
use std::path::Path;

#[derive(Deserialize)]
struct Recording {
    why: String,
    timebase_hz: u64,
    initial: String,
    edges: Vec<u64>,
    end: u64,
    expect: Expect,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expect {
    verdict: String,
    #[serde(default)]
    nominal_millibits_per_second: [u64; 2],
    #[serde(default)]
    data: String,
    #[serde(default)]
    data_millibits_per_second: [u64; 2],
    polarity: Option<String>,
}

impl Recording {
    fn verdict(&self) -> Verdict {
        let mut detector = PulseDetector::<800>::new();
        detector.begin(0, if self.initial == "high" { Logic::High } else { Logic::Low });
        for edge in &self.edges {
            detector.push(*edge);
        }
        detector.finish(self.end);
        detector.verdict()
    }

    /// Why the verdict is not the expected one.
    fn complaint(&self) -> Option<String> {
        let verdict = self.verdict();
        let problem = match (&verdict, self.expect.verdict.as_str()) {
            (Verdict::Found(found), "found") => {
                let polarity = match found.polarity {
                    Polarity::Normal => "normal",
                    Polarity::Inverted => "inverted",
                };
                let data = match found.data {
                    DataPhase::NoFd => "none",
                    DataPhase::NeverSwitched => "never_switched",
                    DataPhase::Switched(_) => "switched",
                };
                if !self.within(found.nominal, self.expect.nominal_millibits_per_second) {
                    Some("nominal rate")
                } else if data != self.expect.data {
                    Some("data phase")
                } else if Some(polarity) != self.expect.polarity.as_deref() {
                    Some("polarity")
                } else {
                    match found.data {
                        DataPhase::Switched(bit)
                            if !self.within(bit, self.expect.data_millibits_per_second) =>
                        {
                            Some("data rate")
                        }
                        _ => None,
                    }
                }
            }
            (Verdict::Undecided(_), "undecided")
            | (Verdict::NoTraffic, "no_traffic")
            | (Verdict::Conflict { .. }, "conflict") => None,
            _ => Some("verdict"),
        };
        problem
            .map(|what| format!("{}: {what} of {verdict:?}, expected {:?}", self.why, self.expect))
    }

    fn within(&self, bit: BitTime, [least, greatest]: [u64; 2]) -> bool {
        let timer = Hertz::new(self.timebase_hz).map(Timebase::from_frequency);
        let rate = timer.and_then(|timer| bit.millibits_per_second(timer));
        rate.is_some_and(|rate| (least..=greatest).contains(&rate))
    }
}

#[test]
fn detector_agrees_with_every_recording() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vectors/detect");
    let mut count = 0;
    let mut wrong = Vec::new();
    for entry in fs::read_dir(&folder).expect("the vectors are part of the project") {
        let path = entry.expect("a readable folder").path();
        let text = fs::read_to_string(&path).expect("a readable vector file");
        let recording: Recording =
            toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        count += 1;
        let name = path.file_stem().expect("a file name").to_string_lossy().into_owned();
        wrong.extend(recording.complaint().map(|complaint| format!("{name}: {complaint}")));
    }
    wrong.sort();
    assert!(wrong.is_empty(), "{} of {count} differ:\n{}", wrong.len(), wrong.join("\n"));
    assert!(count >= 40, "only {count} recordings in {}", folder.display());
}

/// The compact detector finds less, and nothing else.
#[test]
fn compact_detector_contradicts_no_recording() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vectors/detect");
    let mut found = 0;
    for entry in fs::read_dir(&folder).expect("the vectors are part of the project") {
        let path = entry.expect("a readable folder").path();
        let text = fs::read_to_string(&path).expect("a readable vector file");
        let recording: Recording = toml::from_str(&text).expect("a recording");
        let mut detector = CompactDetector::<128>::new();
        detector.begin(0, if recording.initial == "high" { Logic::High } else { Logic::Low });
        recording.edges.iter().for_each(|edge| detector.push(*edge));
        detector.finish(recording.end);
        if let Verdict::Found(verdict) = detector.verdict() {
            found += 1;
            let expect = &recording.expect;
            // Of two rates on one line it names the first that it proves.
            let right = recording.within(verdict.nominal, expect.nominal_millibits_per_second)
                || expect.verdict == "conflict";
            assert!(right, "{}: {verdict:?}, expected {expect:?}", path.display());
        }
    }
    assert!(found >= 15, "{found} recordings only");
}
