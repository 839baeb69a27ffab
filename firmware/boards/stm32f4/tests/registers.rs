//! What is done with the registers of bxCAN and TIM2, as RM0090 has them, on models of both.

use canbaud::detect::scan::{
    Candidate, Candidates, Controller, Driver, ErrorClass, Observation, Outcome, Progress, Scan,
    Settings,
};
use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud::wire::Logic;
use canbaud_capture_queue::{CaptureQueue, Edge, Taken};
use canbaud_stm32f4::{Bxcan, Capture, Error, Registers};
use std::cell::RefCell;
use std::collections::HashMap;

const MCR: usize = 0x00;
const MSR: usize = 0x04;
const RF0R: usize = 0x0C;
const ESR: usize = 0x18;
const BTR: usize = 0x1C;
const SILM: u32 = 1 << 31;

/// What becomes of a message in FIFO 0 that is released.
#[derive(Clone, Copy, PartialEq)]
enum Fifo {
    Works,
    /// A chip that does not do what it is told.
    NeverEmpties,
}

/// bxCAN on a bus with frames at one rate.
struct Can {
    fifo: Fifo,
    kept: RefCell<HashMap<usize, u32>>,
    bus: u32,
    heard: RefCell<u32>,
}

impl Can {
    /// After reset: asleep.
    fn on(bus: u32) -> Self {
        let kept = [(MCR, 0x0001_0002), (MSR, 0xC02), (BTR, 0x0123_0000), (ESR, 0)];
        Self { fifo: Fifo::Works, kept: RefCell::new(kept.into()), bus, heard: RefCell::new(0) }
    }

    fn at(&self, offset: usize) -> u32 {
        self.kept.borrow().get(&offset).copied().unwrap_or(0)
    }

    fn put(&self, offset: usize, value: u32) {
        self.kept.borrow_mut().insert(offset, value);
    }

    fn is_initializing(&self) -> bool {
        self.at(MSR) & 1 == 1
    }

    /// The bit rate at a PCLK of 42 MHz \[32.7.7\].
    fn bitrate(&self) -> u32 {
        let btr = self.at(BTR);
        let quanta = 1 + (1 + (btr >> 16 & 0xF)) + (1 + (btr >> 20 & 7));
        42_000_000 / ((1 + (btr & 0x3FF)) * quanta)
    }

    /// Something happens on the bus.
    fn traffic(&self) {
        if self.is_initializing() {
            return;
        }
        assert!(self.at(BTR) & SILM != 0, "bxCAN runs and is not silent");
        if self.bitrate().abs_diff(self.bus) < self.bus / 200 {
            *self.heard.borrow_mut() += 1;
            // 0x183 in base format, one byte.
            self.put(0x1B0, 0x183 << 21);
            self.put(0x1B4, 1);
            self.put(0x1B8, *self.heard.borrow() & 0xFF);
            let messages = (self.at(RF0R) & 0b11) + 1;
            self.put(RF0R, self.at(RF0R) & !0b11 | messages.min(3));
        } else {
            self.put(ESR, self.at(ESR) & !(7 << 4) | 1 << 4);
        }
    }
}

impl Registers for Can {
    fn read(&self, offset: usize) -> u32 {
        let value = self.at(offset);
        if offset == ESR {
            self.traffic();
        }
        value
    }

    fn write(&mut self, offset: usize, value: u32) {
        match offset {
            MCR => {
                assert!(value & 1 << 6 == 0, "ABOM is not for a listener");
                self.put(MSR, self.at(MSR) & !3 | value & 3);
                self.put(MCR, value);
            }
            BTR => {
                assert!(self.is_initializing(), "BTR can be written in initialization mode only");
                assert!(value & SILM != 0, "not silent: {value:#010x}");
                assert!(value & 1 << 30 == 0, "loopback");
                self.put(BTR, value);
            }
            RF0R => {
                let messages = self.at(RF0R) & 0b11;
                let is_released = value & 1 << 5 != 0 && self.fifo == Fifo::Works;
                let left = messages.saturating_sub(u32::from(is_released));
                self.put(RF0R, self.at(RF0R) & !(0b11 | value & 0x18) | left);
            }
            // TSR, and the transmit mailboxes.
            0x08 | 0x180..=0x1AC => panic!("{offset:#05x} transmits"),
            _ => self.put(offset, value),
        }
    }
}

fn pclk() -> Hertz {
    Hertz::new(42_000_000).expect("a frequency")
}

fn candidate(bits_per_second: u32) -> Candidate {
    Candidate::classic(Bitrate::new(bits_per_second).expect("a rate"))
}

/// 42 MHz / 6 / 14: BRP 5; the sample point at 12 of 14, so TS1 10 (11 quanta), TS2 1 (2), SJW 1 (2).
#[test]
fn half_a_megabit_from_42_megahertz_is_silent() {
    let mut can = Bxcan::new(Can::on(500_000), pclk());
    can.configure(&candidate(500_000)).expect("it can");
    assert_eq!(can.into_registers().at(BTR), 0x811A_0005);
}

