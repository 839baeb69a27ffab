//! Edges to frames at a known bit rate, in fixed memory.

use super::activity::ActivityBuffer;
use super::attempts::read_best;
use super::clock::BitClock;
use super::item::{BusError, ErrorKind, FdCrc, Field, Item, ItemKind};
use super::line::Level;
use super::reader::{Activity, DataRate, Failure, Outcome, Rates, Reading};
use super::sums::PhaseSums;

/// The data phase of a CAN FD bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataTiming {
    /// Bit time in ticks, times 2^20.
    pub ticks_q20: u64,
    /// Length of the BRS bit in ticks, times 2^20: nominal up to the nominal sample point, data
    /// rate behind the data sample point.
    pub brs_ticks_q20: u64,
}

/// What a decoder must know of a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BusTiming {
    /// Nominal bit time in ticks, times 2^20.
    pub ticks_q20: u64,
    /// The data phase, if it is known.
    pub data: Option<DataTiming>,
    /// The CRC that CAN FD frames carry; the other one is recognized, too.
    pub fd_crc: FdCrc,
    /// How much later than edges to dominant the edges to recessive come, in ticks times 2^20.
    pub asymmetry_q20: i64,
}

impl BusTiming {
    /// A classic bus with this bit time in ticks (times 2^20).
    #[must_use]
    pub const fn classic(ticks_q20: u64) -> Self {
        Self { ticks_q20, data: None, fd_crc: FdCrc::Iso, asymmetry_q20: 0 }
    }

    pub(crate) fn rates(&self) -> Option<Rates> {
        let data = match self.data {
            Some(data) => Some(DataRate {
                clock: BitClock::new(data.ticks_q20)?,
                brs_ticks_q20: data.brs_ticks_q20,
            }),
            None => None,
        };
        Some(Rates {
            nominal: BitClock::new(self.ticks_q20)?,
            data,
            fd_crc: self.fd_crc,
            late_ticks_q20: self.asymmetry_q20,
        })
    }
}

/// One item with what its edges say about the sender's clock.
#[derive(Debug, Clone, Copy)]
pub struct Decoded {
    /// What was seen.
    pub item: Item,
    /// The edges of the nominal phase; meaningful for frames.
    pub nominal: PhaseSums,
    /// The edges of the data phase of a frame that switched its bit rate.
    pub data: PhaseSums,
}

/// Takes what a [`Decoder`] finds.
pub trait Listener {
    /// One item, in time order.
    fn item(&mut self, decoded: &Decoded);

    /// A CAN FD frame switches to a data bit rate that the decoder does not know. An answer lets
    /// it decode this frame and the ones behind it.
    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        let _ = wanted;
        None
    }
}

/// A frame whose data bit rate is asked for.
#[derive(Debug, Clone, Copy)]
pub struct DataRateWanted<'a> {
    pub(crate) activity: Activity<'a>,
    pub(crate) rates: Rates,
    pub(crate) brs_run: usize,
}

/// Decodes edges to frames at a known bit rate. `N` is the number of runs that one frame may
/// have: 160 suffice for any classic frame, 800 for any CAN FD frame.
///
/// ```
/// use canbaud::wire::{BusTiming, Decoded, Decoder, ItemKind, Level, Listener};
/// struct Count(u32);
/// impl Listener for Count {
///     fn item(&mut self, decoded: &Decoded) {
///         self.0 += u32::from(matches!(decoded.item.kind, ItemKind::Frame(_)));
///     }
/// }
/// // 16 ticks a bit; the edges of one remote frame, id 0x2AA, nobody acknowledges.
/// let mut decoder = Decoder::<160>::new(&BusTiming::classic(16 << 20)).unwrap();
/// let mut count = Count(0);
/// decoder.begin(0, Level::Recessive);
/// decoder.finish(100_000, &mut count);
/// assert_eq!(count.0, 0);
/// ```
#[derive(Debug, Clone)]
pub struct Decoder<const N: usize = 800> {
    rates: Rates,
    activity: ActivityBuffer<N>,
}

impl<const N: usize> Decoder<N> {
    /// A decoder for `timing`; `None` if a bit time lies outside 1 to 2^28 ticks.
    #[must_use]
    pub fn new(timing: &BusTiming) -> Option<Self> {
        let rates = timing.rates()?;
        let mut activity = ActivityBuffer::new();
        activity.set_limits(&rates);
        Some(Self { rates, activity })
    }

