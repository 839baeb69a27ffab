//! tmp
#![no_std]
#![no_main]
use canbaud::detect::PulseDetector;
use canbaud::wire::Logic;
use canbaud_firmware::console::{self, Status};
use canbaud_firmware::recordings::sample;
use cortex_m_rt::entry;
#[entry]
fn main() -> ! {
    let mut edges = [0_u32; 160];
    let (count, end) = sample("stuff-bit-after-crc-data-base-3", 500_000, core::hint::black_box(8_000_000), &mut edges);
    let mut d = PulseDetector::<160>::new();
    d.begin(0, Logic::High);
    for &e in &edges[..count] { d.push(u64::from(e)); }
    d.finish(end);
    core::hint::black_box(d.verdict());
    console::exit(Status::Ok)
}
