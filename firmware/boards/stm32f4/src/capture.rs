//! TIM2 captures both edges of RXD \[RM0090, chapter 18\].
//!
//! "PWM input" without its reset of the counter: channel 1 captures falling edges, channel 2 rising
//! ones, both from TI1, which is PA0. So each polarity has a register of its own, and an edge is lost
//! only if the second next one comes before the interrupt has read it: two bits.

use crate::registers::Registers;

const CR1: usize = 0x00;
const DIER: usize = 0x0C;
const SR: usize = 0x10;
const EGR: usize = 0x14;
const CCMR1: usize = 0x18;
const CCER: usize = 0x20;
const CNT: usize = 0x24;
const PSC: usize = 0x28;
const ARR: usize = 0x2C;
const CCR1: usize = 0x34;
const CCR2: usize = 0x38;

/// SR and DIER: captures of channel 1 and 2; SR: captures that were overwritten.
const CC1: u32 = 1 << 1;
const CC2: u32 = 1 << 2;
const OVERCAPTURES: u32 = 0b11 << 9;

/// The timer.
#[derive(Debug)]
pub struct Capture<R> {
    registers: R,
}

/// What one interrupt found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Captured {
    /// The edges, in the order in which they came; there may be two.
    Edges(Option<u32>, Option<u32>),
    /// At least one is missing.
    Lost,
}

impl<R: Registers> Capture<R> {
    /// Over the registers of TIM2, whose clock is on.
    pub const fn new(registers: R) -> Self {
        Self { registers }
    }

    /// Counts every period of the timer clock and captures from now on.
    pub fn start(&mut self) {
        const ON_TI1: u32 = 0b01;
        const ON_TI1_TOO: u32 = 0b10 << 8;
        // Two samples must agree: a glitch below 24 ns at 84 MHz is no edge.
        const FILTERS: u32 = 0b0001 << 4 | 0b0001 << 12;
        const FALLING: u32 = 1 << 1;
        const ENABLED: u32 = 1 | 1 << 4;
        self.registers.write(PSC, 0);
        self.registers.write(ARR, u32::MAX);
        self.registers.write(CCMR1, ON_TI1 | ON_TI1_TOO | FILTERS);
        self.registers.write(CCER, FALLING | ENABLED);
        self.registers.write(EGR, 1);
        self.registers.write(SR, 0);
        self.registers.write(DIER, CC1 | CC2);
        self.registers.write(CR1, 1);
    }

    /// Captures no more.
    pub fn stop(&mut self) {
        self.registers.write(DIER, 0);
        self.registers.write(CR1, 0);
    }

    /// The counter.
    pub fn now(&self) -> u32 {
        self.registers.read(CNT)
    }

    /// The interrupt: takes what was captured.
    pub fn interrupt(&mut self) -> Captured {
        let status = self.registers.read(SR);
        // Reading a capture register clears its flag.
        let falling = (status & CC1 != 0).then(|| self.registers.read(CCR1));
        let rising = (status & CC2 != 0).then(|| self.registers.read(CCR2));
        if (status | self.registers.read(SR)) & OVERCAPTURES != 0 {
            self.registers.write(SR, !OVERCAPTURES);
            return Captured::Lost;
        }
        match (falling, rising) {
            (Some(a), Some(b)) if (b.wrapping_sub(a) as i32) < 0 => {
                Captured::Edges(Some(b), Some(a))
            }
            (falling, rising) => Captured::Edges(falling.or(rising), falling.and(rising)),
        }
    }
}
