//! The adapter: commands in, answers, frames and error records out.

use std::collections::VecDeque;

use canbaud::wire::Frame;

use super::filter::Filter;
use super::{frame, rates};
use crate::event::{ErrorKind, Event, FaultState, NodeId, Place};
use crate::node::{Mode, NodeConfig};
use crate::simulation::Simulation;
use crate::time::Time;
use crate::timing::BitTiming;

/// Longest command: an extended CAN FD frame of 64 bytes.
const COMMAND_MAX: usize = 1 + 8 + 1 + 128;
/// Frames that wait for `P` or `A`.
const FIFO: usize = 32;
/// Requests that wait in the controller.
const REQUESTS: usize = 16;

const OK: &[u8] = b"\r";
const BELL: &[u8] = b"\x07";

/// Whose commands: the firmwares differ in what S7 and S9 mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dialect {
    /// S7 is 800 kbit/s, no S9.
    #[default]
    Lawicel,
    /// S7 is 750 kbit/s, S9 83.333 kbit/s.
    Canable,
}

/// What the adapter says of errors on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ErrorReports {
    /// `e` and `s` records beside frames, and `F`.
    #[default]
    Records,
    /// `F` alone.
    Flags,
    /// Nothing; `F` is always 00.
    Silent,
}

/// Bits of the answer to `F` [CAN232 manual].
mod flag {
    pub(super) const RX_FULL: u8 = 1 << 0;
    pub(super) const TX_FULL: u8 = 1 << 1;
    pub(super) const WARNING: u8 = 1 << 2;
    pub(super) const OVERRUN: u8 = 1 << 3;
    pub(super) const PASSIVE: u8 = 1 << 5;
    pub(super) const ARBITRATION_LOST: u8 = 1 << 6;
    pub(super) const BUS_ERROR: u8 = 1 << 7;
}

/// An adapter that is one node of a simulation.
///
/// [`Adapter::command`] takes what the host writes, [`Adapter::notice`] what happens in the node,
/// [`Adapter::take_output`] is what the host reads. The node has to be watched and begins disabled.
#[derive(Debug)]
pub struct Adapter {
    node: NodeId,
    dialect: Dialect,
    reports: ErrorReports,
    /// How the node is set up while open.
    config: NodeConfig,
    timing: Option<BitTiming>,
    open: Option<Mode>,
    auto_poll: bool,
    stamps: bool,
    filter: Filter,
    flags: u8,
    line: Vec<u8>,
    fifo: VecDeque<String>,
    output: Vec<u8>,
}

impl Adapter {
    /// An adapter at `node`, closed; `config` is how the node is set up, mode and timing apart.
    #[must_use]
    pub const fn new(
        node: NodeId,
        config: NodeConfig,
        dialect: Dialect,
        reports: ErrorReports,
    ) -> Self {
        Self {
            node,
            dialect,
            reports,
            config,
            timing: None,
            open: None,
            auto_poll: true,
            stamps: false,
            filter: Filter::ALL,
            flags: 0,
            line: Vec::new(),
            fifo: VecDeque::new(),
            output: Vec::new(),
        }
    }

    /// Its node.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// The mode in which the channel is open; `None` while it is closed.
    #[must_use]
    pub const fn open_mode(&self) -> Option<Mode> {
        self.open
    }

