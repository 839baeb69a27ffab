//! Frames as slcan writes them: `tiiildd…` and its relatives.

use canbaud::wire::{Frame, FrameKind, Id};

/// The letter of a frame: lower case for a base identifier.
const fn letter(frame: &Frame) -> char {
    match (frame.kind(), frame.id().is_extended()) {
        (FrameKind::Data, false) => 't',
        (FrameKind::Data, true) => 'T',
        (FrameKind::Remote, false) => 'r',
        (FrameKind::Remote, true) => 'R',
        (FrameKind::Fd { brs: false, .. }, false) => 'd',
        (FrameKind::Fd { brs: false, .. }, true) => 'D',
        (FrameKind::Fd { brs: true, .. }, false) => 'b',
        (FrameKind::Fd { brs: true, .. }, true) => 'B',
    }
}

/// A received frame without its CR; `stamp` in ms if time stamps are on.
pub(super) fn print(frame: &Frame, stamp: Option<u16>) -> String {
    use core::fmt::Write;
    let dlc = if frame.kind().is_fd() { frame.dlc() } else { frame.dlc().min(8) };
    let mut text = format!("{}{}{dlc:X}", letter(frame), frame.id());
    for byte in frame.data() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02X}");
    }
    if let Some(stamp) = stamp {
        let _ = write!(text, "{stamp:04X}");
    }
    text
}

fn hex(text: &str) -> Option<u32> {
    // from_str_radix would take a sign.
    let digits = text.bytes().all(|byte| byte.is_ascii_hexdigit());
    if digits { u32::from_str_radix(text, 16).ok() } else { None }
}

/// A frame to send, letter included; `None` if that is none.
pub(super) fn parse(line: &str) -> Option<Frame> {
    let kind = match line.get(..1)? {
        "t" | "T" => FrameKind::Data,
        "r" | "R" => FrameKind::Remote,
        "d" | "D" => FrameKind::Fd { brs: false, esi: false },
        "b" | "B" => FrameKind::Fd { brs: true, esi: false },
        _ => return None,
    };
    let extended = line.as_bytes().first()?.is_ascii_uppercase();
    let digits = if extended { 8 } else { 3 };
    let raw = hex(line.get(1..=digits)?)?;
    let id = if extended { Id::extended(raw)? } else { Id::base(u16::try_from(raw).ok()?)? };
    let dlc = hex(line.get(digits + 1..digits + 2)?)? as u8;
    if dlc > 8 && !kind.is_fd() {
        return None;
    }
    let body = line.get(digits + 2..)?;
    let wanted = Frame::data_length(kind, dlc);
    if body.len() != 2 * wanted {
        return None;
    }
    let bytes: Option<Vec<u8>> =
        (0..wanted).map(|at| Some(hex(body.get(2 * at..2 * at + 2)?)? as u8)).collect();
    Frame::new(id, kind, dlc, &bytes?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_there_and_back() {
        for line in [
            "t1232DEAD",
            "T1FFFFFFF0",
            "r7FF8",
            "R000000014",
            "d1239000102030405060708090A0B",
            "B123456781AA",
        ] {
            assert_eq!(print(&parse(line).unwrap(), None), line);
        }
        assert_eq!(print(&parse("t0010").unwrap(), Some(0xEA5F)), "t0010EA5F");
    }

    #[test]
    fn nonsense_is_refused() {
        for line in ["t8000", "t12", "t1239", "t1231", "t1231A", "t1231AAB", "T200000000", "t+120"]
        {
            assert!(parse(line).is_none(), "{line}");
        }
    }
}
