//! Files that are no captures, and captures with the wrong name.

mod common;

use canbaud::units::Hertz;
use canbaud_capture::{CaptureError, Format, OpenOptions, Signal, open};
use common::{archive, read, read_damaged, read_with};

#[test]
fn every_failure_is_one_clear_line() {
    let directory = tempfile::tempdir().unwrap();
    let options = OpenOptions::default();
    let at = |name: &str, content: &[u8]| {
        let path = directory.path().join(name);
        std::fs::write(&path, content).unwrap();
        open(&path, &options).unwrap_err()
    };
    assert!(matches!(open(directory.path(), &options), Err(CaptureError::Directory)));
    let missing = open(&directory.path().join("none.sr"), &options).unwrap_err();
    assert!(missing.to_string().starts_with("cannot open: "), "{missing}");
    assert!(matches!(at("empty.sr", b""), CaptureError::Empty));
    for (name, content) in [
        ("noise.sr", b"\x00\x01\x02\xff\xfe noise".as_slice()),
        ("text.vcd", b"hello world\nthis is no capture\n"),
        ("picture.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"),
        ("zip.sr", &archive(&[("readme", b"no capture")])),
        ("cut.sr", b"PK\x03\x04"),
        ("one.csv", b"\n"),
        ("zero.bin", &[0; 100_000]),
    ] {
        let error = at(name, content);
        let text = error.to_string();
        assert!(!text.is_empty() && text.lines().count() == 1 && text.is_ascii(), "{name}: {text}");
    }
}

#[test]
fn captures_can_move_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<canbaud_capture::Capture>();
    is_send::<CaptureError>();
}

#[test]
fn the_name_does_not_matter() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("capture.sr");
    let text = "$timescale 1 ns $end $var wire 1 ! a $end $enddefinitions $end #0 1! #5 0!";
    std::fs::write(&path, text).unwrap();
    let capture = open(&path, &OpenOptions::default()).unwrap();
    assert_eq!(capture.format(), Format::Vcd);
}

#[test]
fn a_format_can_be_forced_and_is_then_checked() {
    for format in Format::ALL {
        let options = OpenOptions {
            format: Some(format),
            samplerate: Hertz::new(1_000_000),
            ..OpenOptions::default()
        };
        let result = read_with(b"this is certainly nothing like it", &options);
        match format {
            // Any bytes are samples.
            Format::Logic1Samples(_) => assert!(result.is_ok()),
            // And so few may pass for changes.
            Format::Logic1Changes(_) => {}
            _ => assert!(result.is_err(), "{format}"),
        }
    }
}

#[test]
fn format_names_are_read_back() {
    for format in Format::ALL {
        assert_eq!(format.to_string().parse(), Ok(format));
    }
    let error = "excel".parse::<Format>().unwrap_err();
    assert!(
        error.to_string().contains("\"excel\"") && error.to_string().contains("logic1-changes-8")
    );
}

/// 100 samples of 8 high and 12 low ones in turn, raw 5000 and -3000, 16 bits big-endian.
fn isf(preamble: &str) -> Vec<u8> {
    let mut file = format!("{preamble}:CURVE #3200").into_bytes();
    for n in 0..100 {
        let raw: i16 = if n % 20 < 8 { 5000 } else { -3000 };
        file.extend(raw.to_be_bytes());
    }
    file
}

#[test]
fn tektronix_isf_in_long_and_short_form() {
    for preamble in [
        ":WFMPRE:BYT_NR 2;BIT_NR 16;ENCDG BIN;BN_FMT RI;BYT_OR MSB;NR_PT 100;\
         WFID \"Ch1, DC coupling\";XINCR 20.0E-9;XZERO -403E-6;YMULT 0.5E-3;YOFF 1000;YZERO 0.5;",
        ":WFMO:BYT_N 2;BN_F RI;BYT_O MSB;WFI \"Ch1, DC\";XIN 2.0E-8;YMU 5.0E-4;YOF 1.0E3;YZE 0.5;",
    ] {
        let (capture, kept, summary) = read(&isf(preamble)).unwrap();
        assert_eq!(capture.format(), Format::TekIsf);
        assert_eq!(capture.channels()[0].name, "Ch1");
        assert_eq!(capture.samplerate(), Hertz::new(50_000_000));
        let Signal::TwoLevels(levels) = summary.channels[0].signal else { panic!("flat") };
        // (5000 - 1000) * 0.5 mV + 0.5 V and (-3000 - 1000) * 0.5 mV + 0.5 V
        assert!((levels.high - 2.5).abs() < 0.01 && (levels.low + 1.5).abs() < 0.01, "{levels:?}");
        let edges: Vec<u64> =
            (0..5).flat_map(|n| [20 * n, 20 * n + 8]).skip(1).map(|n| 16 * n - 8).collect();
        for (edge, expected) in kept.edges(0).iter().zip(&edges) {
            assert!(edge.abs_diff(*expected) <= 1, "{edge} {expected}");
        }
        assert_eq!(kept.edges(0).len(), edges.len());
    }
    let file = isf(":WFMPRE:BYT_NR 2;XINCR 1E-9;");
    let (_, error) = read_damaged(&file[..file.len() - 40]);
    assert!(error.to_string().contains("ends 40 bytes before its last sample"), "{error}");
    for (preamble, part) in [
        (":WFMPRE:BYT_NR 4;XINCR 1E-9;", "BYT_NR"),
        (":WFMPRE:BYT_NR 2;XINCR 0;", "XINCR"),
        (":WFMPRE:BYT_NR 2;", "XINCR"),
    ] {
        let error = read(&isf(preamble)).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
}
