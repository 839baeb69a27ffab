//! One stretch of bus activity, as runs of ticks, to one frame: what a receiver would say of it.
//!
//! In: runs that start with the dominant run of SOF, and the recessive gap behind them.
//! Out: a [`Reading`]. Never: state kept between two stretches.

mod classic;
mod fd;
mod header;
mod stuffed;
mod tail;

use super::bits::BitString;
use super::clock::BitClock;
use super::frame::Id;
use super::item::{ErrorKind, FdCrc, Field, Received};
use super::line::Level;
use super::sums::PhaseSums;
use super::sync::{Pace, Sync};

/// One stretch of activity: runs alternate from dominant, `gap` is the recessive run after the
/// last one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Activity<'a> {
    pub(crate) runs: &'a [u32],
    pub(crate) gap: u32,
}

impl Activity<'_> {
    /// Length and level of the run at `index`; the gap is the last.
    #[inline]
    fn run(&self, index: usize) -> Option<(u32, Level)> {
        let level = if index & 1 == 0 { Level::Dominant } else { Level::Recessive };
        match self.runs.get(index) {
            Some(&ticks) => Some((ticks, level)),
            None if index == self.runs.len() => Some((self.gap, Level::Recessive)),
            None => None,
        }
    }
}

/// The data bit time of a CAN FD bus, and where in the BRS bit it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DataRate {
    pub(crate) clock: BitClock,
    /// Length of the BRS bit: nominal up to the nominal sample point, data rate behind the data
    /// sample point. In ticks times 2^20.
    pub(crate) brs_ticks_q20: u64,
}

/// Everything a reader must know beforehand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Rates {
    pub(crate) nominal: BitClock,
    pub(crate) data: Option<DataRate>,
    pub(crate) fd_crc: FdCrc,
    /// How much later than edges to dominant the edges to recessive come, in ticks times 2^20.
    pub(crate) late_ticks_q20: i64,
}

/// How to place the bit grid on the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Placement {
    pub(crate) pace: Pace,
    /// How late the SOF edge was seen, in bits times 2^20.
    pub(crate) sof_error_q20: i32,
}

impl Placement {
    /// The first thing to try: every edge to dominant is a new origin.
    pub(crate) const ANCHORED: Self = Self { pace: Pace::Anchored, sof_error_q20: 0 };
    /// What to try where many other things are tried, too.
    pub(crate) const FEW: [Self; 2] =
        [Self::ANCHORED, Self { pace: Pace::Gentle, sof_error_q20: 0 }];
}

/// Why the stretch is no frame that a controller accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Failure {
    pub(crate) kind: ErrorKind,
    pub(crate) field: Field,
    /// Index of the run in which it showed.
    pub(crate) run: usize,
}

/// What became of the stretch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: readings live on the stack")]
pub(crate) enum Outcome {
    /// A frame. If `overload`, the last bit of EOF was dominant.
    Frame { received: Received, overload: bool },
    /// All of a frame, its CRC right, then the error flag of its sender, whom nobody acknowledged.
    Unacknowledged { received: Received, failure: Failure },
    /// The frame switches to a data bit rate that is not known; BRS is in the run at this index.
    DataRateWanted { brs_run: usize },
    /// No frame.
    Failed(Failure),
}

/// What one stretch says at the given rates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reading {
    pub(crate) outcome: Outcome,
    /// The identifier, once all of it was read.
    pub(crate) id: Option<Id>,
    /// Whether FDF says that it is a CAN FD frame.
    pub(crate) is_fd: bool,
    /// Whether reading got as far as the CRC.
    pub(crate) crc_compared: bool,
    /// Whether the CRC was right, also when the frame failed behind it.
    pub(crate) crc_right: bool,
    /// Edges of the nominal bit time up to the end of the CRC or the BRS bit.
    pub(crate) nominal: PhaseSums,
    /// Edges of the data phase behind the BRS bit.
    pub(crate) data: PhaseSums,
    /// Index of the run with a recessive BRS bit.
    pub(crate) brs_run: Option<usize>,
    /// Index of the run in which the CRC sequence ends.
    pub(crate) crc_run: usize,
    /// Bits at the nominal rate from SOF to the end of the CRC sequence (to BRS, if switched).
    pub(crate) nominal_bits: u32,
    /// Bits at the data rate.
    pub(crate) data_bits: u32,
}

impl Reading {
    /// The frame, if its CRC was right and its form, too.
    pub(crate) fn proven(&self) -> Option<Received> {
        match self.outcome {
            Outcome::Frame { received, .. } | Outcome::Unacknowledged { received, .. } => {
                Some(received)
            }
            Outcome::DataRateWanted { .. } | Outcome::Failed(_) => None,
        }
    }
}

