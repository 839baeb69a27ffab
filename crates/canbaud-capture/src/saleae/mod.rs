//! Saleae: binary exports of Logic 2 and Logic 1. (CSV exports are in `csv`.)

pub(crate) mod binary;
pub(crate) mod logic1;
