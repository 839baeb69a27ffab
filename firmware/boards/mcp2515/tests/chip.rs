//! A scan over a model of the chip on a bus: whatever it is told, it must never transmit.

use canbaud::detect::scan::Controller;
use canbaud::detect::scan::{Candidates, Driver, Outcome, Progress, Scan, Settings};
use canbaud::units::{Hertz, Micros};
use canbaud_mcp2515::{Error, Mcp2515};
use core::convert::Infallible;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use std::cell::RefCell;
use std::rc::Rc;

const CANSTAT: usize = 0x0E;
const CANCTRL: usize = 0x0F;
const CANINTF: usize = 0x2C;

/// The chip: its registers, and the bus that it is on.
struct Chip {
    registers: [u8; 128],
    bus_millibits: u64,
    /// The mode that CANSTAT goes to when it is asked to listen.
    listens: bool,
    /// Modes entered.
    modes: Vec<u8>,
    heard: u8,
}

impl Chip {
    fn on(bus_millibits: u64) -> Self {
        let mut chip =
            Self { registers: [0; 128], bus_millibits, listens: true, modes: Vec::new(), heard: 0 };
        chip.enter(0x80);
        chip
    }

    fn enter(&mut self, mode: u8) {
        assert!(mode == 0x80 || mode == 0x60, "mode {mode:#04x} may transmit");
        self.registers[CANCTRL] = self.registers[CANCTRL] & 0x1F | mode;
        if mode == 0x80 || self.listens {
            self.registers[CANSTAT] = mode;
            self.modes.push(mode);
        }
    }

    fn store(&mut self, register: usize, value: u8) {
        let is_transmit_buffer = [0x30, 0x40, 0x50].contains(&(register & 0x70));
        assert!(!is_transmit_buffer, "a transmit buffer is written: {register:#04x}");
        assert!(register != 0x0D, "TXRTSCTRL is written");
        let configures = matches!(register, 0x00..=0x0B | 0x10..=0x1B | 0x20..=0x2A);
        assert!(
            !configures || self.registers[CANSTAT] == 0x80,
            "{register:#04x} can be written in configuration mode only"
        );
        match register {
            CANCTRL => self.enter(value & 0xE0),
            CANSTAT => {}
            _ => self.registers[register] = value,
        }
    }

    /// The bit rate of CNF1 to CNF3 at 16 MHz, in thousandths of a bit/s [5.1 to 5.6].
    fn millibits(&self) -> u64 {
        let [cnf3, cnf2, cnf1] = [0x28, 0x29, 0x2A].map(|at| u64::from(self.registers[at]));
        assert!(cnf2 & 0x80 != 0, "BTLMODE");
        let quanta = 1 + (1 + (cnf2 & 7)) + (1 + (cnf2 >> 3 & 7)) + (1 + (cnf3 & 7));
        16_000_000_000 / (2 * (1 + (cnf1 & 0x3F)) * quanta)
    }

    /// Something happens on the bus.
    fn traffic(&mut self) {
        if self.registers[CANSTAT] != 0x60 {
            return;
        }
        if self.millibits().abs_diff(self.bus_millibits) * 200 < self.bus_millibits {
            self.heard = self.heard.wrapping_add(1);
            self.registers[0x61..0x67].copy_from_slice(&[0x30, 0x20, 0, 0, 1, self.heard]);
            self.registers[CANINTF] |= 0x01;
        } else {
            self.registers[CANINTF] |= 0x80;
        }
    }

    fn command(&mut self, bytes: &[u8], answer: &mut [u8]) {
        match *bytes {
            [0xC0] => self.enter(0x80),
            [0x03, register] => {
                let from = usize::from(register);
                answer.copy_from_slice(&self.registers[from..from + answer.len()]);
                self.traffic();
            }
            [0x02, register, ref values @ ..] => {
                for (at, value) in (usize::from(register)..).zip(values) {
                    self.store(at, *value);
                }
            }
            [0x05, register, mask, value] => {
                let old = self.registers[usize::from(register)];
                self.store(usize::from(register), old & !mask | value & mask);
            }
            [0x90] => {
                answer.copy_from_slice(&self.registers[0x61..0x61 + answer.len()]);
                self.registers[CANINTF] &= !0x01;
            }
            // RTS is 80h to 87h, LOAD TX BUFFER 40h to 45h.
            _ => panic!("unexpected instruction {bytes:02x?}"),
        }
    }
}

#[derive(Clone)]
struct Spi(Rc<RefCell<Chip>>);

impl ErrorType for Spi {
    type Error = Infallible;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let (mut sent, mut answered) = (Vec::new(), None);
        for operation in operations {
            match operation {
                Operation::Write(bytes) => sent.extend_from_slice(bytes),
                Operation::Read(bytes) => answered = Some(bytes),
                _ => panic!("unexpected operation"),
            }
        }
        let mut nothing = [];
        self.0.borrow_mut().command(&sent, answered.map_or(&mut nothing[..], |bytes| bytes));
        Ok(())
    }
}

fn sixteen_megahertz() -> Hertz {
    Hertz::new(16_000_000).expect("a frequency")
}

#[test]
fn scan_finds_every_rate_of_canopen_and_never_transmits() {
    for bits_per_second in [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000] {
        let chip = Rc::new(RefCell::new(Chip::on(u64::from(bits_per_second) * 1000)));
        let controller = Mcp2515::new(Spi(chip.clone()), sixteen_megahertz()).expect("it answers");
        let candidates = Candidates::<8>::canopen().expect("room");
        let scan = Scan::new(&candidates, &controller.capabilities(), Settings::default());
        let mut now = 0;
        let mut driver = Driver::new(controller, scan, |_: &_| {
            now += 300;
            Micros(now)
        });
        let outcome = (0..100_000)
            .find_map(|_| match driver.turn().expect("the chip does what it is told") {
                Progress::Done(outcome) => Some(outcome),
                Progress::Listening(_) => None,
            })
            .expect("an end");
        let Outcome::Found(found) = outcome else { panic!("{bits_per_second}: {outcome:?}") };
        assert_eq!(found.nominal().bits_per_second(), bits_per_second);
        let chip = chip.borrow();
        assert_eq!(chip.modes.last(), Some(&0x80), "the scan stops the chip");
        assert!(chip.modes.contains(&0x60));
    }
}

#[test]
fn a_chip_that_does_not_enter_listen_only_mode_is_stopped() {
    let chip = Rc::new(RefCell::new(Chip::on(0)));
    chip.borrow_mut().listens = false;
    let mut controller = Mcp2515::new(Spi(chip.clone()), sixteen_megahertz()).expect("it answers");
    let refused = controller.start_monitoring();
    assert_eq!(refused, Err(Error::Mode { asked: 0x60, read: 0x80 }));
    assert_eq!(chip.borrow().registers[CANCTRL] & 0xE0, 0x80);
}
