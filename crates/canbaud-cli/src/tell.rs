//! Lines for people, on the standard error. Whoever closed the other end is not waited for, and
//! nothing here panics: what was changed must still be put back.

use crate::outlet::Outlet;

/// A line on the standard error.
macro_rules! tell {
    ($($text:tt)*) => { $crate::tell::error(&format!("{}\n", format_args!($($text)*))) };
}
pub(crate) use tell;

/// `text` as it is.
pub(crate) fn error(text: &str) {
    let _ = Outlet::Errors.write(text, None);
}
