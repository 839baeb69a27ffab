//! sigrok sessions made by hand.

mod common;

use canbaud::units::Hertz;
use canbaud::wire::Logic;
use canbaud_capture::{CaptureError, ChannelKind, OpenOptions, Place, Signal};
use common::{Random, archive, archive_with, naive, pack, read, read_damaged, read_with, samples};

const V1: &str = "[global]\nsigrok version = 0.2.0\n[device 1]\ndriver = fx2lafw\n\
    capturefile = logic-1\nunitsize = 1\ntotal probes = 8\nsamplerate = 500 kHz\nprobe3 = RX\n";

fn metadata(unit: usize, probes: &str) -> String {
    format!(
        "[global]\r\nsigrok version=0.6.0\r\n\r\n[device 1]\r\ncapturefile=logic-1\r\n\
         total probes=16\r\nsamplerate=100 MHz\r\ntotal analog=0\r\n{probes}unitsize={unit}\r\n"
    )
}

#[test]
fn version_1_with_the_data_before_the_metadata() {
    let logic = [0b100, 0b100, 0, 0b011, 0b111, 0b100];
    let file = archive(&[("logic-1", &logic), ("metadata", V1.as_bytes()), ("version", b"1")]);
    let (capture, kept, summary) = read(&file).unwrap();
    assert_eq!(capture.samplerate(), Hertz::new(500_000));
    assert_eq!(capture.timebase().ticks(), 500_000);
    assert_eq!(capture.channels().len(), 1);
    assert_eq!(capture.channels()[0].name, "RX");
    assert_eq!(kept.channels[0][0].level, Logic::High);
    assert_eq!(kept.channels[0][0].begin, 0);
    assert_eq!(kept.edges(0), [2, 4]);
    assert_eq!(kept.channels[0][0].end, Some(6));
    assert_eq!(summary.channels[0].signal, Signal::Digital);
    assert!(!summary.stopped);
}

#[test]
fn chunks_are_joined_in_numeric_order_and_edges_at_their_seams_are_kept() {
    let chunks: Vec<(String, Vec<u8>)> =
        (1..=12).map(|n| (format!("logic-1-{n}"), vec![n % 2; 5])).collect();
    let mut members: Vec<(&str, &[u8])> =
        chunks.iter().rev().map(|(n, c)| (n.as_str(), c.as_slice())).collect();
    let metadata = metadata(1, "probe1=A\r\n");
    members.push(("metadata", metadata.as_bytes()));
    members.push(("version", b"2"));
    let (_, kept, _) = read(&archive(&members)).unwrap();
    assert_eq!(kept.edges(0), (1..12).map(|n| 5 * n).collect::<Vec<_>>());
}

#[test]
fn every_unit_size_gives_the_edges_of_a_plain_loop() {
    let mut random = Random(0x5eed_0001);
    for unit in 1..=8_usize {
        let bits = 8 * unit as u32;
        let samples = samples(&mut random, 70_001, bits);
        let bytes = pack(&samples, unit);
        // Chunks that no sample fits into evenly.
        let chunks: Vec<&[u8]> = bytes.chunks(65_537).collect();
        let names: Vec<String> = (1..=chunks.len()).map(|n| format!("logic-1-{n}")).collect();
        let metadata = metadata(unit, "");
        let metadata = metadata.replace("total probes=16", &format!("total probes={bits}"));
        let mut members: Vec<(&str, &[u8])> =
            vec![("version", b"2"), ("metadata", metadata.as_bytes())];
        members.extend(names.iter().map(String::as_str).zip(chunks));
        let (capture, kept, _) = read(&archive(&members)).unwrap();
        assert_eq!(capture.channels().len(), bits as usize);
        for bit in 0..bits {
            let channel = bit as usize;
            assert_eq!(kept.edges(channel), naive(&samples, bit), "unit {unit} bit {bit}");
            assert_eq!(kept.channels[channel][0].end, Some(70_001));
        }
        assert_eq!(capture.channels()[3].name, "D3");
    }
}

#[test]
fn only_selected_channels_are_streamed_and_streams_can_be_repeated() {
    let logic = [0, 3, 1, 2];
    let metadata = metadata(1, "probe1=A\r\nprobe2=B\r\n");
    let file =
        archive(&[("version", b"2"), ("metadata", metadata.as_bytes()), ("logic-1-1", &logic)]);
    let (mut capture, first, _) = read(&file).unwrap();
    assert_eq!(first.edges(0), [1, 3]);
    capture.select(&[1, 99]);
    let mut second = common::Kept::default();
    let summary = capture.stream(&mut second).unwrap();
    assert!(second.channels[0].is_empty());
    assert_eq!(second.edges(1), [1, 2, 3]);
    assert_eq!(summary.channels[0].signal, Signal::NotRead);
    assert_eq!(summary.channels[1].edges, 3);
}

