//! The driver.

use crate::registers::{
    BUKT, CANCTRL, CANINTE, CANINTF, CANSTAT, CNF3, EFLG, EXIDE, MERRF, MODE_MASK, Mode, OVERFLOW,
    RX0IF, RX1IF, RXB0CTRL, RXB1CTRL, RXF0SIDH, RXF3SIDH, RXM0SIDH, instruction,
};
use canbaud::detect::scan::{
    Candidate, Capabilities, Capture, Configured, Controller, ErrorClass, ErrorPlace, ErrorSeen,
    Evidence, FdSupport, FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::timing::controllers::{Configuration, mcp2515};
use canbaud::timing::{Request, SamplePointPolicy, solve};
use canbaud::units::{Bitrate, Hertz, Micros, Permille};
use canbaud::wire::{Frame, FrameKind, Id};
use embedded_hal::spi::{Operation, SpiDevice};

/// How often CANSTAT is read until a mode is entered. A mode change waits for the frame on the bus;
/// the slowest, 13 ms long, is over after fewer reads of 3 bytes at 10 MHz.
const MODE_READS: u32 = 8192;

/// What can go wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error<E> {
    /// The SPI bus.
    Spi(E),
    /// CANSTAT says another mode than the one asked for: the mode bits asked for, and those read.
    Mode {
        /// REQOP.
        asked: u8,
        /// OPMOD.
        read: u8,
    },
    /// The bit timing cannot be made from the crystal.
    Timing(Bitrate),
    /// CNF3, CNF2, CNF1 read back other than they were written: wiring, or not an MCP2515.
    ReadBack {
        /// What was written.
        written: [u8; 3],
        /// What was read.
        read: [u8; 3],
    },
}

/// An MCP2515 that only listens.
#[derive(Debug)]
pub struct Mcp2515<SPI> {
    spi: SPI,
    crystal: Hertz,
}

impl<SPI: SpiDevice> Mcp2515<SPI> {
    /// Resets the chip, which leaves it in configuration mode. `crystal` is F_OSC.
    ///
    /// The oscillator needs 128 periods after a reset: the mode is read until it is there.
    ///
    /// # Errors
    /// [`Error::Spi`]; [`Error::Mode`] if no MCP2515 answers.
    pub fn new(spi: SPI, crystal: Hertz) -> Result<Self, Error<SPI::Error>> {
        let mut new = Self { spi, crystal };
        new.spi.write(&[instruction::RESET]).map_err(Error::Spi)?;
        new.wait_for(Mode::Configuration)?;
        Ok(new)
    }

    fn read<const N: usize>(&mut self, register: u8) -> Result<[u8; N], Error<SPI::Error>> {
        let mut values = [0; N];
        let head = [instruction::READ, register];
        self.spi
            .transaction(&mut [Operation::Write(&head), Operation::Read(&mut values)])
            .map_err(Error::Spi)?;
        Ok(values)
    }

    fn write(&mut self, register: u8, values: &[u8]) -> Result<(), Error<SPI::Error>> {
        let head = [instruction::WRITE, register];
        self.spi
            .transaction(&mut [Operation::Write(&head), Operation::Write(values)])
            .map_err(Error::Spi)
    }

    fn modify(&mut self, register: u8, mask: u8, value: u8) -> Result<(), Error<SPI::Error>> {
        self.spi.write(&[instruction::BIT_MODIFY, register, mask, value]).map_err(Error::Spi)
    }

    fn enter(&mut self, mode: Mode) -> Result<(), Error<SPI::Error>> {
        self.modify(CANCTRL, MODE_MASK, mode as u8)?;
        self.wait_for(mode)
    }

    fn wait_for(&mut self, mode: Mode) -> Result<(), Error<SPI::Error>> {
        let mut read = 0;
        for _ in 0..MODE_READS {
            let [status] = self.read(CANSTAT)?;
            read = status & MODE_MASK;
            if read == mode as u8 {
                return Ok(());
            }
        }
        Err(Error::Mode { asked: mode as u8, read })
    }

    /// Both buffers take every frame that is complete and right: masks of 0, in each buffer one
    /// filter for base and one for extended format.
    fn accept_everything(&mut self) -> Result<(), Error<SPI::Error>> {
        let filter = |sidl| [0, sidl, 0, 0];
        self.write(RXM0SIDH, &[0; 8])?;
        for (first, kinds) in [(RXF0SIDH, [0, EXIDE, 0]), (RXF3SIDH, [EXIDE, 0, EXIDE])] {
            for (number, sidl) in (0..).zip(kinds) {
                self.write(first + 4 * number, &filter(sidl))?;
            }
        }
        self.write(RXB0CTRL, &[BUKT])?;
        self.write(RXB1CTRL, &[0])
    }

