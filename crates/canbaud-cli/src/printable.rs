//! Text from files and file names, safe to show.

/// `text` with every control character replaced: a channel name must not steer a terminal.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn escapes_and_line_ends_are_replaced() {
        assert_eq!(printable("a\x1b[2J\nb µ"), "a\u{FFFD}[2J\u{FFFD}b µ");
    }
}
