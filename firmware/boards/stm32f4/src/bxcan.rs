//! bxCAN that only listens: silent mode \[RM0090, chapter 32\].
//!
//! In silent mode the acknowledge and error flags stay inside the controller; its output is recessive
//! whatever it does. The driver sets SILM together with the bit timing, before bxCAN leaves
//! initialization mode, and never writes a transmit mailbox. On top of that `main.rs` does not even
//! connect the pin.

use crate::registers::Registers;
use canbaud::detect::scan::{
    Candidate, Capabilities, Capture, Configured, Controller, ErrorClass, ErrorPlace, ErrorSeen,
    Evidence, FdSupport, FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::timing::controllers::{Configuration, bxcan};
use canbaud::timing::{Request, SamplePointPolicy, solve};
use canbaud::units::{Bitrate, Hertz, Micros, Permille};
use canbaud::wire::{Frame, FrameKind, Id};

const MCR: usize = 0x00;
const MSR: usize = 0x04;
const RF0R: usize = 0x0C;
const ESR: usize = 0x18;
const BTR: usize = 0x1C;
const RI0R: usize = 0x1B0;
const RDT0R: usize = 0x1B4;
const RDL0R: usize = 0x1B8;
const RDH0R: usize = 0x1BC;
const FMR: usize = 0x200;
const FS1R: usize = 0x20C;
const FA1R: usize = 0x21C;
const F0R1: usize = 0x240;
const F0R2: usize = 0x244;

/// MCR: request for initialization mode; MSR: it is entered.
const INRQ: u32 = 1;
const INAK: u32 = 1;
/// RF0R: messages in the FIFO, overrun (cleared by 1), release (by 1).
const FMP0: u32 = 0b11;
const FOVR0: u32 = 1 << 4;
const RFOM0: u32 = 1 << 5;
/// ESR: last error code; 7 is written by software to see the next one.
const LEC: u32 = 0b111 << 4;
/// BTR: silent.
const SILM: u32 = 1 << 31;
/// Entering initialization mode waits for the frame on the bus, 13 ms at 10 kbit/s: enough reads for
/// that at 168 MHz and some cycles each.
const INIT_READS: u32 = 4_000_000;
/// FIFO 0 has three messages, and a release takes some cycles.
const RELEASE_READS: u32 = 1_000;

/// What can go wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error {
    /// The bit timing cannot be made from PCLK.
    Timing(Bitrate),
    /// Initialization mode was not entered: no clock for CAN1, or RXD stuck dominant.
    NotInitialized,
    /// FIFO 0 did not become empty; RF0R reads this.
    NotEmptied(u32),
    /// BTR did not keep this word: it can be written in initialization mode only.
    ReadBack(u32),
}

/// bxCAN that only listens.
#[derive(Debug)]
pub struct Bxcan<R> {
    registers: R,
    pclk: Hertz,
}

impl<R: Registers> Bxcan<R> {
    /// Over the registers of CAN1, whose clock is on; `pclk` is that of its bus (APB1).
    pub const fn new(registers: R, pclk: Hertz) -> Self {
        Self { registers, pclk }
    }

    /// Gives the registers back.
    pub fn into_registers(self) -> R {
        self.registers
    }

    fn enter_initialization(&mut self) -> Result<(), Error> {
        // Out of sleep, and nothing automatic.
        self.registers.write(MCR, INRQ);
        match (0..INIT_READS).any(|_| self.registers.read(MSR) & INAK != 0) {
            true => Ok(()),
            false => Err(Error::NotInitialized),
        }
    }

    /// Filter bank 0 takes everything into FIFO 0: a mask of 0 of 32 bits.
    fn accept_everything(&mut self) {
        const FINIT: u32 = 1;
        const BANK_0: u32 = 1;
        self.registers.modify(FMR, 0, FINIT);
        self.registers.modify(FA1R, BANK_0, 0);
        self.registers.modify(FS1R, 0, BANK_0);
        self.registers.write(F0R1, 0);
        self.registers.write(F0R2, 0);
        self.registers.modify(FA1R, 0, BANK_0);
        self.registers.modify(FMR, FINIT, 0);
    }

