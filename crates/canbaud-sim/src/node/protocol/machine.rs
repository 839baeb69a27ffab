//! The state machine: one state per kind of bit, one step per sample point.

use std::collections::VecDeque;

use canbaud::wire::{EncodedFrame, FdCrc, Frame, Level};

use super::reader::Reader;
use super::transmit::Sending;
use crate::event::{ErrorKind, Event, FaultState, Place, Role, Rule};
use crate::node::bit_time::{Rate, SyncRule};
use crate::node::config::{
    FdSupport, Mode, MonitoringCounters, NodeConfig, Recovery, Retransmission,
};
use crate::node::fault::{FaultConfinement, RECOVERY_SEQUENCES};

/// The bit that the next sample belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Switched off, or bus-off for good.
    Off,
    /// Bus integration: waits for 11 recessive bits.
    Integrating {
        recessive: u8,
    },
    /// Nothing to do until an edge comes.
    Idle,
    /// Idle, but an edge was seen: this bit may be SOF.
    IdleBit,
    /// SOF to the end of the CRC sequence.
    Frame,
    CrcDelimiter,
    AckSlot,
    /// A CAN FD transmitter looks for the acknowledgement for one bit more.
    LateAckSlot,
    /// `late_ack`: in a CAN FD frame one dominant bit more still counts as ACK.
    AckDelimiter {
        late_ack: bool,
    },
    EndOfFrame {
        bit: u8,
    },
    ActiveFlag {
        sent: u8,
    },
    PassiveFlag {
        run: u8,
        last: Option<Level>,
        /// Exception to rule 3: TEC is raised only if the flag meets a dominant bit.
        tec_pending: bool,
    },
    OverloadFlag {
        sent: u8,
    },
    /// After a flag, until the first recessive bit.
    AfterFlag {
        dominant: u32,
        overload: bool,
    },
    /// Error or overload delimiter.
    Delimiter {
        recessive: u8,
    },
    Intermission {
        bit: u8,
    },
    /// Suspend transmission, after the intermission of an error passive transmitter.
    Suspend {
        bit: u8,
    },
    BusOff {
        sequences: u8,
        recessive: u8,
    },
}

/// The settings that protocol control needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    pub(super) mode: Mode,
    pub(super) fd: FdSupport,
    pub(super) fd_crc: FdCrc,
    pub(super) retransmission: Retransmission,
    pub(super) recovery: Recovery,
    pub(super) counters: MonitoringCounters,
}

impl From<&NodeConfig> for Setup {
    fn from(config: &NodeConfig) -> Self {
        Self {
            mode: config.mode,
            fd: config.fd,
            fd_crc: config.fd_crc,
            retransmission: config.retransmission,
            recovery: config.recovery,
            counters: config.monitoring_counters,
        }
    }
}

/// A frame that waits to be sent.
#[derive(Debug, Clone)]
pub(super) struct Request {
    pub(super) frame: Frame,
    pub(super) attempts: u32,
    /// The bits of the last attempt, and of which frame they are.
    pub(super) encoded: Option<(Frame, EncodedFrame)>,
}

/// Protocol control of one node.
#[derive(Debug, Clone)]
pub(crate) struct Protocol {
    pub(super) setup: Setup,
    pub(super) state: State,
    pub(super) role: Role,
    pub(super) reader: Reader,
    pub(super) sending: Option<Sending>,
    pub(super) queue: VecDeque<Request>,
    pub(super) fault: FaultConfinement,
    pub(super) drive: Level,
    pub(super) rate: Rate,
    /// What happened since the node looked last.
    pub(super) events: Vec<Event>,
}

impl Protocol {
    pub(crate) fn new(setup: Setup, fault: FaultConfinement) -> Self {
        let state = match (setup.mode, fault.state()) {
            (Mode::Disabled, _) => State::Off,
            (_, FaultState::BusOff) => State::BusOff { sequences: 0, recessive: 0 },
            // A node in internal loopback is alone.
            (Mode::Loopback, _) => State::Idle,
            (Mode::Normal | Mode::BusMonitoring | Mode::Restricted, _) => {
                State::Integrating { recessive: 0 }
            }
        };
        Self {
            reader: Reader::new(setup.fd, setup.fd_crc),
            setup,
            state,
            role: Role::Receiver,
            sending: None,
            queue: VecDeque::new(),
            fault,
            drive: Level::Recessive,
            rate: Rate::Nominal,
            events: Vec::new(),
        }
    }

    pub(crate) const fn fault(&self) -> &FaultConfinement {
        &self.fault
    }

    /// What the node drives from the start of the next bit on.
    #[inline]
    pub(crate) const fn drive(&self) -> Level {
        self.drive
    }

    /// The rate from the last sample point on.
    #[inline]
    pub(crate) const fn rate(&self) -> Rate {
        self.rate
    }

