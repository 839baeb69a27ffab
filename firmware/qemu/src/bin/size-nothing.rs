//! What a firmware costs in which there is nothing: the other sizes are counted from here.
#![no_std]
#![no_main]

use canbaud_firmware::board::port;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    loop {
        port::write(port::read());
    }
}
