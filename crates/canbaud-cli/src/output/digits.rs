//! Decimal and hexadecimal digits straight into a byte buffer: the formatting machinery would cost
//! more than decoding a frame does.

const UPPER: &[u8; 16] = b"0123456789ABCDEF";
const LOWER: &[u8; 16] = b"0123456789abcdef";

/// Upper or lower case hexadecimal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Case {
    Upper,
    Lower,
}

/// Appends the low `digits` (0 to 20) decimal digits of `value`, with leading zeros.
pub(super) fn push_decimal(line: &mut Vec<u8>, value: u64, digits: usize) {
    let mut text = [b'0'; 20];
    let mut rest = value;
    for place in text.iter_mut().rev().take(digits) {
        *place = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    line.extend_from_slice(&text[20_usize.saturating_sub(digits)..]);
}

/// Appends `value` without leading zeros.
pub(super) fn push_number(line: &mut Vec<u8>, value: u64) {
    let digits = value.checked_ilog10().unwrap_or(0) as usize + 1;
    push_decimal(line, value, digits);
}

/// Appends the low `digits` (0 to 8) hexadecimal digits of `value`, upper case.
pub(super) fn push_hex(line: &mut Vec<u8>, value: u32, digits: u32) {
    for place in (0..digits).rev() {
        line.push(UPPER[(value >> (4 * place)) as usize & 0xF]);
    }
}

/// Appends two hexadecimal digits a byte.
pub(super) fn push_bytes(line: &mut Vec<u8>, bytes: &[u8], case: Case) {
    let table = match case {
        Case::Upper => UPPER,
        Case::Lower => LOWER,
    };
    line.extend(
        bytes
            .iter()
            .flat_map(|byte| [table[usize::from(byte >> 4)], table[usize::from(byte & 0xF)]]),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(push: impl Fn(&mut Vec<u8>)) -> String {
        let mut line = Vec::new();
        push(&mut line);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn decimals_have_their_leading_zeros() {
        assert_eq!(text(|l| push_decimal(l, 42, 6)), "000042");
        assert_eq!(text(|l| push_decimal(l, u64::MAX, 20)), "18446744073709551615");
        assert_eq!(text(|l| push_number(l, 0)), "0");
        assert_eq!(text(|l| push_number(l, 1_000)), "1000");
        assert_eq!(text(|l| push_number(l, u64::MAX)), "18446744073709551615");
    }

    #[test]
    fn hexadecimal_is_fixed_width() {
        assert_eq!(text(|l| push_hex(l, 0x5A, 3)), "05A");
        assert_eq!(text(|l| push_hex(l, 0x1FFF_FFFF, 8)), "1FFFFFFF");
        assert_eq!(text(|l| push_bytes(l, &[0xDE, 0x0F], Case::Upper)), "DE0F");
        assert_eq!(text(|l| push_bytes(l, &[0xDE, 0x0F], Case::Lower)), "de0f");
    }
}
