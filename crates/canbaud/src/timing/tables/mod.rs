//! Bit timing tables: for autobaud by a timer, and those of the source documents.

mod ap2925;
mod autobaud;
mod canopen;
mod ds80c390;

pub use ap2925::{AP2925, Ap2925Row, Misprint};
pub use autobaud::{
    AutobaudError, AutobaudRow, AutobaudTable, Deviation, TickWindow, tick_windows,
};
pub use canopen::{CANOPEN, CANOPEN_TIMER_TICKS, CanopenRow, TimerTicksRow};
pub use ds80c390::{DS80C390, Ds80c390Misprint, Ds80c390Row};