#[test]
fn a_sink_can_stop_the_stream() {
    let logic: Vec<u8> = (0..100_000_u32).map(|n| (n % 2) as u8).collect();
    let metadata = metadata(1, "probe1=A\r\n");
    let file =
        archive(&[("version", b"2"), ("metadata", metadata.as_bytes()), ("logic-1-1", &logic)]);
    let (mut capture, whole, _) = read(&file).unwrap();
    assert!(whole.largest_block >= 4096, "{}", whole.largest_block);
    let mut kept = common::Kept { stop_after: Some(1), ..Default::default() };
    let summary = capture.stream(&mut kept).unwrap();
    assert!(summary.stopped);
    assert_eq!(kept.calls, 1);
}

#[test]
fn bytes_that_fill_no_sample_are_noted() {
    let metadata = metadata(2, "probe1=A\r\n");
    let file = archive(&[
        ("version", b"2"),
        ("metadata", metadata.as_bytes()),
        ("logic-1-1", &[0, 0, 1]),
        ("logic-1-2", &[0, 0, 0, 9]),
    ]);
    let (_, kept, summary) = read(&file).unwrap();
    assert_eq!(kept.edges(0), [1, 2]);
    assert_eq!(kept.channels[0][0].end, Some(3));
    assert!(summary.notes[0].contains("1 bytes"), "{:?}", summary.notes);
}

#[test]
fn a_missing_sample_rate_can_be_given() {
    let metadata = V1.replace("samplerate = 500 kHz\n", "");
    let file =
        archive(&[("version", b"1"), ("metadata", metadata.as_bytes()), ("logic-1", &[0, 4])]);
    let error = read(&file).unwrap_err();
    assert!(matches!(error, CaptureError::NoSamplerate(_)), "{error}");
    let options = OpenOptions { samplerate: Hertz::new(4_000_000), ..OpenOptions::default() };
    let (capture, kept, _) = read_with(&file, &options).unwrap();
    assert_eq!(capture.samplerate(), Hertz::new(4_000_000));
    assert_eq!(kept.edges(0), [1]);
}

#[test]
fn bad_metadata_is_named() {
    let data: (&str, &[u8]) = ("logic-1", &[0, 4]);
    for (from, to, part) in [
        ("500 kHz", "0", "samplerate \"0\""),
        ("500 kHz", "99999999999999999999 GHz", "samplerate"),
        ("500 kHz", "fast", "samplerate \"fast\""),
        ("unitsize = 1", "unitsize = 0", "unitsize \"0\""),
        ("unitsize = 1", "unitsize = 4000000000", "unitsize"),
        ("[device 1]", "[device 2]", "[device 1]"),
    ] {
        let text = V1.replace(from, to);
        let error = read(&archive(&[("version", b"1"), ("metadata", text.as_bytes()), data]));
        let error = error.unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("metadata"), "{to}: {error}");
    }
    let metadata = ("metadata", V1.as_bytes());
    let error = read(&archive(&[("version", b"3"), metadata, data])).unwrap_err();
    assert_eq!(error.to_string(), "sr: version \"3\" (1 and 2 are read)");
    let error = read(&archive(&[("version", b"2"), metadata])).unwrap_err();
    assert_eq!(error.to_string(), "member \"logic-1\": is missing from the archive");
    let gap: &[(&str, &[u8])] =
        &[("version", b"2"), metadata, ("logic-1-1", &[0]), ("logic-1-3", &[0])];
    let error = read(&archive(gap)).unwrap_err();
    assert_eq!(error.to_string(), "member \"logic-1-2\": is missing from the archive");
}

#[test]
fn edges_before_the_damage_are_delivered() {
    let logic: Vec<u8> = (0..3_000_000_u32).map(|n| (n.wrapping_mul(n) >> 9) as u8).collect();
    let metadata = metadata(1, "probe1=A\r\n");
    let members: [(&str, &[u8]); 3] =
        [("version", b"2"), ("metadata", metadata.as_bytes()), ("logic-1-1", &logic)];
    let good = archive_with(&members, zip::CompressionMethod::Stored);
    let whole = read(&good).unwrap().1.edges(0);

    // One byte changed: noticed by the CRC-32 at the end of the member.
    let mut bad = good.clone();
    let at = bad.len() / 2;
    bad[at] ^= 1;
    let (kept, error) = read_damaged(&bad);
    assert_eq!(error.to_string(), "member \"logic-1-1\" at byte 3000000: CRC-32 does not match");
    assert!(kept.edges(0).len().abs_diff(whole.len()) <= 2);
    assert!(kept.channels[0][0].end.is_some());

    // Deflated data that makes no sense from the middle on.
    let mut bad = archive(&members);
    let at = bad.len() / 2;
    bad[at..at + 400].fill(0xff);
    let (kept, error) = read_damaged(&bad);
    assert!(
        matches!(&error, CaptureError::Damaged { place: Place::MemberByte(name, at), .. }
        if name == "logic-1-1" && *at > 0),
        "{error}"
    );
    // The damage is in the middle; how long it passes for good data depends on the bits.
    let same = kept.edges(0).iter().zip(&whole).take_while(|(a, b)| a == b).count();
    assert!(same > whole.len() / 3, "{same} of {}", whole.len());
}

