//! Logs of candump (`candump -l`) as traffic: `(seconds) channel id#data`.

use canbaud::wire::{Frame, FrameKind, Id};

use crate::time::Span;

/// Why a log cannot be replayed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}; expected '(1436509052.249713) can0 123#DEADBEEF'")]
pub struct ReplayError {
    /// From 1.
    pub line: usize,
    /// What is wrong.
    pub what: &'static str,
}

/// Reads a log; times count from its first frame. Error frames and empty lines are left out.
///
/// # Errors
/// [`ReplayError`] with the line that is none of a log.
pub fn parse_candump(text: &str) -> Result<Vec<(Span, Frame)>, ReplayError> {
    let mut frames: Vec<(u64, Frame)> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() {
            continue;
        }
        let bad = |what| ReplayError { line: index + 1, what };
        let mut words = line.split_ascii_whitespace();
        let stamp = words.next().and_then(microseconds).ok_or_else(|| bad("no time stamp"))?;
        let body = words.nth(1).ok_or_else(|| bad("no frame"))?;
        if let Some(frame) = frame(body).map_err(bad)? {
            frames.push((stamp, frame));
        }
    }
    let first = frames.first().map_or(0, |(stamp, _)| *stamp);
    Ok(frames
        .into_iter()
        .map(|(stamp, frame)| (Span::from_us(stamp.saturating_sub(first)), frame))
        .collect())
}

fn microseconds(word: &str) -> Option<u64> {
    let (seconds, fraction) = word.strip_prefix('(')?.strip_suffix(')')?.split_once('.')?;
    if fraction.len() != 6 {
        return None;
    }
    seconds.parse::<u64>().ok()?.checked_mul(1_000_000)?.checked_add(fraction.parse().ok()?)
}

/// `Ok(None)` for an error frame.
fn frame(body: &str) -> Result<Option<Frame>, &'static str> {
    let (id, rest) = body.split_once('#').ok_or("no '#' between identifier and data")?;
    let raw = u32::from_str_radix(id, 16).map_err(|_| "identifier is not hexadecimal")?;
    let id = match id.len() {
        3 => Id::base(raw as u16),
        8 if raw & 0x2000_0000 != 0 => return Ok(None),
        8 => Id::extended(raw),
        _ => None,
    }
    .ok_or("identifier has neither 3 nor 8 digits in range")?;
    let (kind, dlc, bytes) = if let Some(fd) = rest.strip_prefix('#') {
        let flags =
            fd.get(..1).and_then(|f| u8::from_str_radix(f, 16).ok()).ok_or("no FD flags")?;
        let bytes = hex(fd.get(1..).unwrap_or(""))?;
        let kind = FrameKind::Fd { brs: flags & 1 != 0, esi: flags & 2 != 0 };
        let dlc = (0..=15).find(|dlc| Frame::data_length(kind, *dlc) >= bytes.len());
        (kind, dlc.ok_or("more than 64 bytes")?, bytes)
    } else if let Some(dlc) = rest.strip_prefix('R') {
        let dlc = if dlc.is_empty() { Ok(0) } else { u8::from_str_radix(dlc, 16) };
        (FrameKind::Remote, dlc.map_err(|_| "remote frame without a length")?, Vec::new())
    } else {
        let bytes = hex(rest)?;
        (FrameKind::Data, bytes.len() as u8, bytes)
    };
    let mut padded = bytes;
    if kind.is_fd() {
        padded.resize(Frame::data_length(kind, dlc), 0);
    }
    Frame::new(id, kind, dlc, &padded).map(Some).map_err(|_| "more than 8 bytes")
}

fn hex(text: &str) -> Result<Vec<u8>, &'static str> {
    let digits: Vec<u32> = text
        .chars()
        .filter(|c| *c != '.')
        .map(|c| c.to_digit(16).ok_or("data is not hexadecimal"))
        .collect::<Result<_, _>>()?;
    if !digits.len().is_multiple_of(2) {
        return Err("data has an odd number of digits");
    }
    Ok(digits.chunks(2).map(|pair| (pair[0] * 16 + pair[1]) as u8).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_of_every_kind_of_frame_is_read() {
        let log = "(1436509052.249713) vcan0 044#2A366C2BBA\n\
                   (1436509052.449847) vcan0 0F6#7ADFE07BD2\n\
                   (1436509052.449848) vcan0 1F334455#1122334455667788\n\
                   (1436509052.449849) vcan0 123#R8\n\
                   (1436509052.449850) vcan0 123##3112233445566778899\n\
                   (1436509052.449851) vcan0 20000088#0000000000000000\n";
        let frames = parse_candump(log).unwrap();
        assert_eq!(frames.len(), 5);
        assert_eq!(frames[1].0, Span::from_us(200_134));
        assert_eq!(frames[2].1.id(), Id::Extended(0x1F33_4455));
        assert_eq!((frames[3].1.kind(), frames[3].1.dlc()), (FrameKind::Remote, 8));
        assert_eq!(frames[4].1.kind(), FrameKind::Fd { brs: true, esi: true });
        // Nine bytes need the length of twelve.
        assert_eq!(
            frames[4].1.data(),
            [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88, 0x99, 0, 0, 0]
        );
    }

    #[test]
    fn bad_line_is_named() {
        let error = parse_candump("(1.000000) can0 1#\n").unwrap_err();
        assert_eq!(error.line, 1);
        assert!(
            parse_candump("\n(1.000000) can0 123#1\n").unwrap_err().to_string().contains("line 2")
        );
        assert!(parse_candump("1.0 can0 123#11\n").is_err());
    }
}
