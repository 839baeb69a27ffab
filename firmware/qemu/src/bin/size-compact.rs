//! The compact detector with CRC proof.
#![no_std]
#![no_main]

use canbaud::detect::{CompactDetector, Verdict};
use canbaud::wire::Logic;
use canbaud_firmware::board::port;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let mut detector = CompactDetector::<128>::new();
    detector.begin(0, Logic::High);
    let mut at = 0_u64;
    loop {
        at = at.wrapping_add(u64::from(port::read()));
        detector.push(at);
        if let Verdict::Found(found) = detector.verdict() {
            port::write(found.nominal.ticks_q20 as u32);
        }
    }
}
