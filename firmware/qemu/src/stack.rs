//! How deep the stack was: what is unused is painted, and later one looks how far the paint is.

use core::arch::asm;

const PAINT: u32 = 0xC0DE_CAFE;
/// Left alone below the stack pointer, for the function that paints.
const MARGIN: usize = 256;

unsafe extern "C" {
    /// Where the linker script says that the stack may not go on.
    static _stack_end: u32;
}

/// Most bytes that are painted.
const DEPTH: usize = 12 * 1024;

/// The stack pointer.
#[inline(always)]
fn pointer() -> usize {
    let value: usize;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) value, options(nomem, nostack)) };
    value
}

/// Runs `work`, gives its result and the bytes of stack that it used.
#[inline(never)]
pub fn measure<R>(work: impl FnOnce() -> R) -> (R, usize) {
    let top = pointer() & !3;
    let end = &raw const _stack_end as usize;
    let bottom = top.saturating_sub(DEPTH).max(end.next_multiple_of(4));
    let mut at = bottom;
    while at < top - MARGIN {
        // SAFETY: unused stack: below the stack pointer, above everything static.
        unsafe { (at as *mut u32).write_volatile(PAINT) };
        at += 4;
    }
    let result = work();
    let mut at = bottom;
    // SAFETY: the same words.
    while at < top && unsafe { (at as *const u32).read_volatile() } == PAINT {
        at += 4;
    }
    (result, top - at)
}
