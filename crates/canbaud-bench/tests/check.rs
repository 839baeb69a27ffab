//! `--check` as CI meets it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A table of few cases.
const TABLE: &str = "can-fd-asymmetry";

fn bench(document: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canbaud-bench"));
    command.arg("--document").arg(document).args(args).output().unwrap()
}

fn document() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/accuracy.md")
}

#[test]
fn table_that_differs_is_named_and_written_anew() {
    let current = bench(&document(), &["--table", TABLE, "--check"]);
    let error = String::from_utf8_lossy(&current.stderr).into_owned();
    assert!(current.status.success(), "{error}");

    let text = std::fs::read_to_string(document()).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("accuracy.md");
    let (head, body) = text.split_once("<!-- generated: can-fd-asymmetry -->").unwrap();
    std::fs::write(
        &path,
        format!("{head}<!-- generated: {TABLE} -->{}", body.replacen('8', "9", 1)),
    )
    .unwrap();
    let stale = bench(&path, &["--table", TABLE, "--check"]);
    assert_eq!(stale.status.code(), Some(1));
    let error = String::from_utf8_lossy(&stale.stderr).into_owned();
    assert!(error.contains("is stale: can-fd-asymmetry;"), "{error}");

    assert!(bench(&path, &["--table", TABLE]).status.success());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn mistakes_of_the_caller_are_one_line() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("accuracy.md");
    let output = bench(&path, &["--table", TABLE, "--check"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("accuracy.md"));
    let output = bench(&path, &["--case", "scene=nothing,seed=1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no scene \"nothing\""));
}

#[test]
fn case_says_what_comes_of_it_and_whether_it_was_wrong() {
    let output = bench(&document(), &["--case", "seed=1,frames=12"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("seed=1,frames=12") && text.contains("answer: Right"), "{text}");
}
