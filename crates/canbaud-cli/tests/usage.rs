//! What the README shows, and what the user gets for a wrong command line.

use std::path::Path;

#[test]
fn shown_commands_do_what_is_shown() {
    // The README speaks from the root of the project.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::env::set_current_dir(&root).unwrap();
    trycmd::TestCases::new().case("README.md").case("crates/canbaud-cli/tests/cmd/*.trycmd");
}
