use super::*;
use crate::report::samples::{classic, conflict, fd, silent, undecided};

fn plain(channels: &[ChannelReport]) -> String {
    render(None, channels, Detail::Full, None, Paint::Plain)
}

#[test]
fn first_line_is_the_verdict_in_plain_words() {
    let first = |report| plain(&[report]).lines().next().unwrap().to_owned();
    assert_eq!(first(classic()), "125 kbit/s — proven by 286 frames");
    assert_eq!(first(fd()), "500 kbit/s, CAN FD data 2 Mbit/s — proven by 1,000 frames");
    assert_eq!(
        first(undecided()),
        "undecided — no complete frame between two idle stretches: capture 3 ms more"
    );
    assert_eq!(first(silent()), "no traffic — the line never changed in 2.00 ms");
    assert_eq!(first(conflict()), "conflict — two rates on one line: 125 kbit/s and 250 kbit/s");
}

#[test]
fn one_frame_is_not_plural() {
    let mut report = classic();
    report.proven_frames = 1;
    assert_eq!(headline(&report), "125 kbit/s — proven by 1 frame");
}

#[test]
fn fd_without_switch_says_that_the_data_rate_is_unknown() {
    let mut report = fd();
    report.data = None;
    report.frames.fd_brs = 0;
    assert!(
        headline(&report)
            .starts_with("500 kbit/s, CAN FD without bit rate switch (data rate unknown) — ")
    );
}

#[test]
fn full_report_answers_the_next_questions() {
    let text = plain(&[fd()]);
    for wanted in [
        "channel      CAN_RX, inverted (high is dominant)",
        "nominal        500,005 bit/s   +10.00 ± 0.50 ppm of 500 kbit/s\n               CiA 301\n",
        "data         2,000,020 bit/s   +10.00 ± 0.50 ppm of 2 Mbit/s",
        "CRC and form of 1,000 frames; wrong with probability < 1e-300",
        "612 classic, 376 CAN FD (370 switch the bit rate), 12 remote; 30 extended",
        "errors       2 destroyed frames, 1 frame cut off by the recording, 1 overload frame",
        "acknowledge  missing on 7 of 1,000",
        "bus load     31.2 %   593,018 edges in 1.75 s",
        "asymmetry    dominant bits 20 ns longer, recessive bits shorter",
        "clocks       the senders differ by 12 ppm",
        "sampling     200 samples per bit",
        "! 7 frames were not acknowledged",
        "ip link set can0 type can bitrate 500000",
    ] {
        assert!(text.contains(wanted), "{wanted:?} is missing in:\n{text}");
    }
}

#[test]
fn undecided_gives_no_command() {
    assert!(!plain(&[undecided()]).contains("ip link"));
}

#[test]
fn other_channels_come_last_and_short() {
    let mut other = classic();
    other.channel = "CAN_TX".to_owned();
    let mut idle = silent();
    idle.channel = "D7".to_owned();
    let text = plain(&[fd(), silent(), other, undecided(), idle]);
    let tail: Vec<&str> = text.lines().rev().take(3).map(str::trim).collect();
    assert_eq!(
        tail,
        [
            "no traffic   D2, D7",
            "undecided    D1",
            "also         CAN_TX: 125 kbit/s — proven by 286 frames",
        ]
    );
}

#[test]
fn brief_is_one_line_per_source() {
    let text = render(Some("a.sr"), &[fd(), silent()], Detail::Brief, None, Paint::Plain);
    assert_eq!(text, "a.sr: 500 kbit/s, CAN FD data 2 Mbit/s — proven by 1,000 frames\n");
}

#[test]
fn expected_rate_is_compared() {
    let wanted = Bitrate::new(125_000);
    let text = render(None, &[classic()], Detail::Full, wanted, Paint::Plain);
    assert!(text.contains("expected     125 kbit/s: measured -478 ppm"), "{text}");
    let text = render(None, &[classic()], Detail::Full, Bitrate::new(500_000), Paint::Plain);
    assert!(text.contains("expected     500 kbit/s: this is another rate"), "{text}");
}

#[test]
fn colours_only_where_asked_for() {
    assert!(!plain(&[fd()]).contains('\x1b'));
    let coloured = render(None, &[fd()], Detail::Full, None, Paint::Coloured);
    assert!(coloured.starts_with("\x1b[1;32m500 kbit/s"));
}

#[test]
fn control_characters_of_a_channel_name_do_not_reach_the_terminal() {
    let mut report = fd();
    report.channel = "RX\x1b[2J".to_owned();
    assert!(!plain(&[report.clone()]).contains('\x1b'));
    assert!(!plain(&[classic(), report]).contains('\x1b'));
}

#[test]
fn summary_counts_good_frames_and_errors() {
    assert_eq!(summary(&classic()), "125 kbit/s — proven by 286 frames; 286 good frames");
    assert!(summary(&fd()).ends_with("; 1,000 good frames, 2 errors"));
    assert_eq!(summary(&silent()), headline(&silent()));
}
