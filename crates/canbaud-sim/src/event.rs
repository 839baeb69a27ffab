//! What happens on the bus and in the nodes, as an observer sees it.

use canbaud::wire::{Frame, Level};

use crate::node::NodeConfig;
use crate::time::Time;

/// A node of the bus, by its place in the order in which nodes were added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub usize);

/// The five kinds of error [ISO 11898-1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// A driven bit reads back with the other level.
    Bit,
    /// Six equal bits where stuffing forbids them.
    Stuff,
    /// A bit of fixed form has the wrong level.
    Form,
    /// The CRC sequence or the stuff count does not match.
    Crc,
    /// Nobody acknowledged.
    Ack,
}

impl ErrorKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Bit, Self::Stuff, Self::Form, Self::Crc, Self::Ack];
}

impl core::fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Bit => "bit error",
            Self::Stuff => "stuff error",
            Self::Form => "form error",
            Self::Crc => "CRC error",
            Self::Ack => "acknowledge error",
        })
    }
}

/// Where in the course of a frame a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// SOF, identifier, RTR.
    Arbitration,
    /// IDE or FDF to DLC.
    Control,
    /// Data field.
    Data,
    /// Stuff count and CRC sequence.
    Crc,
    /// CRC delimiter.
    CrcDelimiter,
    /// ACK slot.
    AckSlot,
    /// ACK delimiter.
    AckDelimiter,
    /// End of frame.
    EndOfFrame,
    /// A flag of the node's own.
    Flag,
    /// Error or overload delimiter.
    Delimiter,
    /// Intermission, suspend, idle.
    Between,
}

impl core::fmt::Display for Place {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Arbitration => "arbitration field",
            Self::Control => "control field",
            Self::Data => "data field",
            Self::Crc => "CRC field",
            Self::CrcDelimiter => "CRC delimiter",
            Self::AckSlot => "ACK slot",
            Self::AckDelimiter => "ACK delimiter",
            Self::EndOfFrame => "EOF",
            Self::Flag => "flag",
            Self::Delimiter => "delimiter",
            Self::Between => "intermission",
        })
    }
}

/// What a node is doing in the frame on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Sends the frame.
    Transmitter,
    /// Receives the frame.
    Receiver,
}

/// Fault confinement state [ISO 11898-1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FaultState {
    /// Takes part and sends active error flags.
    ErrorActive,
    /// Takes part and sends passive error flags.
    ErrorPassive,
    /// Drives nothing.
    BusOff,
}

impl core::fmt::Display for FaultState {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::ErrorActive => "error active",
            Self::ErrorPassive => "error passive",
            Self::BusOff => "bus-off",
        })
    }
}

/// Which of the twelve rules of error confinement changed a counter or a state.
///
/// The order is that of the rules in ISO 11898-1 (and, as a to l, of the older texts).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rule {
    /// 1: a receiver detects an error: REC + 1.
    ReceiverError,
    /// 2: a receiver sees a dominant bit right after its error flag: REC + 8.
    DominantAfterFlag,
    /// 3: a transmitter sends an error flag: TEC + 8.
    TransmitterError,
    /// 4: bit error in a transmitter's own active error or overload flag: TEC + 8.
    TransmitterFlagError,
    /// 5: bit error in a receiver's own active error or overload flag: REC + 8.
    ReceiverFlagError,
    /// 6: eight dominant bits after a flag, and each further eight: + 8.
    DominantRun,
    /// 7: a successful transmission: TEC - 1.
    Transmitted,
    /// 8: a successful reception: REC - 1, or to 119.
    Received,
}

/// Something that happened in a node.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "events are passed by reference, one at a time")]
pub enum Event {
    /// A transmission begins with the first bit that the node sends.
    TransmissionStarted {
        /// What it sends.
        frame: Frame,
        /// 1 for the first attempt.
        attempt: u32,
    },
    /// Another node's identifier won; this node receives from here on.
    ArbitrationLost {
        /// Stuffed bit from SOF (0) at which it was lost.
        bit: u32,
    },
    /// The frame went out, acknowledged and without an error up to the end of EOF.
    Transmitted {
        /// The frame.
        frame: Frame,
    },
    /// The request was dropped: one-shot mode, and an error or a lost arbitration.
    Abandoned {
        /// The frame.
        frame: Frame,
    },
    /// A frame was accepted at the last but one bit of EOF.
    Received {
        /// The frame.
        frame: Frame,
    },
    /// The node detects an error.
    Error {
        /// Which.
        kind: ErrorKind,
        /// Where.
        place: Place,
        /// As what.
        role: Role,
        /// Whether TEC stays as it is: an exception to rule 3.
        exempt: bool,
    },
    /// A counter changed by a rule.
    Counted {
        /// Which rule.
        rule: Rule,
        /// The transmit error counter after it.
        tec: u16,
        /// The receive error counter after it.
        rec: u16,
    },
    /// The fault confinement state changed.
    Fault(FaultState),
    /// Rule 12: one more of the 128 sequences of 11 recessive bits.
    RecoverySequence(u8),
    /// An overload flag begins.
    Overload,
    /// FDF and res both recessive: the node waits for the bus to become idle.
    ProtocolException,
    /// Eleven recessive bits were seen: the node takes part from here on.
    Integrated,
}

