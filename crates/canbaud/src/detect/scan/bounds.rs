//! How long things last at most.

use super::{Candidate, Capabilities, Policy, Settings};
use crate::units::Micros;

/// Bits of the longest classic frame with all stuff bits, and the intermission behind it.
pub(super) const LONGEST_FRAME: u64 = 160;
/// Bits that an error frame and the frame sent again behind it last.
pub(super) const RETRANSMISSION: u64 = 12 + 8 + 3 + LONGEST_FRAME;
/// Bits before a controller that was just switched on can have received anything: it waits for 11
/// recessive bits, and the shortest frame has 44.
pub(super) const FIRST_FRAME: u64 = 50;

/// What a step may cost at most, listening apart.
fn switching(capabilities: &Capabilities<'_>) -> Micros {
    capabilities.reconfiguration + capabilities.latency
}

/// How long a step may listen at most while nothing is heard.
pub(super) fn patience(candidate: &Candidate, settings: &Settings) -> Micros {
    Micros::of_bits(2 * LONGEST_FRAME, candidate.nominal) + settings.pause
}

/// From the first poll to an outcome, at most; `None` if there is no such time.
pub(super) fn total(
    candidates: &[Candidate],
    capabilities: &Capabilities<'_>,
    settings: &Settings,
) -> Option<Micros> {
    let step = |candidate: &Candidate| {
        let listening = match settings.policy {
            Policy::Koppe => return None,
            Policy::FixedDwell => settings.dwell,
            Policy::Weighing | Policy::Survey => patience(candidate, settings),
        };
        Some(switching(capabilities) + listening)
    };
    let round = candidates.iter().map(step).try_fold(Micros(0), |sum, step| Some(sum + step?))?;
    Some(round.times(settings.rounds.max(1).into()))
}
