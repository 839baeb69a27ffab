//! The ways to place the bit grid on a frame's edges, in the order they are tried.

use super::clock::BIT_Q20;
use super::item::FdCrc;
use super::phase::first_edge_error;
use super::reader::{Activity, Outcome, Placement, Rates, Reading, read};
use super::sync::Pace;

/// Reads `activity` by the first placement that gives a frame; if none does, as the first failed.
///
/// A frame counts only with its CRC right, so a further placement cannot invent one but by the
/// chance of a CRC.
pub(crate) fn read_best(activity: Activity<'_>, rates: &Rates) -> Reading {
    let first = read(activity, rates, Placement::ANCHORED);
    if is_settled(&first) {
        return first;
    }
    let other = Rates { fd_crc: other_crc(rates.fd_crc), ..*rates };
    let flavours = if first.is_fd { 2 } else { 1 };
    for rates in [rates, &other].into_iter().take(flavours) {
        for placement in placements(activity, rates) {
            let reading = read(activity, rates, placement);
            if matches!(reading.outcome, Outcome::Frame { .. }) {
                return reading;
            }
        }
    }
    first
}

/// Whether another placement could not say more.
fn is_settled(reading: &Reading) -> bool {
    match reading.outcome {
        Outcome::Frame { .. } | Outcome::Unacknowledged { .. } | Outcome::DataRateWanted { .. } => {
            true
        }
        Outcome::Failed(_) => reading.crc_right,
    }
}

/// The ways to place the grid on `activity`, the cheapest first.
pub(crate) fn placements<'a>(
    activity: Activity<'a>,
    rates: &Rates,
) -> impl Iterator<Item = Placement> + use<'a> {
    let nominal = rates.nominal;
    // With many ticks a bit, rounding moves no edge far enough to need another grid.
    let count = match nominal.ticks_q20() >> 20 {
        0..8 => 6,
        8..32 => 4,
        _ => 2,
    };
    // How late the first edge was, once it is needed.
    let mut late = None;
    (0..count).map(move |index| {
        let placement = |pace, sof_error_q20| Placement { pace, sof_error_q20 };
        let mut late = || *late.get_or_insert_with(|| first_edge_error(activity.runs, nominal).0);
        match index {
            0 => Placement::ANCHORED,
            1 => placement(Pace::Gentle, 0),
            2 => placement(Pace::Grid, late()),
            3 => placement(Pace::Gentle, late()),
            4 => placement(Pace::Grid, BIT_Q20 / 4),
            _ => placement(Pace::Grid, -BIT_Q20 / 4),
        }
    })
}

const fn other_crc(fd_crc: FdCrc) -> FdCrc {
    match fd_crc {
        FdCrc::Iso => FdCrc::NonIso,
        FdCrc::NonIso => FdCrc::Iso,
    }
}
