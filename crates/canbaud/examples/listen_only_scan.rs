//! The driver of a controller as firmware writes it, and a scan that uses it.
//!
//! `cargo run --example listen_only_scan -p canbaud` runs it against a controller made of memory;
//! on a microcontroller `Registers` is the controller's own.

use canbaud::detect::scan::{
    Candidate, Candidates, Capabilities, Configured, Controller, Driver, ErrorClass, ErrorPlace,
    ErrorSeen, Evidence, FdSupport, FrameSeen, Observation, Origin, Outcome, Progress, RateChoice,
    Scan, Settings,
};
use canbaud::timing::controllers::bxcan;
use canbaud::timing::{Request, Solution, solve};
use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud::wire::{Frame, FrameKind, Id};

/// What a bxCAN-like controller has, as far as a scan needs it.
#[derive(Default)]
struct Registers {
    initializing: bool,
    silent: bool,
    timing: Option<Solution>,
    fifo: Option<Frame>,
    /// LEC: 0 none, 1 stuff, 2 form, 3 ACK, 4 and 5 bit, 6 CRC; 7 is set by software.
    last_error: u8,
}

/// The clock of the CAN peripheral.
const CLOCK: Hertz = match Hertz::new(36_000_000) {
    Some(hertz) => hertz,
    None => unreachable!(),
};
const SLOWEST: Bitrate = match Bitrate::new(5_000) {
    Some(rate) => rate,
    None => unreachable!(),
};
const FASTEST: Bitrate = match Bitrate::new(1_000_000) {
    Some(rate) => rate,
    None => unreachable!(),
};

/// A driver that knows no way to transmit.
struct Listener {
    registers: Registers,
}

#[derive(Debug)]
enum DriverError {
    /// The clock cannot make the rate.
    Rate,
}

impl Controller for Listener {
    type Error = DriverError;

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            rates: RateChoice::Between(SLOWEST, FASTEST),
            // LEC says what the last error was, in silent mode, too.
            evidence: Evidence::Errors,
            fd: FdSupport::Classic,
            reconfiguration: Micros(200),
            latency: Micros(50),
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, DriverError> {
        let request = Request::new(CLOCK, candidate.nominal);
        let solution = solve(&request, &bxcan::NOMINAL).map_err(|_| DriverError::Rate)?;
        self.registers.initializing = true;
        // CAN_BTR is written here; its SILM bit with it, so that there is no moment in between.
        self.registers.timing = Some(solution);
        self.registers.silent = true;
        Ok(Configured { nominal: candidate.nominal, data: None })
    }

    fn start_monitoring(&mut self) -> Result<(), DriverError> {
        self.registers.fifo = None;
        self.registers.last_error = 7;
        self.registers.initializing = false;
        Ok(())
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, DriverError> {
        let received = Some(now);
        if let Some(frame) = self.registers.fifo.take() {
            let seen = FrameSeen { frame, origin: Origin::Bus, received };
            return Ok(Some(Observation::Frame(seen)));
        }
        let class = match core::mem::replace(&mut self.registers.last_error, 7) {
            1 => ErrorClass::Stuff,
            2 => ErrorClass::Form,
            3 => ErrorClass::Acknowledge,
            4 | 5 => ErrorClass::Bit,
            6 => ErrorClass::Crc,
            _ => return Ok(None),
        };
        // This controller does not say where.
        let seen = ErrorSeen { class, place: ErrorPlace::Unknown, received };
        Ok(Some(Observation::Error(seen)))
    }

    fn stop(&mut self) -> Result<(), DriverError> {
        self.registers.initializing = true;
        Ok(())
    }
}

/// A bus of 250 kbit/s: what the controller would hear of it from `now` on.
fn bus(registers: &mut Registers, now: Micros) {
    let listens = registers.silent && !registers.initializing;
    // A frame every 2 ms.
    if !listens || now.0 % 2_000 != 500 {
        return;
    }
    let rate = registers.timing.map(|solution| solution.bitrate.bits_per_second());
    if rate == Some(250_000) {
        let data = (now.0 as u32).to_be_bytes();
        registers.fifo = Frame::new(Id::Base(0x181), FrameKind::Data, 4, &data).ok();
    } else {
        registers.last_error = 1;
    }
}

fn main() {
    let listener = Listener { registers: Registers::default() };
    let candidates = Candidates::<8>::canopen().expect("room for eight");
    let scan = Scan::new(&candidates, &listener.capabilities(), Settings::default());
    println!("{} bytes; an answer within {}", size_of_val(&scan), scan.bound().expect("one"));

    // A timer of 100 us stands for the clock; on a microcontroller the loop sleeps in between.
    let time = core::cell::Cell::new(Micros(0));
    let mut driver = Driver::new(listener, scan, |_| time.get());
    let outcome = loop {
        match driver.turn().expect("this clock makes all eight rates") {
            Progress::Done(outcome) => break outcome,
            Progress::Listening(_) => {
                time.set(time.get() + Micros(100));
                bus(&mut driver.controller_mut().registers, time.get());
            }
        }
    };
    let Outcome::Found(found) = outcome else { panic!("{outcome:?}") };
    println!("{}: {} frames, {}", found.nominal(), found.frames, found.elapsed);
    assert_eq!(found.nominal().to_string(), "250k");
}
