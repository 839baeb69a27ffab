use serde_json::{Value, json};

use super::*;
use crate::report::samples::{classic, conflict, fd, silent, undecided};
use crate::schema;

fn object(report: &ChannelReport, expected: Option<u32>) -> Value {
    let mut line = String::new();
    push_report(&mut line, "bus.sr", report, expected.and_then(Bitrate::new));
    assert_eq!(line.matches('\n').count(), 1);
    serde_json::from_str(&line).unwrap()
}

#[test]
fn found_bus_has_the_documented_fields() {
    let object = object(&fd(), None);
    assert_eq!(object["source"], "bus.sr");
    assert_eq!(object["channel"], "CAN_RX");
    assert_eq!(object["inverted"], true);
    assert_eq!(object["verdict"], "found");
    assert_eq!(object["nominal"]["bitrate"], 500_000);
    assert_eq!(object["nominal"]["measured"], 500_005.0);
    assert_eq!(object["nominal"]["uncertainty_ppm"], 0.5);
    assert_eq!(object["data"]["bitrate"], 2_000_000);
    assert_eq!(object["proven_frames"], 1_000);
    for (kind, count) in [("classic", 612), ("fd", 376), ("remote", 12), ("error", 2)] {
        assert_eq!(object["frames"][kind], count, "{kind}");
    }
    assert_eq!(object["error_probability"], 0.0);
    assert_eq!(object["bus_load"], 0.312);
    assert_eq!(object["asymmetry_ns"], 20.2);
    assert_eq!(object["caveats"][0]["code"], "missing_acknowledge");
    assert!(object["caveats"][0]["text"].as_str().unwrap().starts_with("7 frames"));
    assert!(object.get("expected").is_none());
}

#[test]
fn what_is_not_known_is_null() {
    let object = object(&undecided(), None);
    assert_eq!(object["verdict"], "undecided");
    assert_eq!(object["nominal"], Value::Null);
    assert_eq!(object["data"], Value::Null);
    assert_eq!(object["asymmetry_ns"], Value::Null);
    assert!(object["need"].as_str().unwrap().contains("capture 3 ms more"));
}

#[test]
fn conflict_names_both_rates() {
    let object = object(&conflict(), None);
    assert_eq!(object["verdict"], "conflict");
    assert_eq!(object["nominal"]["bitrate"], 125_000);
    assert_eq!(object["other"]["bitrate"], 250_000);
}

#[test]
fn expected_rate_gives_the_deviation() {
    let object = object(&classic(), Some(125_000));
    assert_eq!(object["expected"]["bitrate"], 125_000);
    let ppm = object["expected"]["deviation_ppm"].as_f64().unwrap();
    assert!((ppm + 478.0).abs() < 1e-3, "{ppm}");
}

#[test]
fn unreadable_source_is_an_object_of_its_own() {
    let mut line = String::new();
    push_unreadable(&mut line, "a \"b\".sr", "the file is empty");
    let object: Value = serde_json::from_str(&line).unwrap();
    assert_eq!(object, json!({"source": "a \"b\".sr", "error": "the file is empty"}));
    schema::assert_valid(schema::DETECT, &object);
}

#[test]
fn every_verdict_fits_the_schema() {
    for report in [classic(), fd(), undecided(), silent(), conflict()] {
        schema::assert_valid(schema::DETECT, &object(&report, None));
        schema::assert_valid(schema::DETECT, &object(&report, Some(500_000)));
    }
}
