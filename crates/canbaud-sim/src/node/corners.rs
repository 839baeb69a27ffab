//! Counts of what edges did.

use super::bit_time::SyncOutcome;

/// How often each corner of synchronisation was met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SyncCorners {
    /// Hard synchronisations.
    pub hard: u64,
    /// Edges in SYNC_SEG.
    pub in_sync_seg: u64,
    /// Positive phase errors below, at and above SJW.
    pub positive: [u64; 3],
    /// Negative phase errors below, at and above SJW.
    pub negative: [u64; 3],
    /// Edges that synchronise nothing.
    pub ignored: u64,
}

impl SyncCorners {
    pub(super) fn note(&mut self, outcome: SyncOutcome, sjw: u32) {
        let corner = |error: u32| match error.cmp(&sjw) {
            core::cmp::Ordering::Less => 0,
            core::cmp::Ordering::Equal => 1,
            core::cmp::Ordering::Greater => 2,
        };
        match outcome {
            SyncOutcome::Hard => self.hard += 1,
            SyncOutcome::InSyncSeg => self.in_sync_seg += 1,
            SyncOutcome::Lengthened { error, .. } => self.positive[corner(error)] += 1,
            SyncOutcome::Shortened { error, .. } => self.negative[corner(error)] += 1,
            SyncOutcome::Ignored => self.ignored += 1,
        }
    }
}
