//! Which scans are tried.

use canbaud::detect::scan::{Candidates, Evidence, FdSupport, Policy, Settings};
use canbaud::units::Micros;
use canbaud_link::sim::trial::{Audience, Content, Load, Report, Traffic, Trial};
use canbaud_link::sim::{Adapter, SimError, Stamps};
use canbaud_sim::Rng;
use canbaud_sim::around::Fifo;

use super::Score;

/// The bit rates of CANopen.
pub(super) const RATES: [u32; 8] =
    [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// Scans of one kind at all eight rates.
#[derive(Debug, Clone, Copy)]
pub struct Campaign {
    /// The adapter.
    pub adapter: Adapter,
    /// The policy.
    pub policy: Policy,
    /// How often frames are sent.
    pub load: Load,
    /// Who acknowledges.
    pub audience: Audience,
    /// Of a thousand frames, so many are destroyed.
    pub destroyed: u64,
    /// Trials at each rate.
    pub each: u64,
    /// When a trial without an outcome is cut off.
    pub limit: Micros,
}

/// The eight rates as candidates.
fn candidates() -> Candidates<8> {
    // There is room for eight.
    Candidates::canopen().unwrap_or_default()
}

impl Campaign {
    /// Runs it; `seed` is its luck, the same for every policy.
    ///
    /// # Errors
    /// [`SimError`] if no node can have a rate.
    pub fn run(&self, seed: u64) -> Result<Score, SimError> {
        let mut score = Score::default();
        for number in 0..self.each * 8 {
            let trial = Trial {
                bitrate: RATES[(number % 8) as usize],
                load: self.load,
                content: Content::Random,
                audience: self.audience,
                destroyed: self.destroyed,
                adapter: self.adapter,
                settings: Settings { policy: self.policy, ..Settings::default() },
                seed: seed.wrapping_mul(1_000_003).wrapping_add(number),
            };
            score.add(&trial.run(&candidates(), self.limit, Traffic::WhereHeard)?);
        }
        Ok(score)
    }
}

/// Trial number `number` of the million: everything by chance.
#[must_use]
pub fn random(number: u64) -> Trial {
    let mut rng = Rng::for_purpose(number, 77);
    let mut pick = |limit: u64| rng.below(limit) as usize;
    let stamps = [Stamps::Hardware, Stamps::Arrival, Stamps::None];
    let mut adapter = match pick(2) {
        0 => Adapter::embedded(),
        _ => Adapter::usb(Evidence::Errors),
    };
    adapter.evidence = match pick(8) {
        0..=4 => Evidence::Errors,
        5 | 6 => Evidence::Counter,
        _ => Evidence::FramesOnly,
    };
    adapter.counters = Adapter::usb(Evidence::Counter).counters;
    adapter.stamps = stamps[pick(3)];
    adapter.fifo = [Fifo::Kept, Fifo::Cleared][pick(2)];
    adapter.fd = [FdSupport::Classic, FdSupport::Fd][pick(2)];
    adapter.reconfiguration = Micros::from_ms([1, 2, 5, 10, 20, 50][pick(6)]);
    let last_known = match pick(8) {
        0 => canbaud::units::Bitrate::new(RATES[pick(8)]),
        _ => None,
    };
    Trial {
        bitrate: RATES[pick(8)],
        load: Load::Permille([10, 20, 50, 100, 200, 350, 500, 650, 800, 900][pick(10)]),
        content: if pick(10) == 0 { Content::Same } else { Content::Random },
        audience: if pick(50) == 0 { Audience::Nobody } else { Audience::Acknowledges },
        destroyed: [0, 0, 10, 50][pick(4)],
        adapter,
        settings: Settings { last_known, ..Settings::default() },
        seed: number,
    }
}

/// Runs it.
///
/// # Errors
/// [`SimError`] if no node can have the rate.
pub fn run_random(number: u64) -> Result<Report, SimError> {
    random(number).run(&candidates(), Micros::from_ms(60_000), Traffic::WhereHeard)
}
