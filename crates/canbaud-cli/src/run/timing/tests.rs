//! What the commands print, from the command line on.

use clap::Parser;
use serde_json::Value;

use super::refusal::Refusal;
use super::{catalogue, plan};
use crate::args::{Cli, Command};
use crate::exit::Exit;
use crate::schema::{TIMING, assert_valid};

fn timing(line: &str) -> Result<String, Refusal> {
    let words = ["canbaud", "timing"].into_iter().chain(line.split_whitespace());
    match Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{error}")).command {
        Command::Timing(args) => plan::run(&args),
        _ => unreachable!("timing was asked for"),
    }
}

fn json(line: &str) -> Value {
    let text = match timing(&format!("{line} --json")) {
        Ok(text) => text,
        Err(refusal) => refusal.json().unwrap(),
    };
    let value = serde_json::from_str(&text).unwrap();
    assert_valid(TIMING, &value);
    value
}

fn words(value: &Value) -> Vec<u64> {
    value["registers"].as_array().unwrap().iter().map(|r| r["word"].as_u64().unwrap()).collect()
}

#[test]
fn sja1000_at_16_mhz_gets_the_words_of_the_beckhoff_table() {
    for (rate, expected) in [("1M", [0x00, 0x14]), ("500k", [0x00, 0x1C]), ("10k", [0x31, 0x1C])] {
        let value = json(&format!("--clock 16M --bitrate {rate} -c sja1000 --sjw 1"));
        assert_eq!(words(&value), expected, "{rate}");
        assert_eq!(value["phases"][0]["solutions"][0]["bitrate_error_ppm"], 0.0);
    }
}

#[test]
fn fd_phases_share_a_prescaler_and_tdc_is_on() {
    let value = json("--clock 40M --bitrate 500k --data-bitrate 2M -c mcp251xfd");
    let prescaler = |phase: usize| value["phases"][phase]["solutions"][0]["prescaler"].clone();
    assert_eq!((prescaler(0), prescaler(1)), (1.into(), 1.into()));
    // (1 + 14) * 1 clock periods at 75 % of 20.
    assert_eq!(value["data_tdc_offset_clocks"], 15);
    assert_eq!(words(&value), [0x0044_0909, 0x000D_0404, 0x0002_0F00]);
}

#[test]
fn xl_gets_its_pwm() {
    let value = json("--clock 160M --bitrate 500k --xl-bitrate 10M -c x_can_prt");
    assert_eq!(value["pwm"]["short_clocks"], 4);
    assert_eq!(value["pwm"]["long_clocks"], 12);
}

#[test]
fn bus_length_and_clocks_choose_the_sample_point() {
    let value = json("--clock 80M --bitrate 500k -c m_can --length 40m --ppm 5000");
    let best = &value["phases"][0]["solutions"][0];
    assert!(best["longest_bus_m"].as_u64().unwrap() >= 40);
    assert!(best["oscillator_tolerance_ppm"].as_u64().unwrap() >= 5_000);
    assert!(value["sample_point_window_permille"][1].as_f64().unwrap() < 875.0);
    let both =
        json("--clock 80M --bitrate 500k --data-bitrate 2M -c m_can --length 40m --ppm 5000");
    let point = both["phases"][0]["solutions"][0]["sample_point_permille"].as_f64().unwrap();
    assert!(point < 872.0);
}

#[test]
fn what_is_impossible_names_the_nearest_rate() {
    for (line, nearest) in [
        ("--clock 8M --bitrate 1M -c mcp2515", 666_666.667),
        ("--clock 150M --bitrate 5k -c sja1000", 46_875.0),
        ("--clock 42M --bitrate 800k -c bxcan --tolerance 1000", 807_692.308),
    ] {
        let refusal = timing(line).unwrap_err();
        assert_eq!(refusal.exit, Exit::Impossible, "{line}");
        assert_eq!(json(line)["nearest_bitrate"], nearest);
    }
    let refusal = timing("--clock 16M --bitrate 500k -c sja1000 --sjw 4").unwrap_err();
    assert!(refusal.line.contains("SJW 4 outside 1 to 2"), "{}", refusal.line);
    let refusal =
        timing("--clock 16M --bitrate 1M -c sja1000 --length 100m --ppm 100").unwrap_err();
    assert_eq!(refusal.exit, Exit::Impossible);
    assert!(refusal.line.contains("longest"), "{}", refusal.line);
}

