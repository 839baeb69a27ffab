use super::*;
use clap::CommandFactory;

fn reading(arguments: &[&str]) -> ReadingArgs {
    let line = ["canbaud", "decode", "x.sr"].iter().chain(arguments);
    match Cli::try_parse_from(line).unwrap().command {
        Command::Decode(decode) => decode.reading,
        _ => unreachable!("decode was asked for"),
    }
}

#[test]
fn the_definition_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn help_lists_every_format() {
    for format in Format::ALL {
        let name = format.name();
        // The widths of the Logic 1 formats are listed behind the first.
        let known = match name.rsplit_once('-') {
            Some((stem, width)) if stem.starts_with("logic1") => {
                DETECT_HELP.contains(stem) && DETECT_HELP.contains(&format!("-{width}"))
            }
            _ => DETECT_HELP.contains(name),
        };
        assert!(known, "{name}");
    }
}

#[test]
fn every_way_to_say_the_polarity_is_understood() {
    let polarity = |arguments: &[&str]| reading(arguments).judge_options().polarity;
    assert_eq!(polarity(&[]), None);
    assert_eq!(polarity(&["--invert"]), Some(Polarity::Inverted));
    assert_eq!(polarity(&["--polarity", "inverted"]), Some(Polarity::Inverted));
    assert_eq!(polarity(&["--polarity", "normal"]), Some(Polarity::Normal));
}

#[test]
fn quantities_are_read_with_their_units() {
    let reading = reading(&[
        "--bitrate",
        "83.333k",
        "--data-bitrate",
        "2 Mbit/s",
        "--samplerate",
        "24MHz",
        "--threshold",
        "-0.5",
        "--hysteresis",
        "0.2",
    ]);
    let judge = reading.judge_options();
    assert_eq!(judge.bitrate, Bitrate::new(83_333));
    assert_eq!(judge.data_bitrate, Bitrate::new(2_000_000));
    let open = reading.open_options();
    assert_eq!(open.samplerate, Hertz::new(24_000_000));
    assert_eq!(open.threshold, Some(Threshold { volts: -0.5, hysteresis: 0.2 }));
}

#[test]
fn nonsense_is_refused() {
    for wrong in [
        vec!["--bitrate", "0"],
        vec!["--threshold", "nan"],
        vec!["--threshold", "2", "--hysteresis", "-1"],
        vec!["--data-bitrate", "2M"],
        vec!["--invert", "--polarity", "normal"],
        vec!["--input-format", "wav"],
    ] {
        let line = ["canbaud", "decode", "x.sr"].iter().chain(&wrong);
        assert!(Cli::try_parse_from(line).is_err(), "{wrong:?}");
    }
}