/// Reads `activity` at `rates`.
pub(crate) fn read(activity: Activity<'_>, rates: &Rates, placement: Placement) -> Reading {
    let mut reader = Reader::new(activity, rates, placement);
    let outcome = match reader.frame() {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::Failed(failure),
    };
    Reading {
        outcome,
        id: reader.id(),
        is_fd: reader.is_fd,
        crc_compared: reader.crc_compared,
        crc_right: reader.crc_right,
        nominal: reader.nominal,
        data: reader.data,
        brs_run: reader.brs_run,
        crc_run: reader.crc_run,
        nominal_bits: reader.nominal_bits,
        data_bits: reader.data_bits,
    }
}

/// Which sums the next edge belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Nominal,
    Data,
}

struct Reader<'a> {
    activity: Activity<'a>,
    rates: &'a Rates,
    sync: Sync,
    /// Index of the next run.
    next: usize,
    /// Bits without stuff bits, from SOF.
    plain: BitString,
    /// Bits as they are on the wire, from SOF: what the CRC of CAN FD covers.
    raw: BitString,
    stuffing: Stuffing,
    stuff_bits: usize,
    phase: Phase,
    /// Bits and ticks since the origin of the phase.
    bits: u32,
    ticks: u32,
    nominal: PhaseSums,
    data: PhaseSums,
    nominal_bits: u32,
    data_bits: u32,
    brs_run: Option<usize>,
    crc_run: usize,
    is_fd: bool,
    crc_compared: bool,
    crc_right: bool,
}

/// Whether the next bit must be a stuff bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stuffing {
    Open,
    /// Five equal bits have passed.
    Due,
}

impl Stuffing {
    /// Stuff bits at the start of the next run: 0 or 1.
    const fn bits(self) -> u32 {
        match self {
            Self::Open => 0,
            Self::Due => 1,
        }
    }
}

impl<'a> Reader<'a> {
    fn new(activity: Activity<'a>, rates: &'a Rates, placement: Placement) -> Self {
        let late = rates.nominal.signed_bits_q20(rates.late_ticks_q20);
        let mut reader = Self {
            activity,
            rates,
            sync: Sync::new(placement.pace, rates.nominal, late, placement.sof_error_q20),
            next: 0,
            plain: BitString::new(),
            raw: BitString::new(),
            stuffing: Stuffing::Open,
            stuff_bits: 0,
            phase: Phase::Nominal,
            bits: 0,
            ticks: 0,
            nominal: PhaseSums::default(),
            data: PhaseSums::default(),
            nominal_bits: 0,
            data_bits: 0,
            brs_run: None,
            crc_run: 0,
            is_fd: false,
            crc_compared: false,
            crc_right: false,
        };
        reader.nominal.falling.push(0, 0);
        reader
    }

    fn frame(&mut self) -> Result<Outcome, Failure> {
        match self.header()? {
            header::Header::Classic(format) => self.classic(format),
            header::Header::Fd(format) => self.fd(format),
            header::Header::DataRateWanted { brs_run } => Ok(Outcome::DataRateWanted { brs_run }),
        }
    }

    /// The outcome once CRC and tail are read.
    fn conclude(
        &self,
        format: header::Format,
        crc: u32,
        fd_crc: Option<FdCrc>,
        tail: Result<tail::Tail, Failure>,
    ) -> Result<Outcome, Failure> {
        let received = |ack| -> Result<Received, Failure> {
            let frame = self.frame_of(format)?;
            Ok(Received { frame, crc, fd_crc, acknowledged: ack == Level::Dominant })
        };
        match tail {
            Ok(_) if !self.crc_right => Err(self.fail(ErrorKind::Crc, Field::Crc)),
            Ok(tail) => {
                Ok(Outcome::Frame { received: received(tail.ack)?, overload: tail.overload })
            }
            Err(failure) if failure.kind == ErrorKind::Acknowledge => {
                Ok(Outcome::Unacknowledged { received: received(Level::Recessive)?, failure })
            }
            Err(failure) => Err(failure),
        }
    }

    fn fail(&self, kind: ErrorKind, field: Field) -> Failure {
        Failure { kind, field, run: self.next }
    }

    /// Notes the edge at the end of a run of `ticks` that is `bits` long.
    #[inline]
    fn edge(&mut self, ticks: u32, bits: u32, level: Level) {
        self.bits += bits;
        self.ticks = self.ticks.saturating_add(ticks);
        let sums = match self.phase {
            Phase::Nominal => &mut self.nominal,
            Phase::Data => &mut self.data,
        };
        match level {
            Level::Dominant => sums.rising.push(self.bits, self.ticks),
            Level::Recessive => sums.falling.push(self.bits, self.ticks),
        }
    }

    /// The identifier, if enough bits were read.
    fn id(&self) -> Option<Id> {
        if self.plain.len() >= 14 && self.plain.level(13) == Level::Dominant {
            Id::base(self.plain.bits(1, 11) as u16)
        } else if self.plain.len() >= 32 {
            Id::extended((self.plain.bits(1, 11) << 18) | self.plain.bits(14, 18))
        } else {
            None
        }
    }
}
