//! Dimensionless ratios.

use core::fmt;

/// A deviation in parts per million, signed.
///
/// ```
/// use canbaud::units::Ppm;
/// assert_eq!(Ppm(-478).to_string(), "-478 ppm");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Ppm(pub i32);

impl fmt::Display for Ppm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ppm", self.0)
    }
}

/// A share in thousandths, 0 to 1000: sample points, bus load.
///
/// ```
/// use canbaud::units::Permille;
/// assert_eq!(Permille::new(875).unwrap().to_string(), "87.5%");
/// assert_eq!(Permille::new(1001), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Permille(u16);

impl Permille {
    /// Nothing.
    pub const ZERO: Self = Self(0);

    /// `value` thousandths; `None` above 1000.
    #[must_use]
    pub const fn new(value: u16) -> Option<Self> {
        if value > 1000 { None } else { Some(Self(value)) }
    }

    /// The share in thousandths.
    #[must_use]
    pub const fn permille(self) -> u16 {
        self.0
    }
}

impl fmt::Display for Permille {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}%", self.0 / 10, self.0 % 10)
    }
}
