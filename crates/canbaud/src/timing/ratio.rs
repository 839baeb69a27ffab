//! A share as an exact ratio.

use core::cmp::Ordering;
use core::fmt;

/// A non-negative exact ratio; compared by cross multiplication, printed in percent.
///
/// ```
/// use canbaud::timing::Ratio;
/// let ratio = Ratio::new(13, 16).unwrap();
/// assert_eq!(ratio.permille(), 813);
/// assert_eq!(ratio.to_string(), "81.25%");
/// assert_eq!(ratio, Ratio::new(26, 32).unwrap());
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Ratio {
    numerator: u64,
    denominator: u64,
}

impl Ratio {
    /// `numerator / denominator`; `None` if the denominator is 0.
    #[must_use]
    pub const fn new(numerator: u64, denominator: u64) -> Option<Self> {
        if denominator == 0 { None } else { Some(Self { numerator, denominator }) }
    }

    /// The ratio of two values of which the second is known not to be 0 (1 stands in for it).
    pub(crate) const fn over(numerator: u64, denominator: u64) -> Self {
        Self { numerator, denominator: if denominator == 0 { 1 } else { denominator } }
    }

    /// The numerator.
    #[must_use]
    pub const fn numerator(self) -> u64 {
        self.numerator
    }

    /// The denominator, never 0.
    #[must_use]
    pub const fn denominator(self) -> u64 {
        self.denominator
    }

    /// `ratio * scale`, rounded half up; saturates.
    #[must_use]
    pub const fn scaled(self, scale: u32) -> u64 {
        let product = self.numerator as u128 * scale as u128;
        let rounded = quotient(product + self.denominator as u128 / 2, self.denominator);
        if rounded > u64::MAX as u128 { u64::MAX } else { rounded as u64 }
    }

    /// In thousandths, rounded half up.
    #[must_use]
    pub const fn permille(self) -> u64 {
        self.scaled(1_000)
    }

    /// In parts per million, rounded down: a tolerance must not be promised too high.
    #[must_use]
    pub const fn ppm_floor(self) -> u64 {
        let ppm = quotient(self.numerator as u128 * 1_000_000, self.denominator);
        if ppm > u64::MAX as u128 { u64::MAX } else { ppm as u64 }
    }

    /// `self < other`, exactly.
    #[must_use]
    pub const fn is_below(self, other: Self) -> bool {
        (self.numerator as u128 * other.denominator as u128)
            < (other.numerator as u128 * self.denominator as u128)
    }
}

/// `a / b` without the panic of a division by 0, which no denominator is.
const fn quotient(a: u128, b: u64) -> u128 {
    match a.checked_div(b as u128) {
        Some(quotient) => quotient,
        None => u128::MAX,
    }
}

impl PartialEq for Ratio {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ratio {}

impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ratio {
    fn cmp(&self, other: &Self) -> Ordering {
        let left = u128::from(self.numerator) * u128::from(other.denominator);
        let right = u128::from(other.numerator) * u128::from(self.denominator);
        left.cmp(&right)
    }
}

impl fmt::Display for Ratio {
    /// Percent with one to four decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut decimals = self.scaled(1_000_000);
        let mut width = 4;
        while width > 1 && decimals.is_multiple_of(10) {
            decimals /= 10;
            width -= 1;
        }
        let unit = 10_u64.pow(width as u32);
        write!(f, "{}.{:0width$}%", decimals / unit, decimals % unit)
    }
}