/// One bit as a node sampled it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// What was sampled (for a transmitter with TDC in the data phase, still the pin).
    pub level: Level,
    /// What the node drove at the sample point.
    pub driven: Level,
    /// Whether it takes part in a frame, a flag or a delimiter.
    pub busy: bool,
}

/// Bits with the same level that a node sampled one after the other, no edge coming in between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleRun {
    /// The first sample point.
    pub first: Time,
    /// The last sample point.
    pub last: Time,
    /// How many they are, at least 1.
    pub bits: u32,
    /// Each of them.
    pub sample: Sample,
}

impl SampleRun {
    /// One bit.
    #[must_use]
    pub const fn one(at: Time, sample: Sample) -> Self {
        Self { first: at, last: at, bits: 1, sample }
    }
}

/// How an observer wants to be told what nodes sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// Not at all: such a run is the fastest.
    Untold,
    /// In runs of bits ([`Observer::samples`]). Those of one node come in order, after everything
    /// that happened in their time and before anything that the node does after them.
    InRuns,
    /// Each in its time ([`Observer::sample`]): such a run is computed bit by bit.
    InTime,
}

impl Sampling {
    /// What serves both.
    const fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::InTime, _) | (_, Self::InTime) => Self::InTime,
            (Self::InRuns, _) | (_, Self::InRuns) => Self::InRuns,
            (Self::Untold, Self::Untold) => Self::Untold,
        }
    }
}

/// Something from outside the nodes that changes levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Disturbance {
    /// One more (or one less) driver at the star point that is no node.
    Driven(Level),
    /// The line is shorted to recessive.
    Shorted,
    /// A short is gone.
    Unshorted,
    /// RXD of a node is held at a level, or let go.
    ForcedRxd(NodeId, Option<Level>),
}

/// Sees a run. Every method does nothing unless written.
pub trait Observer {
    /// What it wants to know of samples.
    const SAMPLING: Sampling = Sampling::Untold;

    /// The star point of the bus changed to `level`.
    fn bus(&mut self, at: Time, level: Level) {
        let _ = (at, level);
    }

    /// The TXD pin of a controller, after its gate, changed to `level`.
    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        let _ = (at, node, level);
    }

    /// A node sampled a bit.
    fn sample(&mut self, at: Time, node: NodeId, sample: &Sample) {
        let _ = (at, node, sample);
    }

    /// A node sampled some bits.
    fn samples(&mut self, node: NodeId, run: &SampleRun) {
        let _ = (node, run);
    }

    /// Something happened in a node.
    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        let _ = (at, node, event);
    }

    /// A node was set up anew: other timing, other mode, cut off, put back.
    fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        let _ = (at, node, config);
    }

    /// Something from outside the nodes begins or ends.
    fn disturbed(&mut self, at: Time, disturbance: Disturbance) {
        let _ = (at, disturbance);
    }

    /// The software of a node tells something about itself.
    fn told(&mut self, at: Time, node: NodeId, what: &str) {
        let _ = (at, node, what);
    }
}

/// Sees nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Blind;

impl Observer for Blind {}

/// Tells of a sample in its time, in the way that the observer wants.
pub(crate) fn tell<O: Observer>(observer: &mut O, at: Time, node: NodeId, sample: &Sample) {
    match O::SAMPLING {
        Sampling::Untold => {}
        Sampling::InRuns => observer.samples(node, &SampleRun::one(at, *sample)),
        Sampling::InTime => observer.sample(at, node, sample),
    }
}

impl<A: Observer, B: Observer> Observer for (A, B) {
    const SAMPLING: Sampling = A::SAMPLING.and(B::SAMPLING);

    fn bus(&mut self, at: Time, level: Level) {
        self.0.bus(at, level);
        self.1.bus(at, level);
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        self.0.txd(at, node, level);
        self.1.txd(at, node, level);
    }

    fn sample(&mut self, at: Time, node: NodeId, sample: &Sample) {
        tell(&mut self.0, at, node, sample);
        tell(&mut self.1, at, node, sample);
    }

    fn samples(&mut self, node: NodeId, run: &SampleRun) {
        self.0.samples(node, run);
        self.1.samples(node, run);
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        self.0.event(at, node, event);
        self.1.event(at, node, event);
    }

    fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        self.0.reconfigured(at, node, config);
        self.1.reconfigured(at, node, config);
    }

    fn disturbed(&mut self, at: Time, disturbance: Disturbance) {
        self.0.disturbed(at, disturbance);
        self.1.disturbed(at, disturbance);
    }

    fn told(&mut self, at: Time, node: NodeId, what: &str) {
        self.0.told(at, node, what);
        self.1.told(at, node, what);
    }
}

impl<O: Observer> Observer for &mut O {
    const SAMPLING: Sampling = O::SAMPLING;

    fn bus(&mut self, at: Time, level: Level) {
        (**self).bus(at, level);
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        (**self).txd(at, node, level);
    }

    fn sample(&mut self, at: Time, node: NodeId, sample: &Sample) {
        (**self).sample(at, node, sample);
    }

    fn samples(&mut self, node: NodeId, run: &SampleRun) {
        (**self).samples(node, run);
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        (**self).event(at, node, event);
    }

    fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        (**self).reconfigured(at, node, config);
    }

    fn disturbed(&mut self, at: Time, disturbance: Disturbance) {
        (**self).disturbed(at, disturbance);
    }

    fn told(&mut self, at: Time, node: NodeId, what: &str) {
        (**self).told(at, node, what);
    }
}
