use canbaud::wire::{ErrorKind, Field, FrameKind};
use serde_json::{Value, json};

use super::*;
use crate::output::items::{BASE, EXTENDED, error, everything, fd, frame, microseconds, overload};
use crate::schema;

fn objects(items: &[Item]) -> Vec<Value> {
    let mut out = Vec::new();
    let mut writer = FramesJson::new(&mut out, microseconds());
    for item in items {
        writer.write(item).unwrap();
    }
    writer.finish().unwrap();
    let text = String::from_utf8(out).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn data_frame_has_every_field() {
    let mut item = frame(1_000_250, EXTENDED, FrameKind::Data, 2, &[0xDE, 0x0F]);
    if let ItemKind::Frame(received) = &mut item.kind {
        received.acknowledged = false;
    }
    assert_eq!(
        objects(&[item]),
        [json!({
            "t": 1.000_250, "id": 0x18FE_F100, "extended": true, "remote": false, "fd": false,
            "brs": false, "esi": false, "dlc": 2, "data": "de0f", "ack": false, "kind": "data",
            "error": null, "field": null, "error_t": null
        })]
    );
}

#[test]
fn fd_and_remote_frames_tell_their_kind() {
    let fd = &objects(&[fd(0, true, false, 9, &[0; 12])])[0];
    assert_eq!(fd["fd"], true);
    assert_eq!(fd["brs"], true);
    assert_eq!(fd["esi"], false);
    assert_eq!(fd["dlc"], 9);
    assert_eq!(fd["data"], "00".repeat(12));
    assert_eq!(fd["kind"], "data");
    let remote = &objects(&[frame(0, BASE, FrameKind::Remote, 4, &[])])[0];
    assert_eq!(remote["remote"], true);
    assert_eq!(remote["dlc"], 4);
    assert_eq!(remote["data"], "");
    assert_eq!(remote["kind"], "remote");
}

#[test]
fn errors_tell_what_where_and_when() {
    let item = error(2_000_000, ErrorKind::Form, Field::EndOfFrame(3), Some(BASE));
    assert_eq!(
        objects(&[item]),
        [json!({
            "t": 2.0, "id": 0x123, "extended": false, "remote": null, "fd": null, "brs": null,
            "esi": null, "dlc": null, "data": null, "ack": null, "kind": "error", "error": "form",
            "field": "eof_3", "error_t": 2.000_07
        })]
    );
    let unknown = &objects(&[error(0, ErrorKind::Stuff, Field::Arbitration, None)])[0];
    assert_eq!(unknown["id"], Value::Null);
    assert_eq!(objects(&[overload(0)])[0]["kind"], "overload");
}

#[test]
fn everything_fits_the_schema() {
    for object in objects(&everything()) {
        schema::assert_valid(schema::DECODE, &object);
    }
}
