//! The adapter: commands in, answers, frames and error records out.

use std::collections::VecDeque;

use canbaud::wire::Frame;

use super::command::{self, Command, Report, Stamps, Switch, When};
use super::firmware::{ErrorReports, Firmware, Replies, SilentMode};
use super::log::{self, Effect, Entry, What};
use super::status::{Status, Trouble};
use super::{filter::Filter, frame, rates};
use crate::event::{ErrorKind, Event, FaultState, NodeId, Place};
use crate::node::{FdSupport, Mode, NodeConfig, Tdc};
use crate::simulation::Simulation;
use crate::time::Time;
use crate::timing::BitTiming;

/// Frames that wait for `P` or `A`.
const FIFO: usize = 32;
/// Requests that wait in the controller.
const REQUESTS: usize = 16;

const OK: &[u8] = b"\r";
const BELL: &[u8] = b"\x07";

/// An adapter that is one node of a simulation.
///
/// [`Adapter::command`] takes what the host writes, [`Adapter::notice`] what happens in the node,
/// [`Adapter::take_output`] is what the host reads, [`Adapter::log`] tells what was asked and done.
/// The node has to be watched and begins disabled.
///
/// ```
/// use canbaud_sim::slcan::{Adapter, Firmware};
/// use canbaud_sim::{Mode, NodeConfig, Simulation};
/// let mut sim = Simulation::new(1);
/// let config = NodeConfig::at("adapter", 500_000).unwrap();
/// let node = sim.add_node(config.clone().with_mode(Mode::Disabled)).unwrap();
/// sim.watch(node);
/// let mut adapter = Adapter::new(node, config, Firmware::Lawicel);
/// adapter.command(b"S6\rL\rt1230\r", &mut sim);
/// assert_eq!(adapter.take_output(), b"\r\r\x07");
/// assert_eq!(adapter.log()[1].to_string(), "0.000000 L: open listen-only");
/// ```
#[derive(Debug)]
pub struct Adapter {
    node: NodeId,
    firmware: Firmware,
    reports: ErrorReports,
    silent_mode: SilentMode,
    /// How the node is set up while open.
    config: NodeConfig,
    timing: Option<BitTiming>,
    open: Option<Mode>,
    /// `M1` was said.
    silent: Switch,
    auto_poll: Switch,
    tell_changes: Switch,
    told: u8,
    report: Report,
    filter: Filter,
    status: Status,
    fault: FaultState,
    /// TEC and REC as they were counted last.
    counters: (u16, u16),
    last_error: Option<(ErrorKind, Place)>,
    line: Vec<u8>,
    fifo: VecDeque<String>,
    output: Vec<u8>,
    log: Vec<Entry>,
}

impl Adapter {
    /// An adapter at `node`, closed, as it comes out of its box. `config` is how the node is set
    /// up, mode, bit timings and the frequency of the oscillator apart, which are the firmware's.
    #[must_use]
    pub fn new(node: NodeId, config: NodeConfig, firmware: Firmware) -> Self {
        Self {
            node,
            firmware,
            reports: firmware.error_reports(),
            silent_mode: SilentMode::default(),
            config: set_up(config, firmware),
            timing: rates::at_power_on(firmware),
            open: None,
            silent: Switch::Off,
            auto_poll: Switch::On,
            tell_changes: Switch::Off,
            told: 0,
            report: Report::with(Stamps::None),
            filter: Filter::new(firmware),
            status: Status::new(firmware, firmware.error_reports()),
            fault: FaultState::ErrorActive,
            counters: (0, 0),
            last_error: None,
            line: Vec::new(),
            fifo: VecDeque::new(),
            output: Vec::new(),
            log: Vec::new(),
        }
    }

    /// The same adapter, telling errors in another way than its firmware does.
    #[must_use]
    pub const fn with_error_reports(mut self, reports: ErrorReports) -> Self {
        self.reports = reports;
        self.status = Status::new(self.firmware, reports);
        self
    }

