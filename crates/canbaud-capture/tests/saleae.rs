//! Saleae binary exports and `.logicdata`, made by hand.

mod common;

use canbaud::units::Hertz;
use canbaud::wire::Logic;
use canbaud_capture::{CaptureError, Format, OpenOptions, Signal, WordSize};
use common::{Kept, Random, naive, pack, read, read_damaged, read_with, samples};

/// Bytes of a file, field by field.
#[derive(Default)]
struct File(Vec<u8>);

impl File {
    fn saleae(version: u32, kind: u32) -> Self {
        Self(b"<SALEAE>".to_vec()).u32(version).u32(kind)
    }
    fn u32(mut self, v: u32) -> Self {
        self.0.extend(v.to_le_bytes());
        self
    }
    fn u64(mut self, v: u64) -> Self {
        self.0.extend(v.to_le_bytes());
        self
    }
    fn f64s(mut self, v: &[f64]) -> Self {
        v.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
        self
    }
    fn f32s(mut self, v: &[f32]) -> Self {
        v.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
        self
    }
}

#[test]
fn version_0_digital() {
    let file = File::saleae(0, 0).u32(1).f64s(&[-0.5, 1.5]).u64(2).f64s(&[0.0, 0.000_001_5]);
    let (capture, kept, _) = read(&file.0).unwrap();
    assert_eq!(capture.format(), Format::SaleaeBinary);
    assert_eq!(capture.timebase().ticks(), 1_000_000_000_000);
    assert_eq!(capture.samplerate(), None);
    let stretch = &kept.channels[0][0];
    assert_eq!((stretch.begin, stretch.level), (0, Logic::High));
    assert_eq!(stretch.edges, [500_000_000_000, 500_001_500_000]);
    assert_eq!(stretch.end, Some(2_000_000_000_000));
}

#[test]
fn version_1_digital_has_gaps_between_chunks() {
    let file = File::saleae(1, 0)
        .u64(2)
        .u32(0)
        .f64s(&[500e6, 1.0, 1.000_1])
        .u64(1)
        .f64s(&[1.000_05])
        .u32(1)
        .f64s(&[500e6, 2.0, 2.5])
        .u64(2)
        .f64s(&[2.1, 2.2]);
    let (capture, kept, _) = read(&file.0).unwrap();
    assert_eq!(capture.samplerate(), Hertz::new(500_000_000));
    assert_eq!(capture.resolution_ticks(), 2000);
    let [first, second] = kept.channels[0].as_slice() else { panic!() };
    assert_eq!((first.edges.as_slice(), first.end), ([50_000_000].as_slice(), Some(100_000_000)));
    assert_eq!((second.begin, second.level), (1_000_000_000_000, Logic::High));
    assert_eq!(second.edges, [1_100_000_000_000, 1_200_000_000_000]);
    assert_eq!(second.end, Some(1_500_000_000_000));
}

/// 1 V on 2.5 V, 25 samples each.
fn wave() -> Vec<f32> {
    (0..500).map(|n| if n / 25 % 2 == 0 { 2.5 } else { 3.5 }).collect()
}

#[test]
fn analogue_of_both_versions() {
    let wave = wave();
    let v0 = File::saleae(0, 1).f64s(&[-0.1]).u64(50_000_000).u64(2).u64(500).f32s(&wave);
    let v1 = File::saleae(1, 1)
        .u64(2)
        .f64s(&[0.0, 0.0, 50e6])
        .u64(2)
        .u64(500)
        .f32s(&wave)
        .f64s(&[0.001, 0.001, 50e6])
        .u64(2)
        .u64(500)
        .f32s(&wave);
    let expected: Vec<u64> = (1..20).map(|n| 25 * 16 * n - 8).collect();
    for (file, waveforms) in [(v0, 1), (v1, 2)] {
        let (capture, kept, summary) = read(&file.0).unwrap();
        assert_eq!(capture.samplerate(), Hertz::new(25_000_000));
        assert_eq!(capture.timebase().ticks(), 400_000_000);
        assert_eq!(kept.channels[0].len(), waveforms);
        assert_eq!(kept.channels[0][0].edges, expected);
        assert_eq!(kept.channels[0][0].end, Some(8000));
        if let Some(second) = kept.channels[0].get(1) {
            assert_eq!(second.begin, 400_000);
            assert_eq!(second.edges, expected.iter().map(|t| t + 400_000).collect::<Vec<_>>());
        }
        assert!(matches!(summary.channels[0].signal, Signal::TwoLevels(_)));
    }
}