#[test]
fn what_is_wrong_is_said() {
    for (line, part) in [
        ("--bitrate 500k", "--clock is missing"),
        ("--clock 80M", "--bitrate is missing"),
        ("--clock 80M --bitrate 500k -c sja100", "sja1000"),
        ("--clock 80M --bitrate 500k --data-bitrate 2M -c bxcan", "no data phase"),
        ("--clock 80M --bitrate 500k --data-bitrate 250k -c m_can", "slower"),
        ("-c m_can --decode 1,2,3,4", "no register"),
        ("-c m_can --decode zero", "no register word"),
        ("-c m_can --decode NBTP=1,nbtp=2", "given twice"),
        ("-c peak_pucan --decode 1", "no register"),
        ("-c c_can --decode BTR=0x0700", "prescaler"),
    ] {
        let refusal = timing(line).unwrap_err();
        assert_eq!(refusal.exit, Exit::Usage, "{line}");
        assert!(refusal.line.contains(part), "{line}: {}", refusal.line);
        assert_eq!(json(line)["kind"], "error");
    }
}

#[test]
fn a_clock_without_its_suffix_gets_a_hint() {
    let refusal = timing("--clock 80 --bitrate 500k -c m_can").unwrap_err();
    assert!(refusal.hint.unwrap().contains("80M"));
    // The suffix is a matter of taste.
    let same = |rate: &str| json(&format!("--clock 80M --bitrate {rate} -c m_can"));
    assert_eq!(same("1M"), same("1000000"));
}

/// Words that a widespread calculator gives for 500 kbit/s at 36 MHz: 1.5 Mbit/s in truth.
#[test]
fn registers_tell_what_they_really_do() {
    let value = json("--clock 36M -c bxcan --decode 0x00320002");
    let setting = &value["phases"][0]["setting"];
    assert_eq!(setting["bitrate_actual"], 1_500_000.0);
    assert_eq!(setting["sample_point_permille"], 500.0);
    let value = json("-c m_can --decode NBTP=0x06000A03,DBTP=0x00000A33");
    assert_eq!(value["phases"][1]["setting"]["time_quanta"], 16);
    assert_eq!(value["phases"][1]["setting"]["bitrate_actual"], Value::Null);
    let value = json("--clock 24M -c c167 --decode 0x1814");
    // AP2925 misprint: 47 619 bit/s where 50 000 are meant.
    assert_eq!(value["phases"][0]["setting"]["bitrate_actual"], 47_619.048);
    let value = json("--clock 24M -c c167 --decode 0x1000");
    assert_eq!(value["outside_limits"], "TSEG1 1 outside 3 to 16");
}

#[test]
fn every_controller_has_a_line_or_a_reason() {
    let value = json("--clock 80M --bitrate 125k --all");
    let (solved, impossible) = (&value["solutions"], &value["impossible"]);
    let count = solved.as_array().unwrap().len() + impossible.as_array().unwrap().len();
    assert_eq!(count, canbaud::timing::controllers::ALL.len());
    let fd = json("--clock 80M --bitrate 500k --data-bitrate 5M --all");
    assert!(fd["solutions"].as_array().unwrap().len() >= 10);
    let text = timing("--clock 80M --bitrate 125k --all").unwrap();
    assert_eq!(text.lines().count(), count);
}

#[test]
fn autobaud_tables_are_built_or_refused() {
    let value = json("--clock 20M -c c167 --autobaud-table --sample-point 80% --sjw 1");
    let table: Vec<u64> =
        value["rows"].as_array().unwrap().iter().map(|row| words(row)[0]).collect();
    assert_eq!(table, [0x1600, 0x3E00, 0x3E01, 0x3E03, 0x3E09]); // AP2925, 20 MHz
    let refusal = timing("--clock 10M -c sja1000 --autobaud-table --rates 1M,800k --deviation 2")
        .unwrap_err();
    assert_eq!(refusal.exit, Exit::Impossible);
    assert!(refusal.line.contains("1 Mbit/s") && refusal.line.contains("800 kbit/s"));
}

#[test]
fn tables_of_the_documents_mark_their_misprints() {
    for (name, misprints) in [("ap2925", 7), ("canopen", 1), ("ds80c390", 2)] {
        let value = json(&format!("--table {name}"));
        let rows =
            value["tables"].as_array().unwrap().iter().flat_map(|t| t["rows"].as_array().unwrap());
        let count: usize = rows.map(|row| row["misprints"].as_array().unwrap().len()).sum();
        assert_eq!(count, misprints, "{name}");
        assert!(timing(&format!("--table {name}")).unwrap().contains("<- printed"));
    }
}

#[test]
fn the_catalogue_lists_every_controller() {
    let list = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
        Command::Controllers(args) => catalogue::list(&args).unwrap(),
        _ => unreachable!("controllers was asked for"),
    };
    let value = serde_json::from_str(&list("canbaud controllers --json")).unwrap();
    assert_valid(TIMING, &value);
    let count = canbaud::timing::controllers::ALL.len();
    assert_eq!(value["controllers"].as_array().unwrap().len(), count);
    assert_eq!(list("canbaud controllers").lines().count(), 2 * count);
    assert!(list("canbaud controllers ds80c390").contains("unconfirmed: the table of CCD"));
}