    /// The same adapter, with this to come of `M1`.
    #[must_use]
    pub const fn with_silent_mode(mut self, silent_mode: SilentMode) -> Self {
        self.silent_mode = silent_mode;
        self
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

    /// Every command received, and everything that reached the bus, since the log was taken.
    #[must_use]
    pub fn log(&self) -> &[Entry] {
        &self.log
    }

    /// Takes the log; it begins anew.
    pub fn take_log(&mut self) -> Vec<Entry> {
        core::mem::take(&mut self.log)
    }

    /// What was read could not be passed on: the host is too slow.
    pub const fn note_overrun(&mut self) {
        self.status.note(Trouble::ReceiveOverrun);
    }

    /// Takes what the host wrote.
    pub fn command(&mut self, bytes: &[u8], sim: &mut Simulation) {
        for byte in bytes {
            match byte {
                b'\r' => {
                    let line = core::mem::take(&mut self.line);
                    self.run(&line, sim);
                }
                // A terminal may send both.
                b'\n' => {}
                // One more than the longest command marks a line that is too long.
                _ if self.line.len() <= command::LENGTH_MAX => self.line.push(*byte),
                _ => {}
            }
        }
    }

    fn run(&mut self, line: &[u8], sim: &mut Simulation) {
        let text = core::str::from_utf8(line).ok().filter(|_| line.len() <= command::LENGTH_MAX);
        let parsed = text.and_then(|text| command::parse(text, self.firmware));
        let effect = match parsed {
            Some((command, When::Always)) => self.execute(command, sim),
            Some((command, When::Closed)) if self.open.is_none() => self.execute(command, sim),
            Some((command, When::Opened)) if self.open.is_some() => self.execute(command, sim),
            Some(_) | None => None,
        };
        if effect.is_none() && self.firmware.replies() == Replies::Always {
            self.output.extend(BELL);
        }
        let effect = effect.unwrap_or(Effect::Refused);
        let what = What::Command { text: log::printable(line), effect };
        self.log.push(Entry { at: sim.now(), what });
    }

    /// Does it and answers; `None` is an error.
    fn execute(&mut self, command: Command, sim: &mut Simulation) -> Option<Effect> {
        match command {
            Command::Nominal(timing) => self.timing = Some(timing),
            Command::Data(timing) => {
                self.config.data = Some(timing);
                self.config.tdc = Tdc::Offset(timing.sample_quanta());
            }
            Command::Open(mode) => return self.open(mode, sim),
            Command::OpenAsSet => {
                let mode = match (self.silent, self.silent_mode) {
                    (Switch::On, SilentMode::Honoured) => Mode::BusMonitoring,
                    (Switch::On, SilentMode::Ignored) | (Switch::Off, _) => Mode::Normal,
                };
                return self.open(mode, sim);
            }
            Command::Close => return self.close(sim),
            Command::Send(frame) => return self.send(frame, sim),
            Command::PollOne => return self.poll_one(),
            Command::PollAll => return self.poll_all(),
            Command::Status => {
                let flags = self.status.read(sim.node(self.node).fault());
                return self.answer(&format!("F{flags:02X}\r"));
            }
            Command::DetailedStatus => {
                let text = self.detailed_status(sim);
                return self.answer(&text);
            }
            Command::Say(text) => return self.answer(text),
            Command::Nothing => {}
            Command::SilentMode(switch) => self.silent = switch,
            Command::Retransmission(retransmission) => self.config.retransmission = retransmission,
            Command::AutoPoll(switch) => self.auto_poll = switch,
            Command::ClearOverruns => self.status.clear(),
            Command::TellChanges(switch) => self.tell_changes = switch,
            Command::Report(report) => self.report = report,
            Command::Code(code) => self.filter.code = code,
            Command::Mask(mask) => self.filter.mask = mask,
        }
        self.confirm(Effect::Set)
    }

    /// CR, from a firmware that answers.
    fn confirm(&mut self, effect: Effect) -> Option<Effect> {
        if self.firmware.replies() == Replies::Always {
            self.output.extend(OK);
        }
        Some(effect)
    }

    /// What was asked for, CR included.
    fn answer(&mut self, text: &str) -> Option<Effect> {
        self.output.extend(text.bytes());
        Some(Effect::Answered)
    }

    fn open(&mut self, mode: Mode, sim: &mut Simulation) -> Option<Effect> {
        self.config.nominal = self.timing?;
        self.config.mode = mode;
        sim.reconfigure_at(sim.now(), self.node, self.config.clone()).ok()?;
        self.open = Some(mode);
        self.status.clear();
        self.fault = FaultState::ErrorActive;
        self.counters = (0, 0);
        self.last_error = None;
        self.fifo.clear();
        self.confirm(Effect::Opened(mode))
    }

    fn close(&mut self, sim: &mut Simulation) -> Option<Effect> {
        let off = NodeConfig { mode: Mode::Disabled, ..self.config.clone() };
        sim.reconfigure_at(sim.now(), self.node, off).ok()?;
        self.open = None;
        self.confirm(Effect::Closed)
    }

    fn send(&mut self, frame: Frame, sim: &mut Simulation) -> Option<Effect> {
        if self.open == Some(Mode::BusMonitoring) {
            return None;
        }
        if sim.node(self.node).pending() >= REQUESTS {
            self.status.note(Trouble::TransmitOverrun);
            return None;
        }
        sim.send_at(sim.now(), self.node, frame);
        if self.firmware.replies() == Replies::Always
            && self.auto_poll == Switch::On
            && self.report.transmitted == Switch::Off
        {
            self.output.push(confirmation(&frame) as u8);
        }
        self.confirm(Effect::Sent)
    }

    fn poll_one(&mut self) -> Option<Effect> {
        if self.auto_poll == Switch::On {
            return None;
        }
        let line = self.fifo.pop_front().unwrap_or_default();
        self.answer(&(line + "\r"))
    }

    fn poll_all(&mut self) -> Option<Effect> {
        if self.auto_poll == Switch::On {
            return None;
        }
        let lines: String = self.fifo.drain(..).map(|line| line + "\r").collect();
        self.answer(&(lines + "A\r"))
    }

    fn detailed_status(&self, sim: &Simulation) -> String {
        let fault = sim.node(self.node).fault();
        let state = match fault.state() {
            FaultState::ErrorActive => "ER_ACTV",
            FaultState::ErrorPassive => "ER_PSSV",
            FaultState::BusOff => "BUS_OFF",
        };
        let error = self.last_error.map_or("NONE", |(kind, place)| match (kind, place) {
            (ErrorKind::Stuff, _) => "STUF",
            (ErrorKind::Form, _) => "FORM",
            (ErrorKind::Ack, _) => "_ACK",
            (ErrorKind::Bit, Place::Flag | Place::AckSlot) => "BIT0",
            (ErrorKind::Bit, _) => "BIT1",
            (ErrorKind::Crc, _) => "_CRC",
        });
        format!(
            "f: node_sts={state}, last_err_code={error}, err_cnt_tx_rx=[0x{:02X}, 0x{:02X}]\r",
            fault.tec().min(255),
            fault.rec().min(255)
        )
    }

    /// Something happened in the node.
    pub fn notice(&mut self, at: Time, event: &Event, sim: &Simulation) {
        let Some(mode) = self.open else { return };
        match event {
            Event::Received { frame } => {
                if mode == Mode::Normal {
                    self.log.push(Entry { at, what: What::Acknowledged });
                }
                self.received(at, frame);
            }
            Event::Transmitted { frame } if self.report.transmitted == Switch::On => {
                let line = frame::print(frame, self.report, at);
                let line = format!("{}{line}\r", confirmation(frame));
                self.output.extend(line.bytes());
            }
            Event::ArbitrationLost { .. } => self.status.note(Trouble::ArbitrationLost),
            Event::Error { kind, place, .. } => self.error(at, *kind, *place),
            Event::Counted { tec, rec, .. } => self.counted(*tec, *rec),
            Event::Fault(state) => self.changed(*state, sim),
            _ => {}
        }
        self.tell_changed_flags(sim);
    }

    fn error(&mut self, at: Time, kind: ErrorKind, place: Place) {
        if self.open == Some(Mode::Normal) && self.fault == FaultState::ErrorActive {
            self.log.push(Entry { at, what: What::ErrorFlag });
        }
        self.last_error = Some((kind, place));
        self.status.note(Trouble::BusError);
        self.record(error_record(kind, place));
    }

    fn counted(&mut self, tec: u16, rec: u16) {
        let (tec_before, rec_before) = self.counters;
        self.counters = (tec, rec);
        if tec > tec_before || rec > rec_before {
            self.status.note(Trouble::Counted);
        }
        if tec.max(rec) >= 96 {
            self.status.note(Trouble::Warning);
        }
    }

    fn changed(&mut self, state: FaultState, sim: &Simulation) {
        self.fault = state;
        if state != FaultState::ErrorActive {
            self.status.note(Trouble::Passive);
        }
        if state == FaultState::BusOff {
            self.status.note(Trouble::BusOff);
        }
        let fault = sim.node(self.node).fault();
        self.record(state_record(state, fault.rec(), fault.tec()));
    }

    /// `f1` of a USBtin: the flags, whenever they are others than before.
    fn tell_changed_flags(&mut self, sim: &Simulation) {
        if self.tell_changes == Switch::Off {
            return;
        }
        let flags = self.status.read(sim.node(self.node).fault());
        if flags != self.told {
            self.told = flags;
            self.output.extend(format!("F{flags:02X}\r").bytes());
        }
    }

    fn record(&mut self, record: String) {
        if self.reports == ErrorReports::Records {
            self.output.extend(record.bytes().chain([b'\r']));
        }
    }

    fn received(&mut self, at: Time, frame: &Frame) {
        if !self.filter.accepts(frame.id()) || self.report.received == Switch::Off {
            return;
        }
        let line = frame::print(frame, self.report, at);
        if self.auto_poll == Switch::On {
            self.output.extend(line.bytes().chain([b'\r']));
        } else if self.fifo.len() < FIFO {
            self.fifo.push_back(line);
        } else {
            self.status.note(Trouble::ReceiveOverrun);
        }
    }
}

/// What a node of that firmware is like, whatever the scenario made of it.
fn set_up(mut config: NodeConfig, firmware: Firmware) -> NodeConfig {
    config.oscillator.hertz = firmware.clock_hz();
    config.monitoring_counters = firmware.monitoring_counters();
    config.data = rates::data_at_power_on(firmware);
    config.fd = if firmware.has_fd() { FdSupport::Enabled } else { FdSupport::None };
    config.tdc = config.data.map_or(Tdc::Off, |data| Tdc::Offset(data.sample_quanta()));
    config
}

/// Of a frame that is to be sent.
const fn confirmation(frame: &Frame) -> char {
    if frame.id().is_extended() { 'Z' } else { 'z' }
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
