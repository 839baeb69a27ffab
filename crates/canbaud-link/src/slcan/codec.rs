//! Bytes from a slcan adapter as records; no I/O, no allocation.
//!
//! Sources: CAN232 manual; `drivers/net/can/slcan` of Linux 6.12; documents 1 to 3 of
//! Nakakiyo092/canable2-fw.

use canbaud::detect::scan::{ErrorClass, ErrorPlace};
use canbaud::wire::{Frame, FrameKind, Id};

/// Longest line that means anything: a CAN FD frame of 64 bytes with a time stamp of 8 digits.
/// Version texts may be longer, and are cut.
pub const LINE_MAX: usize = 160;

/// Collects bytes to lines.
///
/// ```
/// use canbaud_link::slcan::{Line, Lines};
/// let mut lines = Lines::new();
/// let mut heard = 0;
/// for byte in *b"t1232DEAD\r\r\x07" {
///     match lines.push(byte) {
///         Some(Line::Text(b"t1232DEAD")) => heard += 1,
///         Some(Line::Text(b"")) => heard += 10,
///         Some(Line::Bell) => heard += 100,
///         _ => {}
///     }
/// }
/// assert_eq!(heard, 111);
/// ```
#[derive(Debug, Clone)]
pub struct Lines {
    bytes: [u8; LINE_MAX],
    length: usize,
    /// The last line was told: the next byte begins a new one.
    told: bool,
}

/// What ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line<'a> {
    /// Everything before a CR, cut to [`LINE_MAX`] bytes.
    Text(&'a [u8]),
    /// BEL: the adapter refuses.
    Bell,
}

impl Default for Lines {
    fn default() -> Self {
        Self::new()
    }
}

impl Lines {
    /// An empty line.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; LINE_MAX], length: 0, told: false }
    }

    /// Takes the next byte; `Some` if it ends a line.
    pub fn push(&mut self, byte: u8) -> Option<Line<'_>> {
        if self.told {
            self.told = false;
            self.length = 0;
        }
        match byte {
            b'\r' => {
                self.told = true;
                Some(Line::Text(self.bytes.get(..self.length).unwrap_or_default()))
            }
            // What stands before it was cut off.
            0x07 => {
                self.told = true;
                Some(Line::Bell)
            }
            b'\n' => None,
            _ => {
                if let Some(place) = self.bytes.get_mut(self.length) {
                    *place = byte;
                    self.length += 1;
                }
                None
            }
        }
    }
}

/// What a line says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no allocation: records live on the stack")]
pub enum Record<'a> {
    /// Done.
    Done,
    /// A frame was received.
    Frame(Frame),
    /// A frame was sent.
    Sent,
    /// Errors on the bus; one of them, if there are several.
    Error(ErrorClass, ErrorPlace),
    /// A frame was lost on its way.
    Lost,
    /// The receive error counter.
    ReceiveErrors(u16),
    /// The answer to `F`.
    Flags(u8),
    /// Anything else.
    Text(&'a [u8]),
}

impl<'a> Record<'a> {
    /// Reads a line without its CR; everything is something.
    ///
    /// ```
    /// use canbaud_link::slcan::Record;
    /// assert_eq!(Record::parse(b"F80"), Record::Flags(0x80));
    /// assert!(matches!(Record::parse(b"T123456781AA0001"), Record::Frame(_)));
    /// assert_eq!(Record::parse(b"V1013"), Record::Text(b"V1013"));
    /// ```
    #[must_use]
    pub fn parse(line: &'a [u8]) -> Self {
        let Some((letter, rest)) = line.split_first() else { return Self::Done };
        let record = match letter {
            b't' | b'T' | b'r' | b'R' | b'd' | b'D' | b'b' | b'B' => {
                frame(*letter, rest).map(Self::Frame)
            }
            b'z' | b'Z' => Some(Self::Sent),
            b'F' => byte_of(rest).map(Self::Flags),
            b'e' => error(rest),
            b's' => state(rest),
            _ => None,
        };
        record.unwrap_or(Self::Text(line))
    }
}

const fn digit(byte: u8) -> Option<u8> {
    match byte {
        b'0'..=b'9' => Some(byte - b'0'),
        b'a'..=b'f' => Some(byte - b'a' + 10),
        b'A'..=b'F' => Some(byte - b'A' + 10),
        _ => None,
    }
}

/// Up to eight hexadecimal digits.
fn number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0_u32, |value, byte| Some(value << 4 | u32::from(digit(*byte)?)))
}

