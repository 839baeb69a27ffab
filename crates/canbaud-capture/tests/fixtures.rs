//! One signal in many formats: the same edges must come out of all of them.

mod common;

use canbaud::units::Hertz;
use canbaud_capture::{Capture, OpenOptions, open};
use common::{Kept, shared};

/// Edges of the channel called `name` in seconds.
fn seconds(capture: &mut Capture, name: &str) -> Vec<f64> {
    let number = capture.channels().iter().position(|c| c.name == name).unwrap_or_else(|| {
        panic!("no {name} in {:?}", capture.channels());
    });
    capture.select(&[number]);
    let mut kept = Kept::default();
    capture.stream(&mut kept).unwrap();
    let tick = capture.timebase().seconds() as f64 / capture.timebase().ticks() as f64;
    kept.edges(number).iter().map(|&t| t as f64 * tick).collect()
}

fn compare(file: &str, name: &str, reference: (&str, &str), tolerance: f64, shift: f64) {
    let (Some(path), Some(truth)) = (shared(file), shared(reference.0)) else { return };
    let truth = seconds(&mut open(&truth, &OpenOptions::default()).unwrap(), reference.1);
    // Only Logic 1 exports need the rate; the others must find it.
    let samplerate = if file.contains("logic1") { Hertz::new(100_000_000) } else { None };
    let options = OpenOptions { samplerate, ..OpenOptions::default() };
    let edges = seconds(&mut open(&path, &options).unwrap(), name);
    assert_eq!(edges.len(), truth.len(), "{file}");
    for (edge, truth) in edges.iter().zip(&truth) {
        assert!((edge - truth - shift).abs() <= tolerance, "{file}: {edge} for {truth}");
    }
}

const FD: (&str, &str) = ("recorded/can_fd_std_brs_64.sr", "CAN_L");
const MCP: (&str, &str) = ("recorded/mcp2515dm-bm-125kbits_bus_load_25percent.sr", "CAN_RX");
const WFM5: (&str, &str) = ("recorded/scopehal_can_wfm5.sr", "CANH-CANL");

#[test]
fn digital_fixtures_have_the_edges_of_the_session_they_were_made_from() {
    let f = |name: &str| format!("fixtures/can_fd_std_brs_64.{name}");
    compare(&f("sigrok.csv"), "CAN_L", FD, 1e-12, 0.0);
    compare(&f("sigrok_dedup.csv"), "CAN_L", FD, 1e-12, 0.0);
    compare(&f("saleae.csv"), "Channel 0", FD, 1e-12, 0.0);
    compare(&f("sigrok.vcd"), "CAN_L", FD, 1e-12, 0.0);
    compare(&f("saleae_v0.bin"), "D0", FD, 1e-12, 0.0);
    compare(&f("saleae_v1.bin"), "D0", FD, 1e-12, 0.0);
    compare(&f("logic1_changes.bin"), "Channel 0", FD, 1e-12, 0.0);
    compare("fixtures/mcp25.sigrok.vcd", "CAN_RX", MCP, 1e-12, 0.0);
    compare("fixtures/mcp25.sigrok_dedup.csv", "CAN_RX", MCP, 1e-12, 0.0);
}

#[test]
fn scope_fixtures_have_the_edges_of_the_recording() {
    // The fixtures keep every tenth sample and three digits of the voltage.
    let canh = ("recorded/scopehal_can_wfm5.sr", "CANH");
    compare("fixtures/wfm5_canh_saleae_v0_analog.bin", "A0", canh, 20e-9, 0.0);
    compare("fixtures/wfm5_canh_saleae_v1_analog.bin", "A0", canh, 20e-9, 0.0);
    for (file, names) in [
        ("wfm5_rigol_1000z.csv", "CH1-CH2"),
        ("wfm5_rigol_5000_memory.csv", "CH1-CH2"),
        ("wfm5_saleae_analog.csv", "CANH-CANL"),
        ("wfm5_siglent_bin2csv.csv", "CH1-CH2"),
        ("wfm5_tek_mdo.csv", "CH1-CH2"),
    ] {
        compare(&format!("fixtures/{file}"), names, WFM5, 20e-9, 0.0);
    }
}