#[test]
fn damaged_exports_deliver_what_precedes_the_damage() {
    let good = File::saleae(0, 0).u32(0).f64s(&[0.0, 9.0]).u64(4).f64s(&[1.0, 2.0]);
    let (kept, error) = read_damaged(&good.0);
    assert_eq!(error.to_string(), "at byte 60: the file ends too early");
    assert_eq!(kept.edges(0).len(), 2);
    for bad in [1.5, f64::NAN, f64::INFINITY, -1.0, 1e300] {
        let file = File(good.0.clone()).f64s(&[bad, 5.0]);
        let (kept, error) = read_damaged(&file.0);
        assert!(error.to_string().starts_with("at byte 60: an edge at"), "{error}");
        assert_eq!(kept.edges(0).len(), 2);
    }
    let cut = File::saleae(0, 1).f64s(&[0.0]).u64(1000).u64(1).u64(501).f32s(&wave());
    let (kept, error) = read_damaged(&cut.0);
    assert!(error.to_string().contains("before its last sample"), "{error}");
    assert_eq!(kept.edges(0).len(), 19);
}

#[test]
fn impossible_headers_are_refused() {
    for (file, part) in [
        (File::saleae(2, 0), "version 2"),
        (File::saleae(0, 7), "type 7"),
        (File::saleae(0, 0).u32(9).f64s(&[0.0, 1.0]).u64(0), "initial state of 9"),
        (File::saleae(0, 0).u32(1).f64s(&[2.0, 1.0]).u64(0), "no recording"),
        (File::saleae(0, 0).u32(1).f64s(&[f64::NAN, 1.0]).u64(0), "no recording"),
        (File::saleae(1, 0).u64(0), "no recording"),
        (File::saleae(0, 1).f64s(&[0.0]).u64(1000).u64(0).u64(1), "no recording"),
        (File::saleae(0, 1).f64s(&[0.0]).u64(1000).u64(1).u64(u64::MAX), "more samples"),
        (File::saleae(1, 1).u64(u64::MAX), "number of waveforms"),
        (File::saleae(0, 0).u32(1), "ends too early"),
    ] {
        let error = read(&file.0).unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
    }
}

fn logic1(format: Format) -> OpenOptions {
    OpenOptions {
        format: Some(format),
        samplerate: Hertz::new(24_000_000),
        ..OpenOptions::default()
    }
}

#[test]
fn logic_1_words_of_every_size() {
    let mut random = Random(0x5eed_0010);
    for word in WordSize::ALL {
        let bits = 8 * word.bytes() as u32;
        let samples = samples(&mut random, 300_000, bits);
        let bytes = pack(&samples, word.bytes());
        let (capture, kept, _) = read_with(&bytes, &logic1(Format::Logic1Samples(word))).unwrap();
        assert_eq!(capture.samplerate(), Hertz::new(24_000_000));
        for bit in [0, 1, bits / 2, bits - 1] {
            assert_eq!(kept.edges(bit as usize), naive(&samples, bit), "{word:?} bit {bit}");
        }
        // The same as changes, which are recognised.
        let mut changes = Vec::new();
        for (n, sample) in samples.iter().enumerate() {
            if n == 0 || samples[n - 1] != *sample {
                changes.extend((n as u64).to_le_bytes());
                changes.extend(&sample.to_le_bytes()[..word.bytes()]);
            }
        }
        let options = OpenOptions { format: None, ..logic1(Format::Vcd) };
        let (capture, same, _) = read_with(&changes, &options).unwrap();
        assert_eq!(capture.format(), Format::Logic1Changes(word));
        for bit in [0, bits - 1] {
            assert_eq!(same.edges(bit as usize), kept.edges(bit as usize), "{word:?} bit {bit}");
        }
        let error = read(&changes).unwrap_err();
        assert!(matches!(error, CaptureError::NoSamplerate(f) if f == Format::Logic1Changes(word)));
    }
}

