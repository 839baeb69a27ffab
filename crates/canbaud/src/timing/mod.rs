//! Bit timing: from a wish (clock, bit rate, sample point) to the exact best setting of a
//! controller and the words for its registers, and back.
//!
//! In: [`Request`] and [`Limits`]. Out: [`Solution`] with a [`BitTiming`] of real values.
//! Never: a rounded comparison, a float, a value masked to fit a field.
//! Minus-one encodings live in [`controllers`] only.
//!
//! ```
//! use canbaud::timing::{controllers::bxcan, solve, Request};
//! use canbaud::units::{Bitrate, Hertz};
//!
//! let request = Request::new(Hertz::new(36_000_000).unwrap(), Bitrate::new(500_000).unwrap());
//! let solution = solve(&request, &bxcan::NOMINAL).unwrap();
//! assert_eq!((solution.timing.prescaler, solution.timing.quanta()), (9, 8));
//! assert_eq!(solution.timing.sample_point().to_string(), "87.5%");
//! assert_eq!(solution.bitrate_error_ppb(), 0);
//! ```
//!
//! In a `const` context an impossible request does not compile; the message says why:
//!
//! ```
//! use canbaud::{bit_timing, timing::controllers::m_can};
//! const TIMING: canbaud::timing::BitTiming = bit_timing!(80_000_000, 500_000, m_can::NOMINAL);
//! assert_eq!(TIMING.quanta(), 160);
//! ```
//!
//! ```compile_fail
//! use canbaud::{bit_timing, timing::controllers::bxcan};
//! // error: evaluation panicked: bit timing: the bit rate is too high for this clock
//! const TIMING: canbaud::timing::BitTiming = bit_timing!(1_000_000, 1_000_000, bxcan::NOMINAL);
//! ```

mod bit;
pub mod controllers;
pub mod doctor;
mod error;
pub mod fd;
mod limits;
mod macros;
pub mod physics;
pub mod physics_bus;
pub mod physics_fit;
mod prescalers;
mod rank;
mod ratio;
mod request;
mod search;
mod solutions;
mod solve;
pub mod tables;
pub mod tdc;
pub mod xl;

pub use bit::{BitTiming, Rate, RateWords};
pub use error::SolveError;
pub use limits::{Limits, Rules, Span, Violation};
pub use macros::solve_raw;
pub use prescalers::{PrescalerSpan, Prescalers};
pub use ratio::Ratio;
pub use request::{Request, SamplePointPolicy, SjwPolicy, default_sample_point};
pub use search::CLOCK_MAX;
pub use solutions::{Solutions, solutions, solutions_where};
pub use solve::{Solution, solve};
