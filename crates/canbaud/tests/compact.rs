//! The compact detector on random recordings with their truth.

mod support;

use canbaud::detect::{CompactDetector, Verdict};
use canbaud::wire::{FdCrc, Frame, FrameKind, Id, Level, Logic, Polarity, encode};
use support::judge::{Judgement, TOLERANCE_PPM, Truth, judge};
use support::trial::{Resolution, Scene, Trial};

const SEED: u64 = 29;

/// Plays the recording into a detector as RXD sees it: high is recessive.
fn detect(trial: &Trial) -> Verdict {
    let recording = trial.record();
    let mut detector = CompactDetector::<128>::new();
    let initial = match trial.polarity {
        Polarity::Normal => recording.initial,
        Polarity::Inverted => recording.initial.toggled(),
    };
    detector.begin(recording.begin, initial);
    for edge in &recording.edges {
        detector.push(edge.at);
    }
    detector.finish(recording.finish);
    detector.verdict()
}

/// How many of `count` trials are right, in thousandths; one that is wrong is a failure.
fn right_permille(scene: Scene, resolution: Resolution, count: u64) -> u64 {
    let mut right = 0;
    for number in 0..count {
        let trial = Trial::draw(SEED, number, scene, resolution);
        let truth = match trial.truth() {
            Truth::Bus { nominal, data, .. } => {
                Truth::Bus { nominal, data, polarity: Polarity::Normal }
            }
            Truth::Foreign => Truth::Foreign,
        };
        match judge(&truth, &detect(&trial), TOLERANCE_PPM) {
            Judgement::Right { .. } => right += 1,
            Judgement::Undecided(_) | Judgement::Rejected => {}
            Judgement::Wrong(what) => {
                panic!("{what}: seed {SEED} trial {number} {resolution:?}: {trial:?}")
            }
        }
    }
    right * 1000 / count
}

#[test]
fn no_recording_leads_to_a_wrong_rate() {
    for scene in Scene::ALL {
        for ticks in [1.7, 2.4, 3.2, 4.0, 5.5, 8.0, 16.0, 144.0] {
            right_permille(scene, Resolution::TicksPerBit(ticks), 300);
        }
        right_permille(scene, Resolution::UsualTimers, 1000);
    }
}

#[test]
fn one_frame_is_enough_from_eight_ticks_a_bit_on() {
    for ticks in [8.0, 16.0, 72.0, 1000.0] {
        for scene in [Scene::Clean, Scene::Asymmetry, Scene::Jitter, Scene::Cut] {
            let right = right_permille(scene, Resolution::TicksPerBit(ticks), 400);
            assert!(right >= 970, "{scene:?} at {ticks} ticks a bit: {right} of 1000");
        }
    }
    let right = right_permille(Scene::Clean, Resolution::TicksPerBit(4.0), 400);
    assert!(right >= 720, "at 4 ticks a bit: {right} of 1000");
}

#[test]
fn one_sender_without_acknowledge_is_enough() {
    let right = right_permille(Scene::Unacknowledged, Resolution::TicksPerBit(8.0), 400);
    assert!(right >= 980, "{right} of 1000");
}

/// The second try of a destroyed frame stands close behind the first.
#[test]
fn frames_behind_an_error_frame_are_found() {
    let right = right_permille(Scene::ErrorFlag, Resolution::TicksPerBit(16.0), 400);
    assert!(right >= 330, "{right} of 1000");
}

/// Something that looks like frames, but for its CRC, and then frames.
#[test]
fn what_was_compared_in_vain_counts_against_a_proof() {
    let frame = |byte: u8| {
        Frame::new(Id::Base(0x2A5), FrameKind::Data, 4, &[byte, 0x31, 0x57, 0x9C]).expect("a frame")
    };
    // So many wrong ones, the frames that come then, and the bits of proof that are left: 15 for
    // each of those needed, less the logarithm of the comparisons for each.
    let cases: [(u8, &[u8], Option<u32>); 6] = [
        (0, &[1], Some(15)),
        (15, &[1], Some(11)),
        (40, &[1], None),
        (40, &[1, 1, 1], None),
        (40, &[1, 2], Some(30 - 2 * 6)),
        (40, &[1, 2, 3], Some(30 - 2 * 6)),
    ];
    for (wrong, right, want) in cases {
        let mut detector = CompactDetector::<128>::new();
        let mut line = Line { at: 0, level: Level::Recessive, edges: Vec::new() };
        for byte in 0..wrong {
            // The data of one frame with the CRC of another, as no stuff bit is moved by it.
            line.send(&with_foreign_crc(byte));
        }
        for &byte in right {
            line.send(&encode(&frame(byte), FdCrc::Iso).bits.iter().collect::<Vec<_>>());
        }
        detector.begin(0, Logic::High);
        line.edges.iter().for_each(|&at| detector.push(at));
        detector.finish(line.at);
        let proof = match detector.verdict() {
            Verdict::Found(found) => Some(found.proof_bits),
            Verdict::Undecided(_) | Verdict::NoTraffic | Verdict::Conflict { .. } => None,
        };
        assert_eq!(proof, want, "{wrong} wrong ones, then {right:?}");
    }
}