#[test]
fn a_cut_archive_says_so() {
    let file = archive(&[("version", b"1"), ("metadata", V1.as_bytes()), ("logic-1", &[0; 99])]);
    let error = read(&file[..file.len() - 40]).unwrap_err();
    assert!(error.to_string().contains("the file is cut short"), "{error}");
}

#[test]
fn a_zip64_directory_end_is_followed() {
    let good = archive(&[("version", b"1"), ("metadata", V1.as_bytes()), ("logic-1", &[0, 4])]);
    let (members, end) = good.split_at(good.len() - 22);
    let field = |at: usize| u32::from_le_bytes([end[at], end[at + 1], end[at + 2], end[at + 3]]);
    let mut file = members.to_vec();
    let end64_at = file.len() as u64;
    file.extend(b"PK\x06\x06");
    file.extend(44_u64.to_le_bytes());
    file.extend([45, 0, 45, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    for n in [3, 3, u64::from(field(12)), u64::from(field(16))] {
        file.extend(n.to_le_bytes());
    }
    file.extend(b"PK\x06\x07\0\0\0\0");
    file.extend(end64_at.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    file.extend(b"PK\x05\x06\0\0\0\0");
    file.extend([0xff; 12]);
    file.extend([0, 0]);
    assert_eq!(read(&file).unwrap().1.edges(0), [1]);
    let at = end64_at as usize;
    file[at] = b'?';
    let error = read(&file).unwrap_err();
    assert_eq!(error.to_string(), format!("at byte {at}: no zip64 directory end here"));
}

#[test]
fn a_zip_bomb_is_refused_unless_asked_for() {
    let zeros = vec![0; 20_000_000];
    let file = archive(&[("version", b"1"), ("metadata", V1.as_bytes()), ("logic-1", &zeros)]);
    assert!(file.len() < 40_000);
    let options = OpenOptions { max_inflated: 10_000_000, ..OpenOptions::default() };
    let error = read_with(&file, &options).unwrap_err();
    assert!(
        matches!(error, CaptureError::Limit { value: 20_000_000.., max: 10_000_000, .. }),
        "{error}"
    );
    let (_, kept, _) = read(&file).unwrap();
    assert_eq!(kept.channels[0][0].end, Some(20_000_000));

    // A directory that says 1 byte where there are 20 million: reading ends at the first too many.
    let mut lying = file;
    let sizes: Vec<usize> =
        (0..lying.len() - 3).filter(|&n| lying[n..n + 4] == 20_000_000_u32.to_le_bytes()).collect();
    for at in sizes {
        lying[at..at + 4].copy_from_slice(&1_u32.to_le_bytes());
    }
    let (kept, error) = read_damaged(&lying);
    assert!(error.to_string().contains("another size"), "{error}");
    assert!(kept.edges(0).is_empty());
}

fn volts(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

const WAVES: &str = "[device 1]\nsamplerate=10 MHz\ntotal probes=0\ntotal analog=2\n\
    analog1=CAN_H\nanalog2=CAN_L\n";

/// A bus at 10 MS/s that is idle but for one frame-like burst of 20 edges, 20 samples apart, with
/// rises of one sample that cross at a known share of it.
fn waves(count: usize, burst: usize) -> (Vec<f32>, Vec<f32>) {
    let mut random = Random(0x5eed_0002);
    let mut wire = |sign: f64, swing: f64| -> Vec<f32> {
        (0..count)
            .map(|n| {
                let bit = n.checked_sub(burst).map_or(20, |n| n / 20);
                let dominant = bit < 20 && bit.is_multiple_of(2);
                let level = if dominant { sign * swing } else { 0.0 };
                (2.5 + level + 0.008 * random.normal()) as f32
            })
            .collect()
    };
    (wire(1.0, 1.0), wire(-1.0, 0.8))
}

#[test]
fn a_few_bits_in_a_long_idle_recording_are_found_on_both_wires_and_their_difference() {
    let (high, low) = waves(1_000_000, 700_000);
    let (h, l) = (volts(&high), volts(&low));
    let (h1, h2) = h.split_at(1_000_002);
    let file = archive(&[
        ("version", b"2"),
        ("metadata", WAVES.as_bytes()),
        ("analog-1-1-1", h1),
        ("analog-1-1-2", h2),
        ("analog-1-2-1", &l),
    ]);
    let (capture, kept, summary) = read(&file).unwrap();
    assert_eq!(capture.channels()[2].name, "CAN_H-CAN_L");
    assert_eq!(capture.channels()[2].kind, ChannelKind::Difference(0, 1));
    assert_eq!(capture.timebase().ticks(), 160_000_000);
    assert_eq!(capture.samplerate(), Hertz::new(10_000_000));
    for (channel, begin, low, high) in
        [(0, Logic::Low, 2.5, 3.5), (1, Logic::High, 1.7, 2.5), (2, Logic::Low, 0.0, 1.8)]
    {
        let Signal::TwoLevels(levels) = summary.channels[channel].signal else {
            panic!("{channel}: {:?}", summary.channels[channel]);
        };
        assert!((levels.low - low).abs() < 0.02 && (levels.high - high).abs() < 0.02, "{levels:?}");
        assert_eq!(kept.channels[channel][0].level, begin);
        let edges = kept.edges(channel);
        assert_eq!(edges.len(), 20, "{channel}");
        for (n, &edge) in edges.iter().enumerate() {
            // Midway between the last sample of the old and the first of the new level.
            let expected = (700_000 + 20 * n as u64) * 16 - 8;
            assert!(edge.abs_diff(expected) <= 1, "{channel}: {edge} for {expected}");
        }
        assert_eq!(kept.channels[channel][0].end, Some(16_000_000));
    }
}

fn one_wave(values: &[f32]) -> (common::Kept, canbaud_capture::Summary) {
    let metadata = WAVES.replace("analog2=CAN_L\n", "");
    let file = archive(&[
        ("version", b"2"),
        ("metadata", metadata.as_bytes()),
        ("analog-1-1-1", &volts(values)),
    ]);
    let (_, kept, summary) = read(&file).unwrap();
    (kept, summary)
}

#[test]
fn spikes_clipping_and_values_that_are_no_numbers_do_not_hide_the_bus() {
    let (clean, _) = waves(200_000, 100_000);
    let expected = one_wave(&clean).0.edges(0);
    assert_eq!(expected.len(), 20);
    let mut wave = clean.clone();
    wave[50_000..50_003].fill(12.0);
    wave[150_000..150_002].fill(-9.0);
    wave[160_000] = f32::NAN;
    wave[160_001] = f32::INFINITY;
    wave[160_002] = f32::MAX;
    let (kept, summary) = one_wave(&wave);
    let edges = kept.edges(0);
    let bus: Vec<u64> =
        edges.into_iter().filter(|t| (99_000 * 16..101_000 * 16).contains(t)).collect();
    assert_eq!(bus, expected, "{:?}", summary.channels[0]);
    // The supply comes up first.
    let mut wave = clean;
    wave[..40_000].fill(0.0);
    let (kept, _) = one_wave(&wave);
    let bus: Vec<u64> = kept.edges(0).into_iter().filter(|t| *t > 90_000 * 16).collect();
    assert_eq!(bus, expected);
}

#[test]
fn noise_alone_has_no_edges_and_says_so() {
    let mut random = Random(0x5eed_0003);
    let noise: Vec<f32> = (0..100_000).map(|_| (2.5 + 0.008 * random.normal()) as f32).collect();
    let sine: Vec<f32> = (0..100_000).map(|n| (f64::from(n) * 0.01).sin() as f32).collect();
    for wave in [noise, sine, vec![2.5; 1000], vec![f32::NAN; 1000]] {
        let (kept, summary) = one_wave(&wave);
        assert_eq!(summary.channels[0].signal, Signal::Flat);
        assert!(kept.channels.is_empty());
    }
}

#[test]
fn a_threshold_can_be_given() {
    let wave: Vec<f32> = (0..1000).map(|n| (n % 100) as f32 / 100.0).collect();
    let metadata = WAVES.replace("analog2=CAN_L\n", "");
    let file = archive(&[
        ("version", b"2"),
        ("metadata", metadata.as_bytes()),
        ("analog-1-1-1", &volts(&wave)),
    ]);
    let threshold = canbaud_capture::Threshold { volts: 0.505, hysteresis: 0.1 };
    let options = OpenOptions { threshold: Some(threshold), ..OpenOptions::default() };
    let (_, kept, _) = read_with(&file, &options).unwrap();
    // 0.505 V lies midway between samples 50 and 51; the fall is one sample long.
    assert_eq!(kept.edges(0)[..2], [50 * 16 + 8, 99 * 16 + 8]);
    assert_eq!(kept.edges(0).len(), 19);
}