    /// Unbroken recording begins at `at`.
    pub fn begin(&mut self, at: u64, level: Level) {
        self.activity.begin(at, level);
    }

    /// Edges at `times`, strictly rising; each toggles the level.
    pub fn edges(&mut self, times: &[u64], listener: &mut impl Listener) {
        for &at in times {
            if self.activity.push(at) {
                self.settle(listener);
                self.activity.restart(at);
            }
        }
    }

    /// The recording ends at `at`, the line unchanged since the last edge.
    pub fn finish(&mut self, at: u64, listener: &mut impl Listener) {
        self.activity.close(at);
        self.settle(listener);
        self.activity.clear();
    }

    /// Reports what the activity that just ended was.
    fn settle(&mut self, listener: &mut impl Listener) {
        let Some(activity) = self.activity.activity() else { return };
        if self.activity.is_overload(activity) {
            let start = self.activity.origin();
            let end = self.activity.end();
            let item = Item { start, end, kind: ItemKind::Overload };
            listener.item(&plain(item));
            return;
        }
        let mut reading = read_best(activity, &self.rates);
        if let Outcome::DataRateWanted { brs_run } = reading.outcome {
            let wanted = DataRateWanted { activity, rates: self.rates, brs_run };
            if let Some(rate) = listener.data_rate(&wanted).and_then(|timing| {
                let clock = BitClock::new(timing.ticks_q20)?;
                Some(DataRate { clock, brs_ticks_q20: timing.brs_ticks_q20 })
            }) {
                self.rates.data = Some(rate);
                reading = read_best(activity, &self.rates);
                self.activity.set_limits(&self.rates);
            }
        }
        self.report(&reading, listener);
        if let Outcome::Frame { received, .. } | Outcome::Unacknowledged { received, .. } =
            reading.outcome
            && let Some(fd_crc) = received.fd_crc
        {
            self.rates.fd_crc = fd_crc;
        }
    }

    fn report(&self, reading: &Reading, listener: &mut impl Listener) {
        let start = self.activity.origin();
        let failure = match reading.outcome {
            Outcome::Frame { received, overload } => {
                // CRC delimiter, ACK slot, ACK delimiter and seven bits of EOF.
                let bits = self.rates.nominal.ticks(10).saturating_add(self.frame_ticks(reading));
                let end = start.saturating_add(bits);
                let item = Item { start, end, kind: ItemKind::Frame(received) };
                listener.item(&Decoded { item, nominal: reading.nominal, data: reading.data });
                if overload {
                    let item =
                        Item { start: end, end: self.activity.end(), kind: ItemKind::Overload };
                    listener.item(&plain(item));
                }
                return;
            }
            Outcome::DataRateWanted { brs_run } => {
                Failure { kind: ErrorKind::DataRateUnknown, field: Field::Control, run: brs_run }
            }
            Outcome::Unacknowledged { failure, .. } | Outcome::Failed(failure) => failure,
        };
        if self.activity.is_integrating() {
            return;
        }
        let cut = self.activity.is_cut_at(failure.run);
        let error = BusError {
            kind: if cut { ErrorKind::Truncated } else { failure.kind },
            field: failure.field,
            at: self.error_time(&failure),
            id: reading.id,
        };
        let item = Item { start, end: self.activity.end(), kind: ItemKind::Error(error) };
        listener.item(&plain(item));
    }

    /// When a receiver notices: for a stuff error at the sixth equal bit, else with the run.
    fn error_time(&self, failure: &Failure) -> u64 {
        let start = self.activity.run_start(failure.run);
        match failure.kind {
            ErrorKind::Stuff => {
                let end = self.activity.run_start(failure.run + 1).max(start);
                end.min(start.saturating_add(self.rates.nominal.ticks(11) / 2))
            }
            _ => start,
        }
    }

    /// From SOF to the end of the CRC sequence.
    fn frame_ticks(&self, reading: &Reading) -> u64 {
        let nominal = self.rates.nominal.ticks(reading.nominal_bits);
        match (reading.brs_run, self.rates.data) {
            (Some(_), Some(data)) => {
                let data_ticks = data.clock.ticks(reading.data_bits);
                nominal.saturating_add(data.brs_ticks_q20 >> 20).saturating_add(data_ticks)
            }
            _ => nominal,
        }
    }
}

/// An item without edges to measure.
fn plain(item: Item) -> Decoded {
    Decoded { item, nominal: PhaseSums::default(), data: PhaseSums::default() }
}
