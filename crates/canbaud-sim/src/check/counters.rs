//! The error counters follow the rules, derived anew from what a node samples and reports.

use canbaud::wire::Level;

use super::Findings;
use crate::event::{ErrorKind, Event, FaultState, NodeId, Place, Role, Rule, Sample, SampleRun};
use crate::node::{Mode, MonitoringCounters, Node, NodeConfig};
use crate::time::Time;

/// Where a node is in its flag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flag {
    None,
    /// Six dominant bits; `overload` or error.
    Active {
        left: u8,
        overload: bool,
    },
    /// Six equal bits on the bus; `owes` an increase of TEC if one of them is dominant.
    Passive {
        run: u8,
        last: Option<Level>,
        owes: bool,
    },
    /// Until the first recessive bit.
    After {
        dominant: u32,
        overload: bool,
    },
}

/// The counters of one node as they should be.
#[derive(Debug)]
pub(super) struct Counters {
    tec: i32,
    rec: i32,
    told: (i32, i32),
    frozen: bool,
    always_active: bool,
    no_flags: bool,
    bus_off: bool,
    role: Role,
    flag: Flag,
    recessive_run: u32,
    sequences: u32,
}

impl Counters {
    pub(super) fn new(node: &Node) -> Self {
        let mut counters = Self::with(node.config());
        counters.tec = node.fault().tec().into();
        counters.rec = node.fault().rec().into();
        counters.told = (counters.tec, counters.rec);
        counters.bus_off = counters.tec > 255;
        counters
    }

    fn with(config: &NodeConfig) -> Self {
        let frozen = match config.mode {
            Mode::BusMonitoring => config.monitoring_counters == MonitoringCounters::Frozen,
            Mode::Restricted | Mode::Disabled => true,
            Mode::Normal | Mode::Loopback => false,
        };
        Self {
            tec: 0,
            rec: 0,
            told: (0, 0),
            frozen,
            always_active: config.mode == Mode::BusMonitoring,
            no_flags: config.mode == Mode::Restricted,
            bus_off: false,
            role: Role::Receiver,
            flag: Flag::None,
            recessive_run: 0,
            sequences: 0,
        }
    }

    pub(super) fn reconfigured(&mut self, config: &NodeConfig) {
        *self = Self::with(config);
    }

    fn passive(&self) -> bool {
        !self.always_active && (self.tec > 127 || self.rec > 127)
    }

    fn add(&mut self, role: Role, by: i32) {
        if self.frozen {
            return;
        }
        match role {
            Role::Transmitter => self.tec += by,
            // Past the limit REC stays where it is.
            Role::Receiver if self.rec > 127 => {}
            Role::Receiver => self.rec += by,
        }
        if self.tec >= 256 {
            self.bus_off = true;
            self.flag = Flag::None;
            (self.recessive_run, self.sequences) = (0, 0);
        }
    }

    pub(super) fn txd(&self, at: Time, node: NodeId, level: Level, findings: &mut Findings) {
        if level == Level::Recessive {
            return;
        }
        if self.bus_off {
            findings.add(at, Some(node), "drives the bus dominant in bus-off".into());
        }
        if matches!(self.flag, Flag::Passive { .. }) {
            findings.add(at, Some(node), "drives a passive error flag dominant".into());
        }
    }

    /// Follows the flag with the bits just sampled.
    pub(super) fn samples(&mut self, run: &SampleRun) {
        for _ in 0..run.bits {
            if self.flag == Flag::None && !self.bus_off {
                return;
            }
            self.sample(&run.sample);
        }
    }

