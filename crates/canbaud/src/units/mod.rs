//! Every quantity has a type that carries its unit.
//!
//! | type | unit | text form |
//! |---|---|---|
//! | [`Bitrate`] | bit/s | `500k`, `1M`, `83.333k` |
//! | [`Hertz`] | Hz | `80M`, `16MHz`, `500 kHz` |
//! | [`Ticks`] with [`Timebase`] | timer ticks | |
//! | [`Micros`] | µs | `1.500 ms` |
//! | [`Ppm`] | 10⁻⁶ | `-478 ppm` |
//! | [`Permille`] | 10⁻³ | `87.5%` |

mod decimal;
mod frequency;
mod micros;
mod ratio;
mod time;

pub use decimal::ParseQuantityError;
pub use frequency::{Bitrate, Hertz};
pub use micros::Micros;
pub use ratio::{Permille, Ppm};
pub use time::{Ticks, Timebase};
