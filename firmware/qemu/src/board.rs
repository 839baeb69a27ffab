//! A counter of instructions: SysTick under `-icount`, where time follows the instructions.

use core::arch::asm;
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

const SYSTICK_MAX: u32 = 0x00FF_FFFF;
/// Rounds of the loop that is timed to learn how many ticks an instruction takes.
const CALIBRATION_ROUNDS: u32 = 100_000;

/// Counts instructions; up to some millions at a time.
#[derive(Debug, Clone, Copy)]
pub struct Counter {
    /// Ticks that the calibration loop took.
    calibration: u32,
    /// Ticks that an empty measurement takes.
    overhead: u32,
}

impl Counter {
    /// Starts SysTick and learns what a tick is worth.
    #[must_use]
    pub fn new() -> Self {
        // SAFETY: called once, before anything else uses the core peripherals.
        let mut systick = unsafe { Peripherals::steal() }.SYST;
        systick.set_clock_source(SystClkSource::Core);
        systick.set_reload(SYSTICK_MAX);
        systick.clear_current();
        systick.enable_counter();
        let mut counter = Self { calibration: 0, overhead: 0 };
        counter.overhead = ticks_of(|| ()).1;
        counter.calibration = ticks_of(calibrate).1 - counter.overhead;
        counter
    }

    /// Runs `work`, gives its result and the instructions that it took.
    pub fn count<R>(&self, work: impl FnOnce() -> R) -> (R, u64) {
        let (result, ticks) = ticks_of(work);
        let ticks = u64::from(ticks.saturating_sub(self.overhead));
        let instructions = ticks * u64::from(2 * CALIBRATION_ROUNDS);
        let calibration = u64::from(self.calibration).max(1);
        (result, (instructions + calibration / 2) / calibration)
    }
}

impl Default for Counter {
    fn default() -> Self {
        Self::new()
    }
}

#[inline(never)]
fn ticks_of<R>(work: impl FnOnce() -> R) -> (R, u32) {
    let before = SYST::get_current();
    let result = work();
    let after = SYST::get_current();
    (result, before.wrapping_sub(after) & SYSTICK_MAX)
}

/// Two instructions a round.
fn calibrate() {
    // SAFETY: counts a register down to zero.
    unsafe {
        asm!("2:", "subs {n}, #1", "bne 2b", n = inout(reg) CALIBRATION_ROUNDS => _,
            options(nomem, nostack));
    }
}

/// A register of the outside world, as far as the compiler can tell: for firmware whose size is
/// measured.
pub mod port {
    use core::sync::atomic::{AtomicU32, Ordering};

    static PORT: AtomicU32 = AtomicU32::new(0);

    /// Reads it.
    #[inline(never)]
    pub fn read() -> u32 {
        PORT.load(Ordering::SeqCst)
    }

    /// Writes it.
    #[inline(never)]
    pub fn write(value: u32) {
        PORT.store(value, Ordering::SeqCst);
    }
}
