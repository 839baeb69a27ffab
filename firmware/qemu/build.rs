//! Chooses the memory map for the target and turns the vectors into tables.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Cortex-M4: `qemu-system-arm -M mps2-an386`.
const MPS2_AN386: &str = "MEMORY { FLASH : ORIGIN = 0x00000000, LENGTH = 4M\n RAM : ORIGIN = 0x20000000, LENGTH = 4M }\n";
/// Cortex-M0: `qemu-system-arm -M microbit`.
const MICROBIT: &str = "MEMORY { FLASH : ORIGIN = 0x00000000, LENGTH = 256K\n RAM : ORIGIN = 0x20000000, LENGTH = 16K }\n";

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let target = env::var("TARGET").expect("cargo sets it");
    let memory = if target.starts_with("thumbv6m") { MICROBIT } else { MPS2_AN386 };
    fs::write(out.join("memory.x"), memory).expect("memory.x");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");

    let vectors = Path::new("../../vectors");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={}", vectors.display());
    fs::write(out.join("recordings.rs"), recordings(&vectors.join("detect"))).expect("recordings");
    fs::write(out.join("frames.rs"), frames(&vectors.join("bits"))).expect("frames");
}

/// Every recording of `vectors/detect` as a `Recording`.
fn recordings(directory: &Path) -> String {
    let mut names: Vec<_> = fs::read_dir(directory)
        .expect("vectors")
        .map(|entry| entry.expect("entry").path())
        .collect();
    names.sort();
    let mut code = String::from(
        "/// The recordings of `vectors/detect`.\npub const RECORDINGS: &[Recording] = &[\n",
    );
    for path in names {
        let text = fs::read_to_string(&path).expect("readable");
        let name = path.file_stem().expect("a name").to_string_lossy();
        let rates = value(&text, "nominal_millibits_per_second").unwrap_or("[0, 0]");
        writeln!(
            code,
            "Recording {{ name: {name:?}, timebase_hz: {}, initial: Logic::{}, end: {},\n\
             edges: &{},\n verdict: {}, nominal_millibits: {rates} }},",
            value(&text, "timebase_hz").expect("timebase_hz"),
            if value(&text, "initial") == Some("\"high\"") { "High" } else { "Low" },
            value(&text, "end").expect("end"),
            value(&text, "edges").expect("edges"),
            value(&text, "verdict").expect("verdict"),
        )
        .expect("writing to a string");
    }
    code + "];\n"
}

/// Frames of `vectors/bits` as strings of bits, by name.
fn frames(directory: &Path) -> String {
    let text = fs::read_to_string(directory.join("corners.toml")).expect("corners.toml");
    let mut code = String::from(
        "/// The frames of `vectors/bits/corners.toml`.\npub const FRAMES: &[(&str, &str)] = &[\n",
    );
    for frame in text.split("[[frame]]").skip(1) {
        let name = value(frame, "name").expect("name");
        let bits = value(frame, "bits").expect("bits");
        writeln!(code, "({name}, {bits}),").expect("writing to a string");
    }
    code + "];\n"
}

/// The value of `key = value`: an array, a text with its quotes, or a number.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let pattern = format!("{key} = ");
    let at = text
        .match_indices(&pattern)
        .find(|(at, _)| *at == 0 || !text.as_bytes()[at - 1].is_ascii_alphanumeric())?
        .0;
    let rest = &text[at + pattern.len()..];
    let end = match rest.as_bytes().first()? {
        b'[' => rest.find(']')? + 1,
        b'"' => rest[1..].find('"')? + 2,
        _ => rest.find(|c: char| !c.is_ascii_digit())?,
    };
    Some(&rest[..end])
}
