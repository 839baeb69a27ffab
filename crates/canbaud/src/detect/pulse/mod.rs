//! The rate from edges alone.
//!
//! `segment` cuts the runs into stretches that may be frames, without knowing a bit time;
//! `coarse` and `comb` propose bit times for one of them; `data_rate` does the same for the data
//! phase of CAN FD; `glitch` takes out runs too short to be bits; `prove` reads the frame at each proposal until a CRC is right and all
//! edges lie on the grid (`lattice`); `measure` and
//! `interval` turn the edges of proven frames into a bit time with its uncertainty. [`PulseDetector`] is all of it.

mod bit_times;
mod coarse;
mod comb;
mod data_rate;
mod detector;
mod glitch;
mod interval;
mod lattice;
mod measure;
mod minimum;
mod places;
mod proposals;
mod prove;
mod segment;

pub use data_rate::find_data_rate;
pub use detector::PulseDetector;
pub use measure::Measurement;
pub use minimum::MinimumPulse;