    /// Whether nothing happens without an edge or a request.
    #[inline]
    pub(crate) fn sleeps(&self) -> bool {
        matches!(self.state, State::Idle | State::Off)
    }

    /// An edge was seen: an idle node looks at the bit that it begins. One that integrates and
    /// knows CAN FD begins to count anew, lest data bits between its samples go unseen.
    #[inline]
    pub(crate) fn wake(&mut self) {
        match self.state {
            State::Idle => self.state = State::IdleBit,
            State::Integrating { .. } if self.setup.fd != FdSupport::None => {
                self.state = State::Integrating { recessive: 0 };
            }
            _ => {}
        }
    }

    pub(crate) fn is_off(&self) -> bool {
        matches!(self.state, State::Off)
    }

    /// Whether this node sends the frame on the bus.
    #[inline]
    pub(crate) const fn is_transmitting(&self) -> bool {
        self.sending.is_some()
    }

    /// Whether the bit that began last is res of a CAN FD frame.
    #[inline]
    pub(crate) fn is_at_res(&self) -> bool {
        matches!(self.state, State::Frame) && self.reader.expects_res()
    }

    pub(crate) fn is_busy(&self) -> bool {
        !matches!(self.state, State::Off | State::Idle | State::IdleBit | State::Integrating { .. })
    }

    pub(crate) fn has_events(&self) -> bool {
        !self.events.is_empty()
    }

    pub(crate) fn take_event(&mut self) -> Option<Event> {
        if self.events.is_empty() { None } else { Some(self.events.remove(0)) }
    }

    /// Which kind of synchronisation an edge in this bit is for; `driven` is the level that the
    /// node drives at the moment.
    pub(crate) fn sync_rule(&self, driven: Level) -> SyncRule {
        match self.state {
            State::Off => SyncRule::Off,
            State::Idle
            | State::IdleBit
            | State::Integrating { .. }
            | State::Suspend { .. }
            | State::BusOff { .. }
            | State::Intermission { bit: 2.. } => SyncRule::Hard,
            State::Frame if self.sending.is_none() && self.reader.expects_res() => SyncRule::Hard,
            State::Frame if self.sending.is_some() && self.rate == Rate::Data => SyncRule::Off,
            State::Frame if self.sending.as_ref().is_some_and(Sending::before_sof) => {
                // SOF is decided on; before it begins this edge is that of another SOF.
                if driven == Level::Recessive { SyncRule::Hard } else { SyncRule::NegativeOnly }
            }
            _ if driven == Level::Dominant => SyncRule::NegativeOnly,
            _ => SyncRule::Both,
        }
    }

    /// Takes a sampled bit. `late_error`: the secondary sample point found one; `None` without TDC
    /// or outside the data phase.
    #[inline]
    pub(crate) fn sample(&mut self, level: Level, late_error: Option<bool>) {
        match self.state {
            State::Frame => self.frame_bit(level, late_error),
            State::Off => {}
            State::Integrating { recessive } => self.integrating_bit(level, recessive),
            State::Idle | State::IdleBit => self.idle_bit(level),
            State::CrcDelimiter => self.crc_delimiter_bit(level, late_error),
            State::AckSlot => self.ack_slot_bit(level),
            State::LateAckSlot => self.late_ack_slot_bit(level),
            State::AckDelimiter { late_ack } => self.ack_delimiter_bit(level, late_ack),
            State::EndOfFrame { bit } => self.end_of_frame_bit(level, bit),
            State::ActiveFlag { sent } => self.active_flag_bit(level, sent),
            State::PassiveFlag { run, last, tec_pending } => {
                self.passive_flag_bit(level, run, last, tec_pending);
            }
            State::OverloadFlag { sent } => self.overload_flag_bit(level, sent),
            State::AfterFlag { dominant, overload } => {
                self.after_flag_bit(level, dominant, overload);
            }
            State::Delimiter { recessive } => self.delimiter_bit(level, recessive),
            State::Intermission { bit } => self.intermission_bit(level, bit),
            State::Suspend { bit } => self.suspend_bit(level, bit),
            State::BusOff { sequences, recessive } => {
                self.bus_off_bit(level, sequences, recessive);
            }
        }
    }

    fn integrating_bit(&mut self, level: Level, recessive: u8) {
        match level {
            Level::Dominant => self.state = State::Integrating { recessive: 0 },
            Level::Recessive if recessive < 10 => {
                self.state = State::Integrating { recessive: recessive + 1 };
            }
            Level::Recessive => {
                self.events.push(Event::Integrated);
                self.idle_or_start();
            }
        }
    }

    fn idle_bit(&mut self, level: Level) {
        match level {
            Level::Dominant => self.receive_sof(),
            Level::Recessive => self.idle_or_start(),
        }
    }

