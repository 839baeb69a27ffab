//! The widest bit timing for a sweep.

use super::netlink::{TimingConst, TimingInfo};

/// The same rate with the sample point near the middle and the largest SJW; `None` if the limits
/// do not allow it.
pub(super) fn wide(timing: TimingInfo, limits: &TimingConst) -> Option<TimingInfo> {
    let quanta = timing.quanta();
    let longest = limits.tseg2.1.min((quanta - 1) / 2);
    let tseg2 = longest.max((quanta - 1).saturating_sub(limits.tseg1.1));
    let tseg1 = (quanta - 1).checked_sub(tseg2)?;
    let fits = (limits.tseg1.0..=limits.tseg1.1).contains(&tseg1)
        && (limits.tseg2.0..=limits.tseg2.1).contains(&tseg2);
    // At least one TQ for PROP_SEG.
    let phase_seg1 = tseg2.min(tseg1.checked_sub(1)?);
    fits.then_some(TimingInfo {
        bitrate: 0,
        sample_point: 0,
        tq: timing.tq,
        prop_seg: tseg1 - phase_seg1,
        phase_seg1,
        phase_seg2: tseg2,
        sjw: limits.sjw_max.min(phase_seg1).min(tseg2),
        brp: 0,
    })
}

#[cfg(test)]
mod tests;