/// A frame with a turned CRC bit, where stuffing is none the wiser.
fn with_foreign_crc(byte: u8) -> Vec<Level> {
    let legal = |bits: &[Level]| bits.windows(5).all(|five| five.iter().any(|bit| *bit != five[0]));
    let turned = |last: u8| {
        let data = [byte, 0x4B, 0x2D, last];
        let frame = Frame::new(Id::Base(0x155), FrameKind::Data, 4, &data).expect("a frame");
        let encoded = encode(&frame, FdCrc::Iso);
        let end = encoded.crc_delimiter as usize;
        let mut bits: Vec<_> = encoded.bits.iter().collect();
        let before = legal(&bits[end - 20..end]);
        bits[end - 8] = bits[end - 8].toggled();
        (before && legal(&bits[end - 20..end])).then_some(bits)
    };
    (0..=255).find_map(turned).expect("a frame without stuff bits in its CRC")
}

/// Edges at 16 ticks a bit, 20 recessive bits between frames.
struct Line {
    at: u64,
    level: Level,
    edges: Vec<u64>,
}

impl Line {
    fn send(&mut self, bits: &[Level]) {
        self.at += 20 * 16;
        for &bit in bits.iter().chain(&[Level::Recessive]) {
            if bit != self.level {
                self.edges.push(self.at);
                self.level = bit;
            }
            self.at += 16;
        }
        self.at += 20 * 16;
    }
}

#[test]
fn first_frame_decides_and_later_edges_change_nothing() {
    let trial = Trial::draw(SEED, 1, Scene::Clean, Resolution::TicksPerBit(16.0));
    let recording = trial.record();
    let mut detector = CompactDetector::<128>::new();
    detector.begin(0, Logic::High);
    let begin = recording.edges[0].at - 400;
    for edge in &recording.edges {
        detector.push(edge.at - begin);
    }
    let end = recording.edges.last().expect("edges").at - begin;
    assert!(matches!(detector.verdict(), Verdict::Undecided(_)), "the gap behind is not known");
    // The next edge, 500 ticks or 31 bits later.
    detector.push(end + 500);
    let found = detector.verdict();
    assert!(matches!(found, Verdict::Found(_)), "{found:?}");
    // The same frame at a tenth of the rate.
    for edge in &recording.edges {
        detector.push(end + 500 + 10 * (edge.at - begin));
    }
    detector.finish(end + 1_000_000);
    assert_eq!(detector.verdict(), found);
}

/// One and a half percent between two halves of a frame: each period is whole, its CRC is right, but the edges
/// are on no common grid.
#[test]
fn a_frame_that_changes_its_pace_proves_nothing() {
    let frame = Frame::new(Id::Base(0x2A5), FrameKind::Data, 8, &[0x35; 8]).expect("a frame");
    let verdict = |pace: u64| {
        let mut detector = CompactDetector::<128>::new();
        detector.begin(0, Logic::High);
        let (mut at, mut level) = (0, Level::Recessive);
        for (index, bit) in encode(&frame, FdCrc::Iso).bits.iter().enumerate() {
            if bit != level {
                level = bit;
                detector.push(10_000 + at);
            }
            at += if index < 60 { 1000 } else { pace };
        }
        if level == Level::Dominant {
            detector.push(10_000 + at);
        }
        detector.finish(10_000 + at + 20_000);
        detector.verdict()
    };
    assert!(matches!(verdict(1000), Verdict::Found(_)));
    assert!(matches!(verdict(1001), Verdict::Found(_)));
    let changed = verdict(1015);
    assert!(matches!(changed, Verdict::Undecided(_)), "{changed:?}");
}

#[test]
fn memory_is_below_a_kibibyte() {
    let bytes = size_of::<CompactDetector>();
    assert!(bytes <= 640, "{bytes} bytes");
}