/// Exactly two hexadecimal digits.
fn byte_of(digits: &[u8]) -> Option<u8> {
    match digits {
        [high, low] => Some(digit(*high)? << 4 | digit(*low)?),
        _ => None,
    }
}

/// The frame behind its letter, with a time stamp of none, four or eight digits.
fn frame(letter: u8, rest: &[u8]) -> Option<Frame> {
    let kind = match letter.to_ascii_lowercase() {
        b't' => FrameKind::Data,
        b'r' => FrameKind::Remote,
        b'd' => FrameKind::Fd { brs: false, esi: false },
        _ => FrameKind::Fd { brs: true, esi: false },
    };
    let extended = letter.is_ascii_uppercase();
    let (id, rest) = rest.split_at_checked(if extended { 8 } else { 3 })?;
    let id = number(id)?;
    let id = if extended { Id::extended(id)? } else { Id::base(u16::try_from(id).ok()?)? };
    let (dlc, rest) = rest.split_first()?;
    let dlc = digit(*dlc)?;
    let (digits, stamp) = rest.split_at_checked(2 * Frame::data_length(kind, dlc))?;
    if !matches!(stamp.len(), 0 | 4 | 8) || number(stamp).is_none() {
        return None;
    }
    let mut data = [0; 64];
    let data = data.get_mut(..digits.len() / 2)?;
    for (place, pair) in data.iter_mut().zip(digits.chunks_exact(2)) {
        *place = byte_of(pair)?;
    }
    Frame::new(id, kind, dlc, data).ok()
}

/// `e`, how many, and a letter for each.
fn error<'a>(rest: &[u8]) -> Option<Record<'a>> {
    let (count, letters) = rest.split_first()?;
    if usize::from(digit(*count)?) != letters.len() || letters.is_empty() {
        return None;
    }
    let mut told = None;
    for letter in letters {
        let error = |class, place| Record::Error(class, place);
        let record = match letter {
            b'a' => error(ErrorClass::Acknowledge, ErrorPlace::AckSlot),
            b'b' | b'B' => error(ErrorClass::Bit, ErrorPlace::Unknown),
            b'c' => error(ErrorClass::Crc, ErrorPlace::BeforeCrcEnd),
            b'f' => error(ErrorClass::Form, ErrorPlace::Unknown),
            b's' => error(ErrorClass::Stuff, ErrorPlace::Unknown),
            b'o' => Record::Lost,
            // Sending is none of a listener's business.
            b'O' => Record::Done,
            _ => return None,
        };
        // An error on the bus says more than an overrun beside it.
        if told.is_none() || matches!(record, Record::Error(..)) {
            told = Some(record);
        }
    }
    told
}

/// `s`, the state, REC and TEC with three decimal digits each.
fn state<'a>(rest: &[u8]) -> Option<Record<'a>> {
    let [b'a' | b'w' | b'p' | b'b', counters @ ..] = rest else { return None };
    if counters.len() != 6 || !counters.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let receive = counters.get(..3)?;
    let receive = receive.iter().fold(0_u16, |value, byte| value * 10 + u16::from(byte - b'0'));
    Some(Record::ReceiveErrors(receive))
}

/// A frame as a command, CR included: how many bytes of the buffer it takes.
#[must_use]
pub fn print(frame: &Frame, buffer: &mut [u8; LINE_MAX]) -> usize {
    const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
    let letter = match frame.kind() {
        FrameKind::Data => b't',
        FrameKind::Remote => b'r',
        FrameKind::Fd { brs: false, .. } => b'd',
        FrameKind::Fd { brs: true, .. } => b'b',
    };
    let (letter, digits) =
        if frame.id().is_extended() { (letter.to_ascii_uppercase(), 8) } else { (letter, 3) };
    let hex = |value: u32| DIGITS.get((value & 0xF) as usize).copied().unwrap_or(b'0');
    let dlc = if frame.kind().is_fd() { frame.dlc() } else { frame.dlc().min(8) };
    let id = (0..digits).rev().map(|place| hex(frame.id().raw() >> (4 * place)));
    let data =
        frame.data().iter().flat_map(|byte| [hex(u32::from(*byte) >> 4), hex(u32::from(*byte))]);
    let all = [letter].into_iter().chain(id).chain([hex(dlc.into())]).chain(data).chain([b'\r']);
    let mut length = 0;
    for (place, byte) in buffer.iter_mut().zip(all) {
        *place = byte;
        length += 1;
    }
    length
}
