//! Random recordings of a CAN line with their truth, for the accuracy harness and for tests.
//!
//! A [`trial::Trial`] is drawn from a seed and a number; [`trial::Trial::record`] plays it on a
//! time axis and quantises it; [`judge::judge`] compares a verdict with the truth;
//! [`bound::Bound`] says how well any estimator could do on the same edges.
#![allow(dead_code, unreachable_pub, reason = "each target that includes this uses a part of it")]

pub mod bound;
pub mod content;
pub mod foreign;
pub mod interval;
pub mod judge;
pub mod line;
pub mod prng;
pub mod sender;
pub mod trial;