#[test]
fn scan_finds_every_rate_and_is_silent_all_the_time() {
    for bits_per_second in [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 1_000_000] {
        let can = Bxcan::new(Can::on(bits_per_second), pclk());
        let candidates = Candidates::<8>::canopen().expect("room");
        let scan = Scan::new(&candidates, &can.capabilities(), Settings::default());
        let mut now = 0;
        let mut driver = Driver::new(can, scan, |_: &_| {
            now += 300;
            Micros(now)
        });
        let outcome = (0..100_000)
            .find_map(|_| match driver.turn().expect("bxCAN does what it is told") {
                Progress::Done(outcome) => Some(outcome),
                Progress::Listening(_) => None,
            })
            .expect("an end");
        let Outcome::Found(found) = outcome else { panic!("{bits_per_second}: {outcome:?}") };
        assert_eq!(found.nominal().bits_per_second(), bits_per_second);
        assert!(driver.into_controller().into_registers().is_initializing(), "it is stopped");
    }
}

/// 42 MHz / 800 kbit/s are 52.5 periods: a percent off at best.
#[test]
fn a_rate_that_the_clock_cannot_make_is_refused() {
    let mut can = Bxcan::new(Can::on(800_000), pclk());
    let refused = can.configure(&candidate(800_000));
    assert_eq!(refused, Err(Error::Timing(candidate(800_000).nominal)));
}

#[test]
fn listening_without_a_silent_bit_timing_is_refused() {
    let mut can = Bxcan::new(Can::on(500_000), pclk());
    assert_eq!(can.start_monitoring(), Err(Error::ReadBack(0x0123_0000)));
}

/// Three messages of before; their release must end, whatever the chip does.
#[test]
fn listening_begins_with_an_empty_fifo_or_not_at_all() {
    for (fifo, begun) in [(Fifo::Works, Ok(())), (Fifo::NeverEmpties, Err(Error::NotEmptied(3)))] {
        let mut can = Bxcan::new(Can { fifo, ..Can::on(500_000) }, pclk());
        can.configure(&candidate(500_000)).expect("it can");
        let registers = can.into_registers();
        registers.put(RF0R, 3);
        let mut can = Bxcan::new(registers, pclk());
        assert_eq!(can.start_monitoring(), begun);
        let registers = can.into_registers();
        assert_eq!(registers.is_initializing(), begun.is_err(), "it does not listen with an error");
        assert_eq!(registers.at(RF0R) & 3, if begun.is_ok() { 0 } else { 3 });
    }
}

#[test]
fn errors_and_overruns_are_told_once() {
    // Nobody sends at this rate, so all that happens is written here.
    let registers = Can::on(1);
    registers.put(MSR, 1);
    registers.put(ESR, 6 << 4);
    registers.put(RF0R, 1 << 4);
    let mut can = Bxcan::new(registers, pclk());
    assert_eq!(can.observe(Micros(5)), Ok(Some(Observation::Lost)));
    let Ok(Some(Observation::Error(error))) = can.observe(Micros(5)) else { panic!("an error") };
    assert_eq!(error.class, ErrorClass::Crc);
    assert_eq!(can.observe(Micros(6)), Ok(None));
}

/// TIM2: what the interrupt reads, in the order of the edges.
#[derive(Default)]
struct Tim2 {
    kept: HashMap<usize, u32>,
}

impl Registers for Tim2 {
    fn read(&self, offset: usize) -> u32 {
        self.kept.get(&offset).copied().unwrap_or(0)
    }

    fn write(&mut self, offset: usize, value: u32) {
        self.kept.insert(offset, value);
    }
}

/// What the interrupt puts into the queue.
fn captured(status: u32, falling: u32, rising: u32) -> Vec<Edge> {
    let mut timer = Tim2::default();
    timer.kept.extend([(0x10, status), (0x34, falling), (0x38, rising)]);
    let queue = CaptureQueue::<4>::new();
    Capture::new(timer).interrupt(&queue);
    core::iter::from_fn(|| match queue.take() {
        Taken::Edge(edge) => Some(edge),
        Taken::Nothing => None,
        Taken::Lost => panic!("four have room"),
    })
    .collect()
}

#[test]
fn captures_come_in_the_order_of_the_edges() {
    let falling = |stamp| Edge::new(stamp, Logic::Low);
    let rising = |stamp| Edge::new(stamp, Logic::High);
    assert_eq!(captured(0b000, 100, 7), []);
    assert_eq!(captured(0b010, 100, 7), [falling(100)]);
    assert_eq!(captured(0b100, 7, 100), [rising(100)]);
    assert_eq!(captured(0b110, 100, 116), [falling(100), rising(116)]);
    assert_eq!(captured(0b110, 116, 100), [rising(100), falling(116)]);
    // The counter ran over in between.
    assert_eq!(captured(0b110, u32::MAX - 3, 12), [falling(u32::MAX - 3), rising(12)]);
    // Falling, rising, falling: the first one was overwritten.
    assert_eq!(captured(0b110 | 1 << 9, 116, 100), [falling(116).behind_missing()]);
    assert_eq!(captured(0b110 | 1 << 10, 100, 116), [rising(116).behind_missing()]);
}

/// CCMR1: CC1S 01 and CC2S 10 are both TI1; CCER: CC1P is set (falling), CC2P is not (rising), both
/// are enabled; DIER: both interrupts.
#[test]
fn both_edges_of_one_pin_are_captured() {
    let mut timer = Tim2::default();
    {
        let mut capture = Capture::new(&mut timer);
        capture.start();
    }
    assert_eq!(timer.read(0x18) & 0x303, 0x201);
    assert_eq!(timer.read(0x20) & 0xBB, 0x13);
    assert_eq!(timer.read(0x0C), 0b110);
    assert_eq!(timer.read(0x00) & 1, 1);
}