#[test]
fn logic_1_words_are_never_guessed() {
    let mut random = Random(0x5eed_0011);
    let bytes = pack(&samples(&mut random, 90_000, 8), 1);
    let error = read(&bytes).unwrap_err();
    assert!(matches!(error, CaptureError::Unrecognised(_)), "{error}");
    assert!(error.to_string().contains("logic1-8"), "{error}");
}

#[test]
fn logic_1_changes_that_do_not_rise_are_damage() {
    let mut bytes = Vec::new();
    for (at, word) in [(0_u64, 1_u8), (5, 0), (9, 1), (9, 0)] {
        bytes.extend(at.to_le_bytes());
        bytes.push(word);
    }
    let options = logic1(Format::Logic1Changes(WordSize::Bits8));
    let mut capture = canbaud_capture::from_reader(std::io::Cursor::new(bytes), &options).unwrap();
    let mut kept = Kept::default();
    let error = capture.stream(&mut kept).unwrap_err();
    assert_eq!(error.to_string(), "at byte 27: sample number 9 is not above 9");
    assert_eq!(kept.edges(0), [5, 9]);
}

/// A number as `.logicdata` writes it.
fn number(n: u64) -> Vec<u8> {
    let len = n.to_le_bytes().iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
    let mut bytes = vec![len as u8];
    bytes.extend(&n.to_le_bytes()[..len]);
    bytes
}

fn vector(count: usize, raw: &[u8]) -> Vec<u8> {
    let mut bytes = [count as u64, 0, count as u64, 0, count as u64].map(number).concat();
    bytes.extend(raw);
    bytes
}

fn record(position: u64, start: u64, before: i64, kind: u32) -> Vec<u8> {
    let mut bytes = position.to_le_bytes().to_vec();
    bytes.extend(start.to_le_bytes());
    bytes.extend(before.to_le_bytes());
    bytes.extend(kind.to_le_bytes());
    bytes.extend([0xde, 0xad, 0xbe, 0xef]);
    bytes
}

fn logicdata(version: u64, title: &str) -> Vec<u8> {
    let mut file = vec![0x7f];
    file.extend(number(version));
    file.extend(number(title.len() as u64));
    file.extend(title.as_bytes());
    for n in [8_000_000, 0, 1_000_000, 1, 0] {
        file.extend(number(n));
    }
    file.extend(number(3));
    file.extend(b"CAN");
    file.extend([0, 0, 1, 7, 0, 0, 0]);
    // High for 300, low for 16, high for 16, low for 70 000, high for 20, low for 500.
    file.extend(vector(3, &[16, 0x80 | 16, 0x80 | 20]));
    file.extend(vector(2, &[44, 0x81, 244, 1]));
    file.extend(vector(1, &70_000_u32.to_le_bytes()));
    file.extend(vector(0, &[]));
    let index = [
        record(0, 0, -1, 2),
        record(300, 0, 0, 1),
        record(316, 1, -1, 1),
        record(332, 0, 1, 3),
        record(70_332, 2, 0, 1),
        record(70_352, 1, 2, 2),
    ];
    file.extend(vector(6, &index.concat()));
    file.extend([0, 1, 1, 0]);
    file
}

#[test]
fn logicdata_runs_are_walked_by_their_index() {
    let (capture, kept, _) = read(&logicdata(5, "Data save")).unwrap();
    assert_eq!(capture.format(), Format::LogicData);
    assert_eq!(capture.samplerate(), Hertz::new(8_000_000));
    assert_eq!(capture.channels()[0].name, "CAN");
    assert_eq!(kept.channels[0][0].level, Logic::High);
    assert_eq!(kept.edges(0), [300, 316, 332, 70_332, 70_352]);
    assert_eq!(kept.channels[0][0].end, Some(70_852));
}

#[test]
fn other_logicdata_is_refused() {
    let error = read(&logicdata(0x13, "Data save2")).unwrap_err();
    assert!(error.to_string().contains("version 19 (\"Data save2\")"), "{error}");
    let file = logicdata(5, "Data save");
    let error = read(&file[..file.len() - 60]).unwrap_err();
    assert!(error.to_string().contains("no channel with edges"), "{error}");
}
