//! Decimal text with a metric suffix to whole units, and back, without a float.

use core::fmt;

/// Why a text is not the quantity asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParseQuantityError {
    /// There is no text.
    Empty,
    /// A character that does not belong, at this byte.
    Unexpected {
        /// Byte position from 0.
        at: usize,
    },
    /// The value lies outside what the type holds.
    OutOfRange {
        /// Lowest allowed value, in the unit.
        min: u64,
        /// Highest allowed value, in the unit.
        max: u64,
        /// Name of the unit.
        unit: &'static str,
    },
}

impl fmt::Display for ParseQuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("no value given"),
            Self::Unexpected { at } => {
                write!(f, "unexpected character at position {} (write 500k, 83.333k, 1M)", at + 1)
            }
            Self::OutOfRange { min, max, unit } => {
                write!(f, "value outside {min} to {max} {unit}")
            }
        }
    }
}

impl core::error::Error for ParseQuantityError {}

/// What a text may say: the range of the value and the words that may follow it.
pub(super) struct Quantity {
    pub(super) min: u64,
    pub(super) max: u64,
    pub(super) unit: &'static str,
    pub(super) words: &'static [&'static str],
}

/// Reads digits, an optional fraction, an optional metric suffix (`k`, `M`, `G`) and an optional
/// unit word; rounds half up to a whole unit.
pub(super) fn parse(text: &str, quantity: &Quantity) -> Result<u64, ParseQuantityError> {
    let out_of_range = ParseQuantityError::OutOfRange {
        min: quantity.min,
        max: quantity.max,
        unit: quantity.unit,
    };
    if text.is_empty() {
        return Err(ParseQuantityError::Empty);
    }
    let mut value: u64 = 0;
    let mut decimals: u32 = 0;
    let mut digits = 0_u32;
    let mut point = false;
    let mut end = text.len();
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'0'..=b'9' => {
                digits += 1;
                // Digits past the 12th decimal cannot change a rounded value: G has nine zeros.
                if point && decimals >= 12 {
                    continue;
                }
                value = value
                    .checked_mul(10)
                    .and_then(|v| v.checked_add(u64::from(byte - b'0')))
                    .ok_or(out_of_range)?;
                decimals += u32::from(point);
            }
            b'_' if digits > 0 => {}
            b'.' if !point => point = true,
            _ => {
                end = at;
                break;
            }
        }
    }
    if digits == 0 {
        return Err(ParseQuantityError::Unexpected { at: 0 });
    }
    let rest = text.get(end..).unwrap_or("");
    let exponent =
        suffix(rest, quantity.words).ok_or(ParseQuantityError::Unexpected { at: end })?;
    let scaled = scale(value, exponent, decimals).ok_or(out_of_range)?;
    if scaled < quantity.min || scaled > quantity.max {
        return Err(out_of_range);
    }
    Ok(scaled)
}

/// `value * 10^exponent / 10^decimals`, rounded half up.
fn scale(value: u64, exponent: u32, decimals: u32) -> Option<u64> {
    let numerator = u128::from(value) * 10_u128.pow(exponent);
    let denominator = 10_u128.pow(decimals);
    u64::try_from((numerator + denominator / 2).checked_div(denominator)?).ok()
}

/// The power of ten that the text after the number stands for; `None` if it is not understood.
fn suffix(rest: &str, words: &[&str]) -> Option<u32> {
    let rest = rest.trim();
    if rest.is_empty() || is_word(rest, words) {
        return Some(0);
    }
    let exponent = match rest.as_bytes().first()? {
        b'k' | b'K' => 3,
        b'm' | b'M' => 6,
        b'g' | b'G' => 9,
        _ => return None,
    };
    let word = rest.get(1..)?.trim_start();
    (word.is_empty() || is_word(word, words)).then_some(exponent)
}

fn is_word(text: &str, words: &[&str]) -> bool {
    words.iter().any(|w| w.eq_ignore_ascii_case(text))
}

/// Writes `value` exactly with the largest of `M`, `k` and no suffix that keeps it at 1 or more.
pub(super) fn write_metric(f: &mut fmt::Formatter<'_>, value: u64) -> fmt::Result {
    let (unit, digits, suffix) = match value {
        0..1_000 => (1, 0, ""),
        1_000..1_000_000 => (1_000, 3, "k"),
        _ => (1_000_000, 6, "M"),
    };
    let mut fraction = value % unit;
    let mut width: usize = digits;
    while width > 0 && fraction.is_multiple_of(10) {
        fraction /= 10;
        width -= 1;
    }
    if width == 0 {
        write!(f, "{}{suffix}", value / unit)
    } else {
        write!(f, "{}.{fraction:0width$}{suffix}", value / unit)
    }
}