    /// What the host reads next.
    pub fn take_output(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.output)
    }

    /// What was read could not be passed on: the host is too slow.
    pub const fn note_overrun(&mut self) {
        self.flags |= flag::RX_FULL | flag::OVERRUN;
    }

    /// Takes what the host wrote.
    pub fn command(&mut self, bytes: &[u8], sim: &mut Simulation) {
        for byte in bytes {
            match byte {
                b'\r' => {
                    let line = core::mem::take(&mut self.line);
                    let answer = match core::str::from_utf8(&line) {
                        _ if line.len() > COMMAND_MAX => None,
                        Ok(text) => self.execute(text, sim),
                        Err(_) => None,
                    };
                    self.output.extend(answer.unwrap_or_else(|| BELL.to_vec()));
                }
                // A terminal may send both.
                b'\n' => {}
                // One more than the longest command marks a line that is too long.
                _ if self.line.len() <= COMMAND_MAX => self.line.push(*byte),
                _ => {}
            }
        }
    }

    /// The answer to a command; `None` is an error.
    fn execute(&mut self, line: &str, sim: &mut Simulation) -> Option<Vec<u8>> {
        let Some(letter) = line.bytes().next() else { return Some(OK.to_vec()) };
        let rest = line.get(1..)?;
        let closed = self.open.is_none();
        match letter {
            b'S' if closed => self.set(rates::nominal(rest, self.dialect, self.config.oscillator)),
            b's' if closed => self.set(rates::registers(rest, self.config.oscillator)),
            b'Y' if closed => {
                self.config.data = Some(rates::data(rest, self.config.oscillator)?);
                Some(OK.to_vec())
            }
            b'O' if rest.is_empty() => self.open(Mode::Normal, sim),
            b'L' if rest.is_empty() => self.open(Mode::BusMonitoring, sim),
            b'C' if rest.is_empty() => self.close(sim),
            b't' | b'T' | b'r' | b'R' | b'd' | b'D' | b'b' | b'B' => self.send(line, sim),
            b'P' if rest.is_empty() && !closed && !self.auto_poll => Some(self.poll_one()),
            b'A' if rest.is_empty() && !closed && !self.auto_poll => Some(self.poll_all()),
            b'F' if rest.is_empty() && !closed => Some(self.status()),
            b'V' if rest.is_empty() => Some(b"V1013\r".to_vec()),
            b'v' if rest.is_empty() => Some(b"vcanbaud\r".to_vec()),
            b'N' if rest.is_empty() => Some(b"NCB01\r".to_vec()),
            b'X' if closed => self.switch(rest, |adapter, on| adapter.auto_poll = on),
            b'Z' if closed => self.switch(rest, |adapter, on| adapter.stamps = on),
            b'M' if closed => self.mask(rest, |filter, value| filter.code = value),
            b'm' if closed => self.mask(rest, |filter, value| filter.mask = value),
            // Settings of the real thing that mean nothing here.
            b'W' | b'Q' | b'U' if rest.len() == 1 => Some(OK.to_vec()),
            _ => None,
        }
    }

    fn set(&mut self, timing: Option<BitTiming>) -> Option<Vec<u8>> {
        self.timing = Some(timing?);
        Some(OK.to_vec())
    }

    fn switch(&mut self, rest: &str, set: fn(&mut Self, bool)) -> Option<Vec<u8>> {
        match rest {
            "0" => set(self, false),
            "1" => set(self, true),
            _ => return None,
        }
        Some(OK.to_vec())
    }

    fn mask(&mut self, rest: &str, set: fn(&mut Filter, u32)) -> Option<Vec<u8>> {
        if rest.len() != 8 {
            return None;
        }
        set(&mut self.filter, u32::from_str_radix(rest, 16).ok()?);
        Some(OK.to_vec())
    }

    fn open(&mut self, mode: Mode, sim: &mut Simulation) -> Option<Vec<u8>> {
        let timing = self.timing.filter(|_| self.open.is_none())?;
        let prescaler = self.config.data.map(|data| data.prescaler());
        let same_quanta = prescaler.and_then(|prescaler| timing.with_prescaler(prescaler));
        self.config.nominal = same_quanta.unwrap_or(timing);
        self.config.mode = mode;
        sim.reconfigure_at(sim.now(), self.node, self.config.clone()).ok()?;
        self.open = Some(mode);
        self.flags = 0;
        self.fifo.clear();
        Some(OK.to_vec())
    }

    fn close(&mut self, sim: &mut Simulation) -> Option<Vec<u8>> {
        self.open.take()?;
        let off = NodeConfig { mode: Mode::Disabled, ..self.config.clone() };
        sim.reconfigure_at(sim.now(), self.node, off).ok()?;
        Some(OK.to_vec())
    }

    fn send(&mut self, line: &str, sim: &mut Simulation) -> Option<Vec<u8>> {
        let frame = frame::parse(line)?;
        let may = self.open == Some(Mode::Normal);
        if !may || (frame.kind().is_fd() && self.config.data.is_none()) {
            return None;
        }
        if sim.node(self.node).pending() >= REQUESTS {
            self.flags |= flag::TX_FULL;
            return None;
        }
        sim.send_at(sim.now(), self.node, frame);
        Some(match (self.auto_poll, frame.id().is_extended()) {
            (true, false) => b"z\r".to_vec(),
            (true, true) => b"Z\r".to_vec(),
            (false, _) => OK.to_vec(),
        })
    }

    fn poll_one(&mut self) -> Vec<u8> {
        let mut answer = self.fifo.pop_front().unwrap_or_default().into_bytes();
        answer.extend(OK);
        answer
    }

    fn poll_all(&mut self) -> Vec<u8> {
        let mut answer = Vec::new();
        for line in self.fifo.drain(..) {
            answer.extend(line.bytes().chain([b'\r']));
        }
        answer.extend(b"A\r");
        answer
    }

    fn status(&mut self) -> Vec<u8> {
        let flags = match self.reports {
            ErrorReports::Silent => self.flags & (flag::RX_FULL | flag::TX_FULL | flag::OVERRUN),
            ErrorReports::Records | ErrorReports::Flags => self.flags,
        };
        self.flags = 0;
        format!("F{flags:02X}\r").into_bytes()
    }

    /// Something happened in the node.
    pub fn notice(&mut self, at: Time, event: &Event, sim: &Simulation) {
        if self.open.is_none() {
            return;
        }
        match event {
            Event::Received { frame } => self.received(at, frame),
            Event::ArbitrationLost { .. } => self.flags |= flag::ARBITRATION_LOST,
            Event::Error { kind, place, .. } => {
                self.flags |= flag::BUS_ERROR;
                self.record(error_record(*kind, *place));
            }
            Event::Counted { tec, rec, .. } if *tec.max(rec) >= 96 => self.flags |= flag::WARNING,
            Event::Fault(state) => {
                if *state != FaultState::ErrorActive {
                    self.flags |= flag::PASSIVE;
                }
                let fault = sim.node(self.node).fault();
                self.record(state_record(*state, fault.rec(), fault.tec()));
            }
            _ => {}
        }
    }

    fn record(&mut self, record: String) {
        if self.reports == ErrorReports::Records {
            self.output.extend(record.bytes().chain([b'\r']));
        }
    }

    fn received(&mut self, at: Time, frame: &Frame) {
        if !self.filter.accepts(frame.id()) {
            return;
        }
        // Milliseconds of a minute.
        let ms = (at.femtoseconds() / 1_000_000_000_000 % 60_000) as u16;
        let line = frame::print(frame, self.stamps.then_some(ms));
        if self.auto_poll {
            self.output.extend(line.bytes().chain([b'\r']));
        } else if self.fifo.len() < FIFO {
            self.fifo.push_back(line);
        } else {
            self.flags |= flag::RX_FULL | flag::OVERRUN;
        }
    }
}

/// `e1` and the letter of the error, as the kernel's driver reads it.
fn error_record(kind: ErrorKind, place: Place) -> String {
    let letter = match (kind, place) {
        (ErrorKind::Ack, _) => 'a',
        // Own dominant bits that read recessive: flag and acknowledgement.
        (ErrorKind::Bit, Place::Flag | Place::AckSlot) => 'b',
        (ErrorKind::Bit, _) => 'B',
        (ErrorKind::Crc, _) => 'c',
        (ErrorKind::Form, _) => 'f',
        (ErrorKind::Stuff, _) => 's',
    };
    format!("e1{letter}")
}

/// `s`, the state, REC and TEC.
fn state_record(state: FaultState, rec: u16, tec: u16) -> String {
    let letter = match state {
        FaultState::ErrorActive => 'a',
        FaultState::ErrorPassive => 'p',
        FaultState::BusOff => 'b',
    };
    format!("s{letter}{:03}{:03}", rec.min(255), tec.min(255))
}
