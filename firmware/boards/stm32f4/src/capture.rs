//! TIM2 captures both edges of RXD \[RM0090, chapter 18\].
//!
//! "PWM input" without its reset of the counter: channel 1 captures falling edges, channel 2 rising
//! ones, both from TI1, which is PA0. So each polarity has a register of its own, and an edge is lost
//! only if the second next one comes before the interrupt has read it: two bits.

use crate::registers::Registers;
use canbaud::wire::Logic;
use canbaud_capture_queue::{CaptureQueue, Edge};

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

impl<R: Registers> Capture<R> {
    /// Over the registers of TIM2, whose clock is on.
    pub const fn new(registers: R) -> Self {
        Self { registers }
    }

    /// Counts every period of the timer clock from 0, and captures every edge from then on; what was
    /// captured before is forgotten.
    pub fn start(&mut self) {
        const ON_TI1: u32 = 0b01;
        const ON_TI1_TOO: u32 = 0b10 << 8;
        // Two samples must agree: a glitch below 24 ns at 84 MHz is no edge.
        const FILTERS: u32 = 0b0001 << 4 | 0b0001 << 12;
        const FALLING: u32 = 1 << 1;
        const ENABLED: u32 = 1 | 1 << 4;
        const UPDATE: u32 = 1;
        self.stop();
        self.registers.write(PSC, 0);
        self.registers.write(ARR, u32::MAX);
        // CC1S and CC2S can be written while the channels are off only.
        self.registers.write(CCMR1, ON_TI1 | ON_TI1_TOO | FILTERS);
        self.registers.write(EGR, UPDATE);
        self.registers.write(SR, 0);
        self.registers.write(DIER, CC1 | CC2);
        // The channels first: there is no tick without them.
        self.registers.write(CCER, FALLING | ENABLED);
        self.registers.write(CR1, 1);
    }

    /// Captures and counts no more.
    pub fn stop(&mut self) {
        self.registers.write(DIER, 0);
        self.registers.write(CCER, 0);
        self.registers.write(CR1, 0);
    }

    /// The counter.
    pub fn now(&self) -> u32 {
        self.registers.read(CNT)
    }

    /// The interrupt: puts what was captured into the queue, in the order of the edges.
    pub fn interrupt<const N: usize>(&mut self, queue: &CaptureQueue<N>) {
        let status = self.registers.read(SR);
        // Reading a capture register clears its flag.
        let falling = (status & CC1 != 0).then(|| self.falling());
        let rising = (status & CC2 != 0).then(|| self.rising());
        if (status | self.registers.read(SR)) & OVERCAPTURES != 0 {
            queue.put(self.newest_behind_overcapture());
            return;
        }
        let (first, second) = match (falling, rising) {
            (Some(falling), Some(rising)) => {
                let (first, second) = in_order(falling, rising);
                (Some(first), Some(second))
            }
            (falling, rising) => (falling.or(rising), None),
        };
        first.into_iter().chain(second).for_each(|edge| queue.put(edge));
    }

    /// Which edges are missing is not known, but from the newest on nothing is.
    fn newest_behind_overcapture(&mut self) -> Edge {
        // The flags first: an overcapture from here on is seen by the next interrupt.
        self.registers.write(SR, !OVERCAPTURES);
        in_order(self.falling(), self.rising()).1.behind_missing()
    }

    fn falling(&self) -> Edge {
        Edge::new(self.registers.read(CCR1), Logic::Low)
    }

    fn rising(&self) -> Edge {
        Edge::new(self.registers.read(CCR2), Logic::High)
    }
}

/// The earlier of two edges comes first; the counter may have begun again in between.
const fn in_order(a: Edge, b: Edge) -> (Edge, Edge) {
    if (b.stamp.wrapping_sub(a.stamp) as i32) < 0 { (b, a) } else { (a, b) }
}
