//! What the decoded items say about the bus.

use std::collections::HashMap;

use canbaud::detect::{BitTime, Measurement, find_data_rate};
use canbaud::wire::{
    BusError, DataRateWanted, DataTiming, Decoded, ErrorKind, FdCrc, FrameKind, Id, Item, ItemKind,
    Listener, Received,
};

use super::channel::ItemSink;
use super::known::Grid;
use crate::report::FrameCounts;

/// Senders whose clocks are told apart; more identifiers share the last one.
const SENDERS_MAX: usize = 4096;
/// Proof beyond this many bits adds nothing that a person could tell apart from certainty.
const PROOF_BITS_MAX: u32 = 1000;

/// Clocks of nodes that can talk to each other differ by less than a 64th.
const OFF_RATE_SHIFT: u32 = 6;
/// Fewest ticks a bit (times 2^20) at which one frame tells its bit time that well.
const OFF_RATE_TICKS_Q20: u64 = 4 << 20;

/// Counts and measures.
pub(super) struct Evidence {
    grid: Grid,
    pub(super) counts: FrameCounts,
    pub(super) nominal: Measurement,
    pub(super) data: Measurement,
    /// Ticks in which the bus was busy.
    pub(super) busy_ticks: u64,
    /// Errors that say that nobody acknowledged.
    pub(super) acknowledge_errors: u64,
    pub(super) data_rate_unknown: u64,
    /// Frames whose own bit time lies further off than any clock of a node.
    pub(super) off_rate: u64,
    pub(super) proof_bits: u32,
    last_frame: Option<Received>,
    senders: HashMap<Id, Measurement>,
}

impl FrameCounts {
    /// Frames that a receiver accepts.
    pub(crate) const fn good(&self) -> u64 {
        self.classic + self.remote + self.fd
    }
}

impl Evidence {
    pub(super) fn new(grid: Grid) -> Self {
        Self {
            grid,
            counts: FrameCounts::default(),
            nominal: Measurement::default(),
            data: Measurement::default(),
            busy_ticks: 0,
            acknowledge_errors: 0,
            data_rate_unknown: 0,
            off_rate: 0,
            proof_bits: 0,
            last_frame: None,
            senders: HashMap::new(),
        }
    }

    fn frame(&mut self, received: &Received, decoded: &Decoded) {
        let counts = &mut self.counts;
        match received.frame.kind() {
            FrameKind::Data => counts.classic += 1,
            FrameKind::Remote => counts.remote += 1,
            FrameKind::Fd { brs, .. } => {
                counts.fd += 1;
                counts.fd_brs += u64::from(brs);
                counts.fd_non_iso += u64::from(received.fd_crc == Some(FdCrc::NonIso));
            }
        }
        counts.extended += u64::from(received.frame.id().is_extended());
        counts.unacknowledged += u64::from(!received.acknowledged);
        let fit = decoded.nominal.fit();
        let off = match (fit.ticks_q20(), self.nominal.bit_time()) {
            (Some(own), Some(all)) => own.abs_diff(all.ticks_q20) > all.ticks_q20 >> OFF_RATE_SHIFT,
            _ => false,
        };
        // With few ticks a bit, the bit time of one frame is no sharper than that.
        if off && fit.ticks_q20().is_some_and(|ticks| ticks >= OFF_RATE_TICKS_Q20) {
            self.off_rate += 1;
        }
        self.nominal.add_fit(&fit);
        self.data.add(&decoded.data);
        let id = received.frame.id();
        if self.senders.len() < SENDERS_MAX || self.senders.contains_key(&id) {
            self.senders.entry(id).or_default().add_fit(&fit);
        }
        // The same frame again repeats the same accident, if it is one.
        if self.last_frame.is_none_or(|last| last.frame != received.frame) {
            let crc_bits = match received.fd_crc {
                None => 15,
                Some(_) if received.frame.data().len() <= 16 => 17,
                Some(_) => 21,
            };
            self.proof_bits = (self.proof_bits + crc_bits).min(PROOF_BITS_MAX);
        }
        self.last_frame = Some(*received);
    }

    fn item(&mut self, decoded: &Decoded) {
        let item = &decoded.item;
        self.busy_ticks += item.end.saturating_sub(item.start);
        match &item.kind {
            ItemKind::Frame(received) => self.frame(received, decoded),
            ItemKind::Error(error) => {
                let truncated = error.kind == ErrorKind::Truncated;
                self.counts.error += u64::from(!truncated);
                self.counts.truncated += u64::from(truncated);
                self.acknowledge_errors += u64::from(error.kind == ErrorKind::Acknowledge);
                self.data_rate_unknown += u64::from(error.kind == ErrorKind::DataRateUnknown);
            }
            ItemKind::Overload => self.counts.overload += 1,
        }
    }

    /// Difference between the fastest and the slowest clock among the identifiers, in ppm, as far
    /// as it stands out of the uncertainty of each.
    pub(super) fn clock_spread_ppm(&self) -> Option<f64> {
        const FRAMES_MIN: u32 = 4;
        const UNCERTAINTY_PPB_MAX: u32 = 30_000;
        let bits: Vec<BitTime> = self
            .senders
            .values()
            .filter(|sender| sender.frames() >= FRAMES_MIN)
            .filter_map(Measurement::bit_time)
            .filter(|bit| bit.uncertainty_ppb <= UNCERTAINTY_PPB_MAX)
            .collect();
        let low = bits.iter().min_by_key(|bit| bit.ticks_q20)?;
        let high = bits.iter().max_by_key(|bit| bit.ticks_q20)?;
        let spread = (high.ticks_q20 - low.ticks_q20) as f64 / low.ticks_q20 as f64 * 1e6;
        let noise = f64::from(low.uncertainty_ppb.max(high.uncertainty_ppb)) / 1e3;
        (bits.len() >= 2 && spread > 4.0 * noise).then_some(spread)
    }
}

/// Counts items and hands them on.
pub(super) struct Counting<'a> {
    pub(super) evidence: &'a mut Evidence,
    pub(super) sink: ItemSink<'a>,
}

impl Listener for Counting<'_> {
    fn item(&mut self, decoded: &Decoded) {
        self.evidence.item(decoded);
        let item = decoded.item;
        let grid = self.evidence.grid;
        let kind = match item.kind {
            ItemKind::Error(error) => {
                ItemKind::Error(BusError { at: grid.back(error.at), ..error })
            }
            kind @ (ItemKind::Frame(_) | ItemKind::Overload) => kind,
        };
        (self.sink)(&Item { start: grid.back(item.start), end: grid.back(item.end), kind });
    }

    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        find_data_rate(wanted)
    }
}
