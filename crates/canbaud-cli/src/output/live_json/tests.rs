use canbaud::detect::scan::Policy;
use serde_json::Value;

use super::*;
use crate::report::Outcome;
use crate::report::samples::live;
use crate::schema::{SCAN, assert_valid};

fn line(push: impl FnOnce(&mut String)) -> Value {
    let mut text = String::new();
    push(&mut text);
    assert!(text.ends_with('\n') && text.lines().count() == 1, "{text}");
    let value = serde_json::from_str(&text).unwrap();
    assert_valid(SCAN, &value);
    value
}

#[test]
fn every_event_fits_the_schema() {
    let report = live();
    let one = report.tried[0];
    let now = Micros(1_500_000);
    for policy in Policy::ALL {
        line(|out| push_start(out, "can0", "can0 (gs_usb)", &[one.candidate], policy.name()));
    }
    line(|out| push_remark(out, "can0 was up"));
    let listening = line(|out| push_listening(out, now, &one.candidate));
    assert_eq!(listening["t"], 1.5);
    line(|out| push_evidence(out, now, &one));
    line(|out| push_configuration(out, "networkd", "[Match]\n"));
    for (error, kind) in [
        (LinkError::Permission { interface: "can0".to_owned() }, "permission"),
        (LinkError::Gone { adapter: "can0".to_owned() }, "unusable"),
        (LinkError::Recording { path: "x".to_owned(), reason: "y".to_owned() }, "unreadable"),
    ] {
        assert_eq!(line(|out| push_error(out, "can0", &error))["kind"], kind);
    }
}

#[test]
fn verdicts_fit_the_schema_with_and_without_a_rate() {
    let found = line(|out| push_verdict(out, &live()));
    assert_eq!((&found["verdict"], &found["found"]["nominal"]), (&"found".into(), &250_000.into()));
    assert_eq!(found["found"]["acknowledged"], true);
    let mut report = live();
    report.outcome = Outcome::NoTraffic;
    report.found = None;
    report.bound = None;
    report.need = Some("nothing was heard".to_owned());
    let silent = line(|out| push_verdict(out, &report));
    assert_eq!((&silent["verdict"], &silent["found"]), (&"no_traffic".into(), &Value::Null));
}
