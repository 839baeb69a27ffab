//! Bit timings and clocks.

use canbaud::units::{Bitrate, Permille};

use super::Outcome;
use crate::scenario::model::{NodeTable, TimingTable};
use crate::timing::BitTiming;

fn explicit(table: &TimingTable) -> Outcome<BitTiming> {
    let TimingTable { prescaler, prop_seg, phase_seg1, phase_seg2, sjw } = *table;
    BitTiming::new(prescaler, prop_seg, phase_seg1, phase_seg2, sjw).map_err(|e| e.to_string())
}

pub(in crate::scenario) fn timing_for(
    clock: u64,
    rate: Bitrate,
    permille: u16,
) -> Outcome<BitTiming> {
    let sample_point = Permille::new(permille).unwrap_or_default();
    BitTiming::find(clock, rate.bits_per_second(), sample_point).map_err(|e| e.to_string())
}

/// Sample points of CANopen: 75 % at 1 Mbit/s, 80 % above 500 kbit/s, else 87.5 % [Koppe, table 1].
pub(in crate::scenario) fn usual_sample_point(rate: Bitrate) -> u16 {
    match rate.bits_per_second() {
        0..=500_000 => 875,
        500_001..=800_000 => 800,
        _ => 750,
    }
}

pub(super) fn ppb(ppm: f64) -> Outcome<i64> {
    if (-500_000.0..=500_000.0).contains(&ppm) {
        Ok((ppm * 1_000.0).round() as i64)
    } else {
        Err(format!("ppm is {ppm}, allowed are -500000 to 500000"))
    }
}

pub(super) fn timings(table: &NodeTable, hertz: u64) -> Outcome<(BitTiming, Option<BitTiming>)> {
    let data = match (&table.data_timing, table.data_bitrate) {
        (Some(timing), None) => Some(explicit(timing)?),
        (None, Some(rate)) => Some(timing_for(hertz, rate.0, 800)?),
        (None, None) => None,
        (Some(_), Some(_)) => return Err("give data_bitrate or data_timing, not both".into()),
    };
    let nominal = match (&table.timing, table.bitrate) {
        (Some(timing), None) => return Ok((explicit(timing)?, data)),
        (None, Some(rate)) => {
            let permille = match table.sample_point {
                None => usual_sample_point(rate.0),
                Some(percent) if (1.0..=99.0).contains(&percent) => (percent * 10.0).round() as u16,
                Some(percent) => {
                    return Err(format!(
                        "sample_point is {percent}, allowed are 1 to 99 (percent)"
                    ));
                }
            };
            timing_for(hertz, rate.0, permille)?
        }
        _ => return Err(format!("node \"{}\" needs bitrate or timing", table.name)),
    };
    let nominal = match table.sjw {
        Some(sjw) => nominal.with_sjw(sjw).map_err(|error| error.to_string())?,
        None => nominal,
    };
    let same_quanta = data.and_then(|data| nominal.with_prescaler(data.prescaler()));
    Ok((same_quanta.unwrap_or(nominal), data))
}
