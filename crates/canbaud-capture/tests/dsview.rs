//! DSView sessions made by hand.

mod common;

use canbaud::units::Hertz;
use canbaud_capture::Format;
use common::{Random, archive, naive, read, samples};

fn header(samples: usize) -> String {
    format!(
        "[version]\nversion = 3\n\n[header]\ndriver = DSLogic\ndevice mode = 0\n\
         capturefile = data\ntotal samples = {samples}\ntotal probes = 2\ntotal blocks = 2\n\
         samplerate = 25 MHz\nprobe0 = SDA\nprobe3 = CAN-FD\n"
    )
}

/// One bit per sample, padded to 8 bytes with ones.
fn bits(samples: &[u64]) -> Vec<u8> {
    let mut bytes: Vec<u8> = samples
        .chunks(8)
        .map(|c| c.iter().enumerate().fold(0, |b, (n, s)| b | ((s & 1) as u8) << n))
        .collect();
    if !samples.len().is_multiple_of(8) {
        *bytes.last_mut().unwrap() |= 0xff << (samples.len() % 8);
    }
    bytes.resize(bytes.len().next_multiple_of(8), 0xff);
    bytes
}

#[test]
fn channels_lie_in_members_of_their_own_and_padding_is_ignored() {
    let mut random = Random(0x5eed_0020);
    let a = samples(&mut random, 20_003, 1);
    let b = samples(&mut random, 20_003, 1);
    let header = header(20_003);
    let (a0, a1) = (bits(&a[..16_384]), bits(&a[16_384..]));
    let (b0, b1) = (bits(&b[..16_384]), bits(&b[16_384..]));
    let file = archive(&[
        ("header", header.as_bytes()),
        ("decoders", b"[]"),
        ("L-3/1", &b1),
        ("L-3/0", &b0),
        ("L-0/0", &a0),
        ("L-0/1", &a1),
    ]);
    let (capture, kept, summary) = read(&file).unwrap();
    assert_eq!(capture.format(), Format::DsView);
    assert_eq!(capture.samplerate(), Hertz::new(25_000_000));
    let names: Vec<&str> = capture.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["SDA", "CAN-FD"]);
    assert_eq!(kept.edges(0), naive(&a, 0));
    assert_eq!(kept.edges(1), naive(&b, 0));
    assert_eq!(kept.channels[1][0].end, Some(20_003));
    assert!(summary.notes.is_empty());
}

#[test]
fn what_is_not_read_is_said() {
    let data = [0_u8; 8];
    let open = |text: String, member: &str| {
        read(&archive(&[("header", text.as_bytes()), (member, &data)])).unwrap_err().to_string()
    };
    let v = |n: &str| header(64).replace("version = 3", &format!("version = {n}"));
    assert!(open(v("2"), "L-0/0").starts_with("dsl: version 2 (3 is read"));
    assert!(open(v("1"), "L-0/0").starts_with("dsl: version 1 (3 is read"));
    assert!(open(header(64).replace("mode = 0", "mode = 1"), "L-0/0").contains("oscilloscope"));
    assert!(open(header(64), "O-0/0").contains("no logic data"));
    assert!(open(header(64), "L-0/1").contains("\"L-0/0\": is missing"));
    assert!(open(header(64).replace("25 MHz", "0 Hz"), "L-0/0").contains("samplerate"));
    assert!(
        open(header(64).replace("samples = 64", "samples = x"), "L-0/0").contains("total samples")
    );
}

#[test]
fn fewer_samples_than_stated_are_noted() {
    let header = header(1000);
    let file = archive(&[("header", header.as_bytes()), ("L-0/0", &[0x0f; 8])]);
    let (_, kept, summary) = read(&file).unwrap();
    assert_eq!(kept.channels[0][0].end, Some(64));
    assert_eq!(summary.notes, ["channel 0 has 64 samples, the header says 1000"]);
}
