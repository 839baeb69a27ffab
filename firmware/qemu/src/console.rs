//! Text and the exit code, by semihosting. Without `core::fmt`, which can panic.

use core::arch::asm;

/// How a run ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Everything was as it should be.
    Ok,
    /// Something was not.
    Failed,
}

const SYS_WRITE0: u32 = 0x04;
const SYS_EXIT: u32 = 0x18;
const APPLICATION_EXIT: u32 = 0x2_0026;
const RUN_TIME_ERROR: u32 = 0x2_0023;

/// Prints a text.
pub fn print(text: &str) {
    for chunk in text.as_bytes().chunks(31) {
        let mut buffer = [0_u8; 32];
        for (to, from) in buffer.iter_mut().zip(chunk) {
            *to = *from;
        }
        // SAFETY: SYS_WRITE0 reads up to the zero, and the last byte of the buffer is one.
        unsafe { call(SYS_WRITE0, buffer.as_ptr() as u32) };
    }
}

/// Prints a number in decimal.
pub fn print_number(value: u64) {
    let mut digits = [b'0'; 20];
    let mut rest = value;
    let mut first = 20;
    for (index, digit) in digits.iter_mut().enumerate().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
        first = index;
        if rest == 0 {
            break;
        }
    }
    print(core::str::from_utf8(digits.get(first..).unwrap_or(&[])).unwrap_or("?"));
}

/// Prints a number in hexadecimal with `0x`.
pub fn print_hex(value: u32) {
    print("0x");
    for shift in (0..8).rev() {
        let digit = (value >> (4 * shift)) as u8 & 15;
        let character = [if digit < 10 { b'0' + digit } else { b'A' - 10 + digit }];
        print(core::str::from_utf8(&character).unwrap_or("?"));
    }
}

/// Prints `key value` on a line of its own.
pub fn print_pair(key: &str, value: u64) {
    print(key);
    print(" ");
    print_number(value);
    print("\n");
}

/// Ends the run.
pub fn exit(status: Status) -> ! {
    let reason = match status {
        Status::Ok => APPLICATION_EXIT,
        Status::Failed => RUN_TIME_ERROR,
    };
    loop {
        // SAFETY: SYS_EXIT takes the reason itself, no address.
        unsafe { call(SYS_EXIT, reason) };
    }
}

/// A semihosting call.
///
/// # Safety
/// `argument` must be what `operation` asks for.
unsafe fn call(operation: u32, argument: u32) {
    // SAFETY: the debugger returns in r0 and changes nothing else of the program.
    unsafe {
        asm!("bkpt 0xab", inout("r0") operation => _, in("r1") argument, options(nostack));
    }
}
