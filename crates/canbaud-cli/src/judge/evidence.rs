//! What the decoded items say about the bus.

use std::collections::HashMap;

use canbaud::detect::{Measurement, find_data_rate};
use canbaud::wire::{
    DataRateWanted, DataTiming, Decoded, ErrorKind, FdCrc, FrameKind, Id, Item, ItemKind, Listener,
    Received,
};

use super::channel::ItemSink;
use crate::report::FrameCounts;

/// Senders whose clocks are told apart; more identifiers share the last one.
const SENDERS_MAX: usize = 4096;
/// Proof beyond this many bits adds nothing that a person could tell apart from certainty.
const PROOF_BITS_MAX: u32 = 1000;

/// Counts and measures.
pub(super) struct Evidence {
    shift: u32,
    pub(super) counts: FrameCounts,
    pub(super) nominal: Measurement,
    pub(super) data: Measurement,
    /// Ticks in which the bus was busy.
    pub(super) busy_ticks: u64,
    /// Errors that say that nobody acknowledged.
    pub(super) acknowledge_errors: u64,
    pub(super) data_rate_unknown: u64,
    pub(super) truncated: u64,
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
    pub(super) fn new(shift: u32) -> Self {
        Self {
            shift,
            counts: FrameCounts::default(),
            nominal: Measurement::default(),
            data: Measurement::default(),
            busy_ticks: 0,
            acknowledge_errors: 0,
            data_rate_unknown: 0,
            truncated: 0,
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
                self.counts.error += 1;
                self.acknowledge_errors += u64::from(error.kind == ErrorKind::Acknowledge);
                self.data_rate_unknown += u64::from(error.kind == ErrorKind::DataRateUnknown);
                self.truncated += u64::from(error.kind == ErrorKind::Truncated);
            }
            ItemKind::Overload => self.counts.overload += 1,
        }
    }

    /// Difference between the fastest and the slowest clock among the identifiers, in ppm, as far
    /// as it stands out of the uncertainty of each.
    pub(super) fn clock_spread_ppm(&self) -> Option<f64> {
        const UNCERTAINTY_PPB_MAX: u32 = 30_000;
        let mut ticks = self
            .senders
            .values()
            .filter_map(Measurement::bit_time)
            .filter(|bit| bit.uncertainty_ppb <= UNCERTAINTY_PPB_MAX)
            .map(|bit| bit.ticks_q20);
        let first = ticks.next()?;
        let second = ticks.next()?;
        let start = (first.min(second), first.max(second));
        let (low, high) = ticks.fold(start, |(low, high), t| (low.min(t), high.max(t)));
        Some((high - low) as f64 / low as f64 * 1e6)
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
        let shift = self.evidence.shift;
        (self.sink)(&Item { start: item.start << shift, end: item.end << shift, ..item });
    }

    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        find_data_rate(wanted)
    }
}
