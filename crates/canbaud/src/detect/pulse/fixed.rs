//! Divisions for processors that have none: exact, and cheap where numbers are small.

/// `numerator / denominator`, by four steps of 16 bits if the denominator has no more; 0 by 0.
pub(super) fn div_small(numerator: u64, denominator: u32) -> u64 {
    match denominator {
        0 => 0,
        1..=0xFFFF => {
            let (mut quotient, mut rest) = (0_u64, 0_u32);
            for shift in [48, 32, 16, 0] {
                // rest < 2^16: the step fits 32 bits.
                let step = (rest << 16) | (numerator >> shift) as u32 & 0xFFFF;
                quotient = (quotient << 16) | u64::from(step / denominator);
                rest = step % denominator;
            }
            quotient
        }
        _ => numerator / u64::from(denominator),
    }
}