    /// Releases what is in FIFO 0.
    fn empty_fifo(&mut self) -> Result<(), Error> {
        for _ in 0..RELEASE_READS {
            if self.registers.read(RF0R) & FMP0 == 0 {
                return Ok(());
            }
            self.registers.write(RF0R, RFOM0);
        }
        Err(Error::NotEmptied(self.registers.read(RF0R)))
    }

    /// The frame at the front of FIFO 0, which is then released.
    fn receive(&mut self) -> Option<Frame> {
        let [id, length, low, high] = [RI0R, RDT0R, RDL0R, RDH0R].map(|at| self.registers.read(at));
        self.registers.write(RF0R, RFOM0);
        let is_extended = id & 0b100 != 0;
        let identifier =
            if is_extended { Id::extended(id >> 3) } else { Id::base((id >> 21) as u16) };
        let kind = if id & 0b10 != 0 { FrameKind::Remote } else { FrameKind::Data };
        let dlc = length as u8 & 0xF;
        let data = (u64::from(high) << 32 | u64::from(low)).to_le_bytes();
        let data = data.get(..Frame::data_length(kind, dlc))?;
        Frame::new(identifier?, kind, dlc, data).ok()
    }
}

impl<R: Registers> Controller for Bxcan<R> {
    type Error = Error;

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            rates: RateChoice::Between(LOWEST, HIGHEST),
            evidence: Evidence::Errors,
            fd: FdSupport::Classic,
            reconfiguration: Micros::from_ms(14),
            latency: Micros(0),
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, Error> {
        let bitrate = candidate.nominal;
        let mut request = Request::new(self.pclk, bitrate);
        if let (Capture::Wide, Some(point)) = (candidate.capture, Permille::new(750)) {
            request = request.with_sample_point(point, SamplePointPolicy::NotLater);
        }
        let solution = solve(&request, &bxcan::NOMINAL).map_err(|_| Error::Timing(bitrate))?;
        let word = bxcan::BTR
            .pack(&Configuration::classic(solution.timing))
            .map_err(|_| Error::Timing(bitrate))?;
        self.enter_initialization()?;
        self.registers.write(BTR, word | SILM);
        let kept = self.registers.read(BTR);
        if kept != word | SILM {
            return Err(Error::ReadBack(kept));
        }
        let really = (solution.rate.millibits_per_second() + 500) / 1000;
        let really = u32::try_from(really).ok().and_then(Bitrate::new);
        Ok(Configured { nominal: really.unwrap_or(bitrate), data: None })
    }

    fn start_monitoring(&mut self) -> Result<(), Error> {
        let word = self.registers.read(BTR);
        if word & SILM == 0 || self.registers.read(MSR) & INAK == 0 {
            return Err(Error::ReadBack(word));
        }
        self.accept_everything();
        self.empty_fifo()?;
        self.registers.write(RF0R, FOVR0);
        self.registers.modify(ESR, 0, LEC);
        // bxCAN takes part in the bus traffic, as a listener, after 11 recessive bits.
        self.registers.write(MCR, 0);
        Ok(())
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, Error> {
        let fifo = self.registers.read(RF0R);
        if fifo & FOVR0 != 0 {
            self.registers.write(RF0R, FOVR0);
            return Ok(Some(Observation::Lost));
        }
        if fifo & FMP0 != 0 {
            let seen = self.receive().map(|frame| {
                Observation::Frame(FrameSeen { frame, origin: Origin::Bus, received: None })
            });
            return Ok(seen);
        }
        let class = match (self.registers.read(ESR) & LEC) >> 4 {
            1 => ErrorClass::Stuff,
            2 => ErrorClass::Form,
            3 => ErrorClass::Acknowledge,
            4 | 5 => ErrorClass::Bit,
            6 => ErrorClass::Crc,
            // No error since the last look, or none yet.
            _ => return Ok(None),
        };
        self.registers.modify(ESR, 0, LEC);
        let place = ErrorPlace::Unknown;
        Ok(Some(Observation::Error(ErrorSeen { class, place, received: Some(now) })))
    }

    fn stop(&mut self) -> Result<(), Error> {
        self.enter_initialization()
    }
}

const LOWEST: Bitrate = rate(5_000);
const HIGHEST: Bitrate = rate(1_000_000);

const fn rate(bits_per_second: u32) -> Bitrate {
    match Bitrate::new(bits_per_second) {
        Some(rate) => rate,
        None => panic!("evaluated while compiling"),
    }
}
