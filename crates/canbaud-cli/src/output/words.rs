//! Sentences and phrases of the text report.

use std::fmt::Write as _;

use super::number::{short, thousands};
use crate::report::FrameCounts;

/// `612 classic, 376 CAN FD (370 with bit rate switch), 12 remote; 30 extended`.
pub(super) fn frames_by_kind(frames: &FrameCounts) -> String {
    let mut kinds = Vec::new();
    if frames.classic > 0 {
        kinds.push(format!("{} classic", thousands(frames.classic)));
    }
    if frames.fd > 0 {
        let switched = match frames.fd_brs {
            0 => "none switches the bit rate".to_owned(),
            n if n == frames.fd => "all switch the bit rate".to_owned(),
            n => format!("{} switch the bit rate", thousands(n)),
        };
        let non_iso = match frames.fd_non_iso {
            0 => "",
            n if n == frames.fd => ", non-ISO CRC",
            _ => ", ISO and non-ISO CRC mixed",
        };
        kinds.push(format!("{} CAN FD ({switched}{non_iso})", thousands(frames.fd)));
    }
    if frames.remote > 0 {
        kinds.push(format!("{} remote", thousands(frames.remote)));
    }
    let mut text = if kinds.is_empty() { "no good frame".to_owned() } else { kinds.join(", ") };
    if frames.extended > 0 {
        let _ = write!(text, "; {} extended", thousands(frames.extended));
    }
    text
}

/// What the asymmetry does to the bits.
pub(super) fn asymmetry(nanoseconds: f64) -> String {
    let size = short(nanoseconds.abs());
    match nanoseconds {
        ns if ns.abs() < 1.0 => "below 1 ns".to_owned(),
        ns if ns > 0.0 => format!("dominant bits {size} ns longer, recessive bits shorter"),
        _ => format!("dominant bits {size} ns shorter, recessive bits longer"),
    }
}

/// Breaks text into lines of at most `width` characters, where there are blanks.
pub(super) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let room = lines.last().map_or(0, |line| line.chars().count());
        if room > 0 && room + 1 + word.chars().count() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_kinds_that_occur_are_named() {
        let frames = FrameCounts { fd: 3, fd_non_iso: 3, ..FrameCounts::default() };
        assert_eq!(frames_by_kind(&frames), "3 CAN FD (none switches the bit rate, non-ISO CRC)");
        assert_eq!(frames_by_kind(&FrameCounts::default()), "no good frame");
    }

    #[test]
    fn asymmetry_has_a_direction() {
        assert_eq!(asymmetry(0.4), "below 1 ns");
        assert_eq!(asymmetry(-35.0), "dominant bits 35 ns shorter, recessive bits longer");
    }

    #[test]
    fn text_is_wrapped_at_blanks() {
        assert_eq!(wrap("one two three four", 9), ["one two", "three", "four"]);
    }
}
