//! All features of the library in one firmware. That it links proves that nothing in it panics;
//! `scripts/firmware` looks for float helpers and allocation among its symbols.
#![no_std]
#![no_main]

use canbaud_firmware::console::{self, Status, print_pair};
use core::hint::black_box;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    // Different bytes lead through different parts; each run comes to an end.
    let mut bytes = [0_u8; 256];
    let mut state = 0x9E37_79B9_u32;
    for _ in 0..8 {
        for byte in &mut bytes {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            *byte = state as u8;
        }
        print_pair("proof", u64::from(canbaud_exercise::exercise(black_box(&bytes))));
    }
    console::exit(Status::Ok)
}
