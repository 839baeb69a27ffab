//! Why a configuration does not fit the registers, or registers make no configuration.

use core::fmt;

use super::Phase;
use crate::timing::Violation;

/// Why packing or unpacking failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RegisterError {
    /// A value does not fit its field.
    Field {
        /// Register.
        register: &'static str,
        /// Field.
        field: &'static str,
        /// The value.
        value: i32,
        /// Lowest value that fits.
        min: i32,
        /// Highest value that fits.
        max: i32,
    },
    /// A setting is outside the limits of the controller.
    Limits(Violation),
    /// The controller has no such phase.
    NoPhase(Phase),
    /// All phases share one prescaler, but the configuration has two.
    SharedPrescaler {
        /// Prescaler of the nominal phase.
        nominal: u16,
        /// Prescaler of another phase.
        other: u16,
    },
    /// A TDC offset outside what the controller takes.
    TdcOffset {
        /// The offset in clock periods.
        offset: i16,
        /// The highest that fits.
        max: i16,
    },
    /// Reserved bits are set.
    Reserved {
        /// Register.
        register: &'static str,
        /// The bits.
        bits: u32,
    },
    /// The word is wider than the register.
    TooWide {
        /// Register.
        register: &'static str,
        /// The word.
        word: u32,
        /// Width of the register.
        bits: u8,
    },
    /// No register with this content was given.
    Missing {
        /// What is missing.
        what: &'static str,
    },
    /// The register layout of this controller is not known.
    NoRegisters,
}

impl fmt::Display for RegisterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field { register, field, value, min, max } if min == max => {
                write!(f, "{register}.{field} is {value} and must be {min}")
            }
            Self::Field { register, field, value, min, max } => {
                write!(f, "{register}.{field} cannot hold {value} (it holds {min} to {max})")
            }
            Self::Limits(violation) => write!(f, "{violation}"),
            Self::NoPhase(phase) => write!(f, "the controller has no {phase} phase"),
            Self::SharedPrescaler { nominal, other } => {
                write!(f, "the phases share one prescaler, but {nominal} and {other} are asked for")
            }
            Self::TdcOffset { offset, max } => {
                write!(f, "transmitter delay compensation offset {offset} outside 0 to {max}")
            }
            Self::Reserved { register, bits } => {
                write!(f, "reserved bits {bits:#x} of {register} are set")
            }
            Self::TooWide { register, word, bits } => {
                write!(f, "{word:#x} is wider than the {bits} bits of {register}")
            }
            Self::Missing { what } => write!(f, "no register with {what} was given"),
            Self::NoRegisters => f.write_str("the register layout of this controller is not known"),
        }
    }
}

impl core::error::Error for RegisterError {}