    fn intermission_bit(&mut self, level: Level, bit: u8) {
        match (level, bit) {
            (Level::Dominant, ..=2) => self.overload(),
            (Level::Dominant, _) => {
                // The third bit dominant is a SOF; whoever waits joins with its identifier.
                let suspended = self.must_suspend();
                self.receive_sof();
                if !suspended {
                    self.join();
                }
            }
            (Level::Recessive, ..=2) => self.state = State::Intermission { bit: bit + 1 },
            (Level::Recessive, _) if self.must_suspend() => self.state = State::Suspend { bit: 1 },
            (Level::Recessive, _) => self.idle_or_start(),
        }
    }

    fn must_suspend(&self) -> bool {
        self.role == Role::Transmitter && self.fault.state() == FaultState::ErrorPassive
    }

    fn suspend_bit(&mut self, level: Level, bit: u8) {
        match level {
            Level::Dominant => self.receive_sof(),
            Level::Recessive if bit < 8 => self.state = State::Suspend { bit: bit + 1 },
            Level::Recessive => self.idle_or_start(),
        }
    }

    fn bus_off_bit(&mut self, level: Level, sequences: u8, recessive: u8) {
        self.state = match (level, recessive) {
            (Level::Dominant, _) => State::BusOff { sequences, recessive: 0 },
            (Level::Recessive, ..10) => State::BusOff { sequences, recessive: recessive + 1 },
            (Level::Recessive, _) => {
                let sequences = sequences + 1;
                self.events.push(Event::RecoverySequence(sequences));
                if sequences == RECOVERY_SEQUENCES {
                    self.fault.recover();
                    self.events.push(Event::Fault(FaultState::ErrorActive));
                    self.role = Role::Receiver;
                    self.idle_or_start();
                    return;
                }
                State::BusOff { sequences, recessive: 0 }
            }
        };
    }

    /// The bus is free: send what waits, or idle.
    pub(super) fn idle_or_start(&mut self) {
        self.role = Role::Receiver;
        self.state = State::Idle;
        self.start();
    }

    /// SOF of another node was sampled.
    pub(super) fn receive_sof(&mut self) {
        self.state = State::Frame;
        self.role = Role::Receiver;
        self.reader.reset();
        // SOF alone completes no frame and breaks no rule.
        let _ = self.reader.push(Level::Dominant);
    }

    /// Fault confinement: rules 1 to 8, and the state that follows.
    pub(super) fn count(&mut self, rule: Rule) {
        let frozen = match self.setup.mode {
            Mode::Normal | Mode::Loopback => false,
            Mode::BusMonitoring => self.setup.counters == MonitoringCounters::Frozen,
            Mode::Restricted | Mode::Disabled => true,
        };
        if frozen {
            return;
        }
        let (before, tec, rec) = (self.fault.state(), self.fault.tec(), self.fault.rec());
        self.fault.count(rule, self.role);
        if (tec, rec) != (self.fault.tec(), self.fault.rec()) {
            let (tec, rec) = (self.fault.tec(), self.fault.rec());
            self.events.push(Event::Counted { rule, tec, rec });
        }
        if self.fault.state() != before {
            self.events.push(Event::Fault(self.fault.state()));
        }
    }

    /// Whether flags are active ones.
    pub(super) fn is_error_active(&self) -> bool {
        self.setup.mode == Mode::BusMonitoring || self.fault.state() == FaultState::ErrorActive
    }

    /// An error was detected: counts it and starts a flag.
    pub(super) fn error(&mut self, kind: ErrorKind, place: Place, exempt: bool) {
        self.events.push(Event::Error { kind, place, role: self.role, exempt });
        self.rate = Rate::Nominal;
        self.drive = Level::Recessive;
        self.give_up_attempt();
        let active = self.is_error_active();
        let tec_pending = match self.role {
            Role::Receiver => {
                self.count(Rule::ReceiverError);
                false
            }
            Role::Transmitter if exempt => false,
            Role::Transmitter if !active && kind == ErrorKind::Ack => true,
            Role::Transmitter => {
                self.count(Rule::TransmitterError);
                false
            }
        };
        self.begin_flag(active, tec_pending);
    }

    /// Starts an error flag; `active` as it was before the error was counted (rule 9).
    pub(super) fn begin_flag(&mut self, active: bool, tec_pending: bool) {
        if self.fault.state() == FaultState::BusOff {
            self.enter_bus_off();
        } else if self.setup.mode == Mode::Restricted {
            self.state = State::Integrating { recessive: 0 };
        } else if active {
            self.drive = Level::Dominant;
            self.state = State::ActiveFlag { sent: 0 };
        } else {
            self.state = State::PassiveFlag { run: 0, last: None, tec_pending };
        }
    }

    pub(super) fn enter_bus_off(&mut self) {
        self.drive = Level::Recessive;
        self.state = match self.setup.recovery {
            Recovery::Automatic => State::BusOff { sequences: 0, recessive: 0 },
            Recovery::Manual => State::Off,
        };
    }
}
