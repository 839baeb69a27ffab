//! The whole way from a file to frames, against recordings whose truth is known.
//!
//! The recordings lie beside the project, not in it; where they are absent, the test says so.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

fn captures() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/captures");
    if path.join("manifest.json").exists() {
        return Some(path);
    }
    eprintln!("recordings are absent ({}): nothing is compared with them", path.display());
    None
}

fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The lines that `canbaud` prints, each a JSON object.
fn canbaud(args: &[&str], file: &Path, samplerate: Option<u64>) -> Vec<Value> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canbaud"));
    command.args(args).arg(file);
    if let Some(rate) = samplerate {
        command.args(["--samplerate", &rate.to_string()]);
    }
    let output = command.output().expect("canbaud runs");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    text.lines().map(|line| serde_json::from_str(line).expect("a JSON object a line")).collect()
}

/// Formats that hold no sample rate.
fn samplerate_to_give(entry: &Value) -> Option<u64> {
    let name = entry["name"].as_str()?;
    name.contains("logic1").then(|| entry["samplerate"].as_f64().expect("a rate") as u64)
}

/// What a recording must give back, and what it gave, if they differ.
fn complaints(captures: &Path, entry: &Value) -> Vec<String> {
    let file = captures.join(entry["file"].as_str().expect("a file"));
    let samplerate = samplerate_to_give(entry);
    let mut complaints = Vec::new();
    let detected = canbaud(&["detect", "--json"], &file, samplerate);
    let best = &detected[0];
    if best["verdict"] != "found" {
        return vec![format!("verdict {}", best["verdict"])];
    }
    for (phase, label) in [("nominal", "nominal_bitrate"), ("data", "data_bitrate")] {
        let truth = entry[format!("measured_{label}")].as_f64().or(entry[label].as_f64());
        let measured = best[phase]["measured"].as_f64();
        match (truth, measured) {
            (Some(truth), Some(measured)) => {
                let per_bit = entry["samplerate"].as_f64().unwrap_or(1e9) / truth;
                let exact = entry.get(format!("measured_{label}")).is_some_and(Value::is_number);
                let few = entry["n_frames"].as_u64().unwrap_or(0) < 50 || per_bit < 4.0;
                let tolerance = if few || !exact { 1500.0 } else { 100.0 };
                let error = (measured / truth - 1.0) * 1e6;
                if error.abs() > tolerance {
                    complaints.push(format!("{phase} {measured} off by {error:.0} ppm"));
                }
            }
            (None, None) => {}
            other => complaints.push(format!("{phase} rate: truth and measured are {other:?}")),
        }
    }
    if let Some(truth) = entry["truth"].as_str() {
        complaints.extend(compare_frames(
            &json(&captures.join(truth)),
            &canbaud(&["decode", "--format", "json"], &file, samplerate),
            entry,
        ));
    }
    complaints
}

/// Whether a receiving controller accepts the frame of the truth.
fn is_good(frame: &Value) -> bool {
    let error = frame["error"].as_str().unwrap_or("");
    frame["crc_ok"] == true && (error.is_empty() || error.contains("eof last bit"))
}

/// What makes a frame, in one text.
fn key(frame: &Value, names: [&str; 4]) -> String {
    let [extended, remote, esi, data] = names;
    format!(
        "{:X} ext {} rtr {} fd {} brs {} esi {} dlc {} {}",
        frame["id"].as_u64().unwrap_or(u64::MAX),
        frame[extended],
        frame[remote],
        frame["fd"],
        frame["brs"],
        frame[esi],
        frame["dlc"],
        frame[data].as_str().unwrap_or("").to_lowercase(),
    )
}

fn id(frame: &Value) -> Value {
    match &frame["id"] {
        Value::String(text) => {
            u64::from_str_radix(text.trim_start_matches("0x"), 16).map_or(Value::Null, Value::from)
        }
        number => number.clone(),
    }
}

fn compare_frames(truth: &Value, lines: &[Value], entry: &Value) -> Vec<String> {
    let frames = truth["frames"].as_array().expect("frames");
    let expected: Vec<String> = frames
        .iter()
        .filter(|frame| is_good(frame))
        .map(|frame| key(frame, ["ext", "rtr", "esi", "data"]))
        .collect();
    let decoded: Vec<String> = lines
        .iter()
        .filter(|line| line["kind"] == "data" || line["kind"] == "remote")
        .map(|line| {
            let mut line = line.clone();
            line["id"] = id(&line);
            key(&line, ["extended", "remote", "esi", "data"])
        })
        .collect();
    let mut complaints = Vec::new();
    if expected != decoded {
        let first = expected.iter().zip(&decoded).position(|(a, b)| a != b);
        let at = first.unwrap_or(expected.len().min(decoded.len()));
        complaints.push(format!(
            "{} frames, truth has {}; first difference at frame {at}: {:?}, truth {:?}",
            decoded.len(),
            expected.len(),
            decoded.get(at),
            expected.get(at),
        ));
    }
    let is_overload =
        |frame: &Value| frame["error"].as_str().is_some_and(|e| e.starts_with("overload"));
    let damaged = frames.iter().filter(|frame| !is_good(frame) && !is_overload(frame)).count();
    let errors = lines.iter().filter(|line| line["kind"] == "error").count();
    if damaged != errors && entry["n_frames"].as_u64() != Some(1) {
        complaints.push(format!("{errors} errors, truth has {damaged}"));
    }
    complaints
}

#[test]
fn every_recording_gives_its_rates_and_all_its_frames() {
    let Some(captures) = captures() else { return };
    let manifest = json(&captures.join("manifest.json"));
    let mut failed = Vec::new();
    for entry in manifest.as_array().expect("a list") {
        let complaints = complaints(&captures, entry);
        if !complaints.is_empty() {
            failed.push(format!("{}: {}", entry["name"], complaints.join("; ")));
        }
    }
    assert!(failed.is_empty(), "\n{}", failed.join("\n"));
}
