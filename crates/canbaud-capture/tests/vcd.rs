//! Value change dumps made by hand.

mod common;

use canbaud::units::Hertz;
use canbaud::wire::Logic;
use canbaud_capture::{ChannelKind, Signal};
use common::{Kept, read, read_damaged};

/// A dump with these declarations and changes.
fn dump(timescale: &str, declarations: &str, changes: &str) -> String {
    format!(
        "$date today $end $timescale {timescale} $end\n{declarations}\n$enddefinitions $end\n{changes}"
    )
}

fn edges(text: &str) -> Kept {
    read(text.as_bytes()).unwrap().1
}

#[test]
fn stamps_and_changes_share_a_line_and_identifiers_are_any_printable_text() {
    let text = dump(
        "10 ns",
        "$scope module libsigrok $end $var wire 1 ! RX $end $var wire 1 \" TX $end\n\
         $var wire 1 # A $end $var wire 1 $ B $end $var wire 1 10 C $end $upscope $end",
        "#0 1! 0\" 1# 0$ 110\n#5 0! 1$ 010\n#7\n1!\n#9 0# #12",
    );
    let (capture, kept, _) = read(text.as_bytes()).unwrap();
    let names: Vec<&str> = capture.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["RX", "TX", "A", "B", "C"]);
    assert_eq!(capture.timebase().ticks(), 100_000_000);
    assert_eq!(kept.edges(0), [5, 7]);
    assert_eq!(kept.channels[0][0].level, Logic::High);
    assert_eq!(kept.channels[1][0].edges, []);
    assert_eq!(kept.edges(2), [9]);
    assert_eq!(kept.edges(3), [5]);
    assert_eq!(kept.edges(4), [5]);
    assert!(kept.channels.iter().all(|c| c[0].end == Some(12)));
}

#[test]
fn two_changes_on_one_tick_cancel_out_also_across_blocks() {
    let text = dump("1 ns", "$var wire 1 ! a $end", "#0 0! 1! #5 0! 1! #6 0! #6 1! #8 0!");
    let kept = edges(&text);
    assert_eq!(kept.channels[0][0].level, Logic::High);
    assert_eq!(kept.edges(0), [8]);
    // A glitch on the tick of the edge that a block ends with.
    let mut changes = String::from("#0 0! ");
    for n in 1..20_000 {
        changes.push_str(&format!("#{n} {0}! {1}! {0}! ", n % 2, 1 - n % 2));
    }
    let kept = edges(&dump("1 ns", "$var wire 1 ! a $end", &changes));
    assert_eq!(kept.edges(0), (1..20_000).collect::<Vec<_>>());
}

#[test]
fn unknown_values_end_the_recording_until_the_next_level() {
    let text =
        dump("1us", "$var wire 1 ! a $end", "#0 x! #3 1! #5 0! #9 z! #12 z! #20 0! #22 1! #30");
    let kept = edges(&text);
    let stretches = &kept.channels[0];
    assert_eq!(stretches.len(), 2);
    assert_eq!(
        (stretches[0].begin, stretches[0].level, stretches[0].end),
        (3, Logic::High, Some(9))
    );
    assert_eq!(stretches[0].edges, [5]);
    assert_eq!(
        (stretches[1].begin, stretches[1].level, stretches[1].end),
        (20, Logic::Low, Some(30))
    );
    assert_eq!(stretches[1].edges, [22]);
}

#[test]
fn vectors_are_taken_apart_and_short_ones_filled() {
    let text = dump(
        "1ps",
        "$var reg 4 & data [3:0] $end $comment one $end",
        "$dumpvars b0 & $end #10 b101 & #20 b1 & #30 bx & #40 b1000 &",
    );
    let (capture, kept, _) = read(text.as_bytes()).unwrap();
    let names: Vec<&str> = capture.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["data[3]", "data[2]", "data[1]", "data[0]"]);
    assert_eq!(kept.edges(0), []);
    assert_eq!(kept.edges(1), [10, 20]);
    assert_eq!(kept.edges(3), [10]);
    assert_eq!(
        kept.channels[0].iter().map(|s| s.level).collect::<Vec<_>>(),
        [Logic::Low, Logic::High]
    );
}

#[test]
fn the_rate_in_the_comment_tells_the_resolution() {
    let text = dump(
        "100 ps",
        "$comment\n  Acquisition with 1/8 channels at 24 MHz\n$end $var wire 1 ! a $end",
        "#0 1! #501667 0! #600000",
    );
    let (capture, kept, _) = read(text.as_bytes()).unwrap();
    assert_eq!(capture.samplerate(), Hertz::new(24_000_000));
    assert_eq!(capture.resolution_ticks(), 417);
    assert_eq!(kept.edges(0), [501_667]);
}

