//! The method of AP2925, without its table of rates.
#![no_std]
#![no_main]

use canbaud::detect::MinimumPulse;
use canbaud_firmware::board::port;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let mut detector = MinimumPulse::new();
    loop {
        detector.push(port::read());
        port::write(detector.shortest().unwrap_or(0));
    }
}
