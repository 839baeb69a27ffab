//! The whole library links without a panic path and without an allocator.
//!
//! `firmware/host-proof` calls every part of canbaud and has a panic handler that calls a function
//! that does not exist: where something could panic, it does not link. `scripts/firmware` makes the
//! same proof for Cortex-M, where it also sees that no float helper is linked.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::Command;

#[test]
fn all_of_the_library_links_without_a_panic_path() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = root.join("target/no-panic");
    let output = Command::new(env!("CARGO"))
        .args(["build", "--release", "--quiet", "--locked"])
        .arg("--manifest-path")
        .arg(root.join("firmware/host-proof/Cargo.toml"))
        .arg("--target-dir")
        .arg(&target)
        // A library may leave symbols open, unless it is told not to.
        .env("RUSTFLAGS", "-Clink-arg=-Wl,-z,defs -Clink-arg=-lc")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_BUILD_TARGET")
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !said.contains("a_panic_path_was_linked"),
        "something in canbaud can panic; a disassembly of the library without -z defs shows the caller of core::panicking:\n{said}"
    );
    assert!(output.status.success(), "firmware/host-proof does not build:\n{said}");
    let linked =
        std::fs::read(target.join("release/libcanbaud_host_proof.so")).expect("the library");
    for symbol in ["core9panicking", "__rust_alloc", "__rust_dealloc", "malloc"] {
        let found = linked.windows(symbol.len()).any(|bytes| bytes == symbol.as_bytes());
        assert!(!found, "{symbol} is linked");
    }
}