#[test]
fn every_timescale() {
    for (text, ticks, seconds) in [
        ("1 s", 1, 1),
        ("10s", 1, 10),
        ("100 s", 1, 100),
        ("1 ms", 1_000, 1),
        ("100 us", 10_000, 1),
        ("1 fs", 1_000_000_000_000_000, 1),
        ("100 fs", 10_000_000_000_000, 1),
    ] {
        let capture = read(dump(text, "$var wire 1 ! a $end", "#0 1!").as_bytes()).unwrap().0;
        let timebase = (capture.timebase().ticks(), capture.timebase().seconds());
        assert_eq!(timebase, (ticks, seconds), "{text}");
    }
    for text in ["2 ns", "1 as", "99999999999999999999 s", "ns", "", "-1 ns", "1000 s"] {
        let error = read(dump(text, "$var wire 1 ! a $end", "").as_bytes()).unwrap_err();
        assert!(error.to_string().contains("timescale"), "{text}: {error}");
    }
}

#[test]
fn voltages_are_sliced_between_samples() {
    let mut changes = String::new();
    for n in 0..40 {
        let volts = if n % 2 == 0 { 2.5 } else { 3.5 };
        changes.push_str(&format!("#{} r{volts} ) r{} * ", 1000 * n, 5.0 - volts));
    }
    let text = dump(
        "1 ns",
        "$comment Acquisition with 2/2 channels at 10 MHz $end\n\
         $var real 64 ) CANH $end $var real 64 * CANL $end",
        &changes,
    );
    let (capture, kept, summary) = read(text.as_bytes()).unwrap();
    assert_eq!(capture.channels()[2].kind, ChannelKind::Difference(0, 1));
    for channel in 0..3 {
        // The value held until one sample period (100 ticks) before the stamp.
        assert_eq!(kept.edges(channel), (1..40).map(|n| 1000 * n - 50).collect::<Vec<_>>());
        assert!(matches!(summary.channels[channel].signal, Signal::TwoLevels(_)));
    }
}

#[test]
fn damage_is_named_by_its_byte_and_what_precedes_it_is_delivered() {
    let good = dump("1 ns", "$var wire 1 ! a $end", "#0 0! #5 1! #9 0! ");
    for (bad, part) in [
        ("#7 1!", "time runs backwards: #7 after #9"),
        ("#99999999999999999999 1!", "no number of 64 bits"),
        ("hello", "\"hello\" is no value change"),
        ("#", "no number of 64 bits"),
        ("$comment never ends", "has no $end"),
        ("rabc !", "no number"),
    ] {
        let text = format!("{good}{bad}");
        let (kept, error) = read_damaged(text.as_bytes());
        assert!(error.to_string().contains(part), "{bad}: {error}");
        assert!(
            error.to_string().starts_with(&format!("at byte {}", good.len())),
            "{bad}: {error}"
        );
        assert_eq!(kept.edges(0), [5, 9], "{bad}");
        assert_eq!(kept.channels[0][0].end, Some(9));
    }
}

#[test]
fn bad_declarations_are_refused() {
    let long = format!("$timescale 1 ns $end $var wire 1 {} a $end", "!".repeat(100_000));
    for (text, part) in [
        ("$timescale 1 ns $end", "before $enddefinitions"),
        ("$timescale 1 ns", "has no $end"),
        ("$timescale 1 ns $end $enddefinitions $end", "no wire"),
        ("$var wire 1 ! a $end $enddefinitions $end #0 1!", "no $timescale"),
        ("$timescale 1 ns $end $var wire $end", "$var without"),
        ("$timescale 1 ns $end $var wire -3 ! a $end", "width"),
        ("$timescale 1 ns $end junk", "outside"),
        (long.as_str(), "longer than 65536"),
    ] {
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
        assert_eq!(error.lines().count(), 1);
    }
}

#[test]
fn what_carries_no_level_is_skipped() {
    let text = dump(
        "1 ns",
        "$var parameter 32 p width $end $var wire 1 ! a $end $var wire 99 w wide $end $attrbegin x $end",
        "#0 b1010 p b1 w 1? sIDLE s 1! $comment #4 0! $end #6 0!",
    );
    assert_eq!(edges(&text).edges(0), [6]);
}
