//! Divisions for processors that have none: exact, and cheap where numbers are small.

/// `numerator / denominator`, by divisions of 32 bits if the denominator has up to 16; 0 by 0.
pub(crate) fn div_small(numerator: u64, denominator: u32) -> u64 {
    if denominator == 0 {
        return 0;
    }
    if denominator > 0xFFFF {
        return numerator / u64::from(denominator);
    }
    let (high, low) = ((numerator >> 32) as u32, numerator as u32);
    if high == 0 {
        return u64::from(low / denominator);
    }
    // A rest is below 2^16, so the next 16 bits fit beside it.
    let middle = (high % denominator) << 16 | low >> 16;
    let last = (middle % denominator) << 16 | low & 0xFFFF;
    u64::from(high / denominator) << 32
        | u64::from(middle / denominator) << 16
        | u64::from(last / denominator)
}

/// `numerator * 2^20 / denominator`, rounded down; `None` if it has more than 64 bits or the
/// denominator more than 63.
pub(crate) fn ratio_q20(numerator: u64, denominator: u64) -> Option<u64> {
    if denominator == 0 || denominator >> 63 != 0 {
        return None;
    }
    let mut quotient = numerator / denominator;
    if quotient >> 44 != 0 {
        return None;
    }
    let mut rest = numerator % denominator;
    for _ in 0..20 {
        rest <<= 1;
        quotient <<= 1;
        if rest >= denominator {
            rest -= denominator;
            quotient |= 1;
        }
    }
    Some(quotient)
}

/// `numerator / denominator`: by 64 bits where that is enough, else bit by bit; 0 by 0.
pub(crate) fn div_wide(numerator: u128, denominator: u128) -> u128 {
    if let (Ok(numerator), Ok(denominator)) = (u64::try_from(numerator), u64::try_from(denominator))
    {
        return u128::from(numerator.checked_div(denominator).unwrap_or(0));
    }
    if denominator == 0 || denominator > numerator {
        return 0;
    }
    let shift = denominator.leading_zeros() - numerator.leading_zeros();
    let (mut rest, mut part, mut quotient) = (numerator, denominator << shift, 0);
    for _ in 0..=shift {
        quotient <<= 1;
        if rest >= part {
            rest -= part;
            quotient |= 1;
        }
        part >>= 1;
    }
    quotient
}

/// The square root, rounded down.
pub(crate) fn sqrt(value: u128) -> u64 {
    let mut rest = value;
    let mut root = 0_u128;
    // The highest power of four that is not above the value.
    let mut bit = 1 << ((127 - (value | 1).leading_zeros()) & !1);
    while bit != 0 {
        if rest >= root + bit {
            rest -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
        bit >>= 2;
    }
    root as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of all lengths.
    fn numbers() -> impl Iterator<Item = u128> {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut next = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        (0..20_000_u32).map(move |turn| {
            let value = u128::from(next()) << 64 | u128::from(next());
            value >> (turn % 129).min(127)
        })
    }

    #[test]
    fn quotients_and_roots_are_those_of_the_processor() {
        let mut before = 1;
        for value in numbers() {
            assert_eq!(div_wide(value, before), value / before.max(1) * u128::from(before != 0));
            assert_eq!(u128::from(sqrt(value)), value.isqrt());
            let (low, small) = (value as u64, before as u32);
            assert_eq!(div_small(low, small), low.checked_div(u64::from(small)).unwrap_or(0));
            let exact = (u128::from(low) << 20).checked_div(before & (u128::MAX >> 65));
            let wanted = exact.and_then(|exact| u64::try_from(exact).ok());
            assert_eq!(ratio_q20(low, before as u64 & (u64::MAX >> 1)), wanted, "{low} {before}");
            before = value;
        }
    }
}
