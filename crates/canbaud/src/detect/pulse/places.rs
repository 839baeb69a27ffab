//! The edges of a frame that was read, with their bit numbers.

use super::prove::Attempt;
use crate::wire::Level;
use crate::wire::clock::BitClock;
use crate::wire::reader::Activity;
use crate::wire::sync::Sync;

/// Edges that are looked at; a longer frame says enough in its first part.
const EDGES_MAX: usize = 80;

/// An edge: how many ticks and bits it lies behind the first one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) ticks: u32,
    pub(super) bits: u32,
}

/// Whether all edges of the phase are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    Whole,
    FirstPart,
}

/// The edges of one phase; every other one has the same polarity.
#[derive(Debug, Clone)]
pub(super) struct Places {
    places: [Place; EDGES_MAX],
    count: usize,
    pub(super) extent: Extent,
}

impl Places {
    /// The edges at the nominal bit rate, up to the end of the CRC or to BRS.
    pub(super) fn nominal(activity: Activity<'_>, attempt: &Attempt) -> Self {
        let end = attempt.reading.brs_run.unwrap_or(attempt.reading.crc_run);
        let runs = activity.runs.get(..end).unwrap_or(&[]);
        Self::count(runs, attempt, attempt.rates.nominal, attempt.placement.sof_error_q20)
    }

    /// The edges at the data bit rate; `None` if the frame did not switch.
    pub(super) fn data(activity: Activity<'_>, attempt: &Attempt) -> Option<Self> {
        let runs = activity.runs.get(attempt.reading.brs_run? + 1..attempt.reading.crc_run)?;
        Some(Self::count(runs, attempt, attempt.rates.data?.clock, 0))
    }

    /// Counts as the reader did that read the frame.
    fn count(runs: &[u32], attempt: &Attempt, clock: BitClock, first_error_q20: i32) -> Self {
        let late = clock.signed_bits_q20(attempt.rates.late_ticks_q20);
        let mut sync = Sync::new(attempt.placement.pace, clock, late, first_error_q20);
        let mut here = Place { ticks: 0, bits: 0 };
        let mut places = [here; EDGES_MAX];
        let mut count = 1;
        let levels = [Level::Dominant, Level::Recessive].into_iter().cycle();
        for ((&run, level), slot) in runs.iter().zip(levels).zip(places.iter_mut().skip(1)) {
            here.ticks = here.ticks.saturating_add(run);
            here.bits += sync.bits(run, level);
            *slot = here;
            count += 1;
        }
        let extent = if runs.len() < EDGES_MAX { Extent::Whole } else { Extent::FirstPart };
        Self { places, count, extent }
    }

    pub(super) fn as_slice(&self) -> &[Place] {
        self.places.get(..self.count).unwrap_or(&[])
    }
}
