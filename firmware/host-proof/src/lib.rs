//! All of canbaud in a library for this machine. The panic handler calls a function that nobody
//! defines, so it links only if nothing in it can panic.
#![no_std]

use core::panic::PanicInfo;

/// Feeds bytes to every part of canbaud.
///
/// # Safety
/// `bytes` must point to `len` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_exercise(bytes: *const u8, len: usize) -> u32 {
    // SAFETY: the caller says so.
    canbaud_exercise::exercise(unsafe { core::slice::from_raw_parts(bytes, len) })
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn a_panic_path_was_linked() -> !;
    }
    // SAFETY: the function does not exist, so code that could reach this call does not link.
    unsafe { a_panic_path_was_linked() }
}

/// The unwinding tables of the standard library name it; nothing unwinds here.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}
