//! The `canbaud` command.
fn main() {}