    fn receive(&mut self, instruction: u8) -> Result<Option<Frame>, Error<SPI::Error>> {
        let mut buffer = [0; 13];
        self.spi
            .transaction(&mut [Operation::Write(&[instruction]), Operation::Read(&mut buffer)])
            .map_err(Error::Spi)?;
        Ok(frame(&buffer))
    }
}

impl<SPI: SpiDevice> Controller for Mcp2515<SPI> {
    type Error = Error<SPI::Error>;

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            rates: RateChoice::Between(LOWEST, HIGHEST),
            // MERRF comes with each error, but not its kind.
            evidence: Evidence::Errors,
            fd: FdSupport::Classic,
            reconfiguration: Micros::from_ms(2),
            latency: Micros::from_ms(1),
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, Self::Error> {
        let bitrate = candidate.nominal;
        let mut request = Request::new(self.crystal, bitrate);
        if let (Capture::Wide, Some(point)) = (candidate.capture, Permille::new(750)) {
            request = request.with_sample_point(point, SamplePointPolicy::NotLater);
        }
        let solution = solve(&request, &mcp2515::NOMINAL).map_err(|_| Error::Timing(bitrate))?;
        let timing = Configuration::classic(solution.timing);
        let mut written = [0; 3];
        for (byte, register) in
            written.iter_mut().zip([mcp2515::CNF3, mcp2515::CNF2, mcp2515::CNF1])
        {
            *byte = register.pack(&timing).map_err(|_| Error::Timing(bitrate))? as u8;
        }
        self.enter(Mode::Configuration)?;
        self.write(CNF3, &written)?;
        let read = self.read(CNF3)?;
        if read != written {
            return Err(Error::ReadBack { written, read });
        }
        let really = (solution.rate.millibits_per_second() + 500) / 1000;
        let really = u32::try_from(really).ok().and_then(Bitrate::new);
        Ok(Configured { nominal: really.unwrap_or(bitrate), data: None })
    }

    fn start_monitoring(&mut self) -> Result<(), Self::Error> {
        self.accept_everything()?;
        // No interrupt but by polling; no flag and no overflow of before.
        self.write(CANINTE, &[0, 0, 0])?;
        let entered = self.enter(Mode::ListenOnly);
        if entered.is_err() {
            self.enter(Mode::Configuration)?;
        }
        entered
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, Self::Error> {
        let [flags, errors] = self.read(CANINTF)?;
        if errors & OVERFLOW != 0 {
            self.modify(EFLG, OVERFLOW, 0)?;
            return Ok(Some(Observation::Lost));
        }
        for (flag, instruction) in [(RX0IF, instruction::READ_RX0), (RX1IF, instruction::READ_RX1)]
        {
            if flags & flag != 0 {
                let seen = self.receive(instruction)?;
                // A frame that cannot be is one of a line that rings: as good as an error.
                let observation = seen.map_or(error(now), |frame| {
                    Observation::Frame(FrameSeen { frame, origin: Origin::Bus, received: None })
                });
                return Ok(Some(observation));
            }
        }
        if flags & MERRF != 0 {
            self.modify(CANINTF, MERRF, 0)?;
            return Ok(Some(error(now)));
        }
        Ok(None)
    }

    fn stop(&mut self) -> Result<(), Self::Error> {
        self.enter(Mode::Configuration)
    }
}

/// What the divider of the bit timing can make of any crystal up to 25 MHz; the crystal itself says no
/// to more, when a rate is set.
const LOWEST: Bitrate = rate(5_000);
const HIGHEST: Bitrate = rate(1_000_000);

const fn rate(bits_per_second: u32) -> Bitrate {
    match Bitrate::new(bits_per_second) {
        Some(rate) => rate,
        None => panic!("evaluated while compiling"),
    }
}

fn error(now: Micros) -> Observation {
    let (class, place) = (ErrorClass::Unknown, ErrorPlace::Unknown);
    Observation::Error(ErrorSeen { class, place, received: Some(now) })
}

/// A receive buffer: SIDH, SIDL, EID8, EID0, DLC, data \[registers 4-4 to 4-9\].
fn frame(buffer: &[u8; 13]) -> Option<Frame> {
    let [sidh, sidl, eid8, eid0, dlc, data @ ..] = buffer;
    let base = u32::from(*sidh) << 3 | u32::from(*sidl) >> 5;
    let is_extended = sidl & 0x08 != 0;
    let (id, is_remote) = if is_extended {
        let low = u32::from(sidl & 3) << 16 | u32::from(*eid8) << 8 | u32::from(*eid0);
        (Id::extended(base << 18 | low), dlc & 0x40 != 0)
    } else {
        (Id::base(base as u16), sidl & 0x10 != 0)
    };
    let kind = if is_remote { FrameKind::Remote } else { FrameKind::Data };
    let dlc = dlc & 0x0F;
    let data = data.get(..Frame::data_length(kind, dlc))?;
    Frame::new(id?, kind, dlc, data).ok()
}
