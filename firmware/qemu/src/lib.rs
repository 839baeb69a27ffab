//! What the firmware examples share: output by semihosting, a counter of instructions, a measure
//! of the stack, and recordings to work on.
//!
//! The panic handler calls a function that nobody defines: a firmware that could panic does not
//! link. That it links is the proof.
#![no_std]

pub mod board;
pub mod bus;
pub mod console;
pub mod recordings;
pub mod stack;
pub mod timer;

use core::panic::PanicInfo;

/// With `locate-panics`: the function is there, ends the run with an error, and its callers can be
/// looked for in a disassembly.
#[cfg(feature = "locate-panics")]
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn a_panic_path_was_linked() -> ! {
    console::exit(console::Status::Failed)
}

#[cfg(feature = "locate-panics")]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_path_was_linked()
}

/// Never linked: whoever reaches it makes the linker miss a symbol.
#[cfg(not(feature = "locate-panics"))]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn a_panic_path_was_linked() -> !;
    }
    // SAFETY: the function does not exist, so code that could reach this call does not link.
    unsafe { a_panic_path_was_linked() }
}
