//! The capture interrupt as a board has it, for counting its cycles: TIM2 of an STM32F0, falling edges
//! of RXD in channel 1 and rising edges in channel 2, both from the same pin (PWM input without the
//! reset of the counter).
//!
//! Each polarity has a register of its own, so an edge is lost only if the next one of the same
//! polarity, two bits later, comes before it was read. `scripts/firmware` counts the cycles.
#![no_std]
#![no_main]

use canbaud_firmware as _;
use core::arch::naked_asm;
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::entry;

/// Times of edges, as a ring: more than any classic frame has.
static STAMPS: [AtomicU32; 256] = [const { AtomicU32::new(0) }; 256];

/// Where the next time goes, in bytes, and the capture register that it will be in: TIM2_CCR1 at
/// first. The main loop reads the first.
static NEXT: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0x4000_0034)];

/// One interrupt an edge: the registers take turns, and reading one clears its flag. If the other flag
/// is up by then, the interrupt is entered again at once (tail-chained).
///
/// In assembly, because every cycle counts at 500 kbit/s on 16 MHz: hardware has saved r0 to r3.
///
/// # Safety
/// Only the hardware calls it.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn capture() {
    naked_asm!(
        "ldr  r3, ={next}",
        "ldr  r0, [r3]",
        "ldr  r1, [r3, #4]",
        "ldr  r2, [r1]",
        "ldr  r1, ={stamps}",
        "str  r2, [r1, r0]",
        "adds r0, #4",
        // The ring has 2^10 bytes.
        "lsls r0, r0, #22",
        "lsrs r0, r0, #22",
        "str  r0, [r3]",
        // CCR1 is at ..34, CCR2 at ..38.
        "ldr  r1, [r3, #4]",
        "movs r2, #0x0C",
        "eors r1, r2",
        "str  r1, [r3, #4]",
        "bx   lr",
        next = sym NEXT,
        stamps = sym STAMPS,
    )
}

#[entry]
fn main() -> ! {
    black_box(capture as *const ());
    loop {
        let [written, _] = &NEXT;
        let at = written.load(Ordering::Relaxed) / 4;
        black_box(STAMPS.get(at as usize).map(|stamp| stamp.load(Ordering::Relaxed)));
    }
}