    fn sample(&mut self, sample: &Sample) {
        let dominant = sample.level == Level::Dominant;
        if self.bus_off {
            self.recessive_run = if dominant { 0 } else { self.recessive_run + 1 };
            if self.recessive_run == 11 {
                self.sequences += 1;
                self.recessive_run = 0;
            }
            return;
        }
        match self.flag {
            Flag::None => {}
            // A recessive bit here is an error that the node reports.
            Flag::Active { left, overload } if dominant => {
                self.flag = match left {
                    1 => Flag::After { dominant: 0, overload },
                    _ => Flag::Active { left: left - 1, overload },
                };
            }
            Flag::Active { .. } => {}
            Flag::Passive { run, last, owes } => {
                let run = if last == Some(sample.level) { run + 1 } else { 1 };
                self.flag = match run {
                    6 => Flag::After { dominant: 0, overload: false },
                    _ => Flag::Passive { run, last: Some(sample.level), owes: owes && !dominant },
                };
                if owes && dominant {
                    self.add(Role::Transmitter, 8);
                }
            }
            Flag::After { .. } if !dominant => self.flag = Flag::None,
            Flag::After { dominant, overload } => {
                let dominant = dominant + 1;
                self.flag = Flag::After { dominant, overload };
                if dominant == 1 && !overload && self.role == Role::Receiver {
                    self.add(Role::Receiver, 8);
                }
                if dominant.is_multiple_of(8) {
                    self.add(self.role, 8);
                }
            }
        }
    }

    fn error(&mut self, kind: ErrorKind, place: Place, role: Role, exempt: bool) {
        self.role = role;
        let passive = self.passive();
        let owes = role == Role::Transmitter && passive && kind == ErrorKind::Ack;
        self.flag = match passive {
            _ if self.no_flags => Flag::None,
            true => Flag::Passive { run: 0, last: None, owes },
            false => Flag::Active { left: 6, overload: false },
        };
        if !owes && !exempt {
            self.add(role, if role == Role::Receiver && place != Place::Flag { 1 } else { 8 });
        }
    }

    pub(super) fn event(&mut self, at: Time, node: NodeId, event: &Event, findings: &mut Findings) {
        let mut complain = |what: String| findings.add(at, Some(node), what);
        match event {
            Event::Error { kind, place, role, exempt } => {
                let lawful = *kind == ErrorKind::Stuff
                    && *place == Place::Arbitration
                    && *role == Role::Transmitter;
                if *exempt && !lawful {
                    complain(format!("{kind} in the {place} does not exempt TEC"));
                }
                self.error(*kind, *place, *role, *exempt);
            }
            Event::Overload if self.no_flags => {}
            Event::Overload => self.flag = Flag::Active { left: 6, overload: true },
            Event::TransmissionStarted { .. } => {
                if self.bus_off {
                    complain("begins to send in bus-off".into());
                }
                self.flag = Flag::None;
                self.role = Role::Transmitter;
            }
            Event::ArbitrationLost { .. } => self.role = Role::Receiver,
            Event::Transmitted { .. } if !self.frozen => self.tec = (self.tec - 1).max(0),
            Event::Counted { rule, tec, rec } => {
                if *rule == Rule::Received {
                    self.rec = if self.rec > 127 { 119 } else { (self.rec - 1).max(0) };
                    self.role = Role::Receiver;
                }
                self.told = ((*tec).into(), (*rec).into());
                if self.told != (self.tec, self.rec) {
                    let (tec, rec) = (self.tec, self.rec);
                    complain(format!("counts {:?} by {rule:?}, want {:?}", self.told, (tec, rec)));
                    (self.tec, self.rec) = self.told;
                }
            }
            Event::Fault(state) => {
                if let Some(what) = self.fault(*state) {
                    complain(what);
                }
            }
            Event::Transmitted { .. }
            | Event::Abandoned { .. }
            | Event::Received { .. }
            | Event::RecoverySequence(_)
            | Event::ProtocolException
            | Event::Integrated => {}
        }
    }

    /// The node reports another state: it must be that of its counters.
    fn fault(&mut self, state: FaultState) -> Option<String> {
        let (tec, rec, sequences) = (self.tec, self.rec, self.sequences);
        match state {
            FaultState::ErrorActive if self.bus_off => {
                self.bus_off = false;
                (self.tec, self.rec, self.told) = (0, 0, (0, 0));
                (sequences != 128).then(|| format!("leaves bus-off after {sequences} sequences"))
            }
            FaultState::ErrorActive => {
                (tec > 127 || rec > 127).then(|| format!("error active at TEC {tec} REC {rec}"))
            }
            FaultState::ErrorPassive => (tec <= 127 && rec <= 127 || tec > 255)
                .then(|| format!("error passive at TEC {tec} REC {rec}")),
            FaultState::BusOff => (tec < 256).then(|| format!("bus-off at TEC {tec}")),
        }
    }
}
