//! The shared recordings: the number of edges, the sample rate and the channel of each are known
//! from the manifest.

mod common;

use canbaud_capture::{OpenOptions, open};
use common::{Kept, shared};

#[test]
fn every_logic_recording_has_the_edges_of_the_manifest() {
    let Some(manifest) = shared("manifest.json") else { return };
    let manifest: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(manifest).unwrap()).unwrap();
    let mut checked = 0;
    for entry in manifest.as_array().unwrap() {
        let channel = entry["channel"].as_str().unwrap();
        let Some(n_edges) = entry["n_edges"].as_u64() else { continue };
        let Some(path) = shared(entry["file"].as_str().unwrap()) else { continue };
        // The scope recordings carry a logic channel besides, sliced at other thresholds.
        let name = if channel.contains("analogue") { "CAN_RX" } else { channel };
        let mut capture = open(&path, &OpenOptions::default()).unwrap();
        let number = capture.channels().iter().position(|c| c.name == name).unwrap();
        let rate = entry["samplerate"].as_f64().unwrap();
        assert_eq!(capture.samplerate().unwrap().hertz() as f64, rate, "{}", path.display());
        capture.select(&[number]);
        let mut kept = Kept::default();
        let summary = capture.stream(&mut kept).unwrap();
        let step = capture.channels()[number].resolution_ticks;
        assert_eq!(kept.edges(number).len() as u64, n_edges, "{}", path.display());
        assert_eq!(summary.channels[number].edges, n_edges);
        let stretch = &kept.channels[number][0];
        assert_eq!(kept.channels[number].len(), 1);
        assert_eq!(stretch.end, Some(entry["n_samples"].as_u64().unwrap() * step));
        checked += 1;
    }
    assert!(checked >= 20, "{checked}");
}
