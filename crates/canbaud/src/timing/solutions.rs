//! The ranked list of settings.

use super::rank::Candidate;
use super::search::{CLOCK_MAX, Points};
use super::solve::{Solution, finish, solve};
use super::{BitTiming, Limits, Request, SolveError};

/// The best settings in order, at most `K`.
#[derive(Debug, Clone, Copy)]
pub struct Solutions<const K: usize> {
    list: [Option<Solution>; K],
}

impl<const K: usize> Solutions<K> {
    /// The solutions, best first.
    pub fn iter(&self) -> impl Iterator<Item = &Solution> {
        self.list.iter().flatten()
    }

    /// The same list with every timing replaced; bit rates must not change.
    pub(super) fn map_timing(self, replace: impl Fn(BitTiming) -> BitTiming) -> Self {
        let list = self.list.map(|slot| slot.map(|s| Solution { timing: replace(s.timing), ..s }));
        Self { list }
    }
}

/// The `K` best settings within the tolerance, ranked as [`solve`] ranks; the first is its answer.
///
/// Settings that differ in prescaler, number of quanta or sample point count as different.
/// Work: the quanta times the prescalers within the tolerance.
///
/// ```
/// use canbaud::timing::{controllers::bxcan, solutions, Request};
/// use canbaud::units::{Bitrate, Hertz};
/// let request = Request::new(Hertz::new(48_000_000).unwrap(), Bitrate::new(500_000).unwrap());
/// let ranked = solutions::<3>(&request, &bxcan::NOMINAL).unwrap();
/// let quanta: Vec<u32> = ranked.iter().map(|s| s.timing.quanta()).collect();
/// assert_eq!(quanta, [16, 8, 12]); // 87.5 %, 87.5 %, 83.3 %
/// ```
///
/// # Errors
/// As [`solve`], when there is no setting at all.
pub fn solutions<const K: usize>(
    request: &Request,
    limits: &Limits,
) -> Result<Solutions<K>, SolveError> {
    solutions_where(request, limits, |_| true)
}

/// As [`solutions`], only settings for which `accept` is true; the list may be empty.
///
/// # Errors
/// As [`solve`], when there is no setting at all, whether accepted or not.
pub fn solutions_where<const K: usize>(
    request: &Request,
    limits: &Limits,
    accept: impl Fn(&BitTiming) -> bool,
) -> Result<Solutions<K>, SolveError> {
    solve(request, limits)?;
    let mut ranking = Ranking::<K> { best: [None; K] };
    for_each(request, limits, |candidate| {
        if !ranking.would_take(&candidate) {
            return false;
        }
        if finish(&candidate, request, limits).is_ok_and(|solution| accept(&solution.timing)) {
            ranking.insert(candidate);
        }
        true
    });
    Ok(Solutions { list: ranking.best.map(|c| c.and_then(|c| finish(&c, request, limits).ok())) })
}

struct Ranking<const K: usize> {
    best: [Option<Candidate>; K],
}

impl<const K: usize> Ranking<K> {
    fn would_take(&self, candidate: &Candidate) -> bool {
        match self.best.last() {
            Some(Some(worst)) => candidate.beats(worst),
            Some(None) => true,
            None => false,
        }
    }

    fn insert(&mut self, candidate: Candidate) {
        let mut moving = Some(candidate);
        for place in &mut self.best {
            match (&*place, &moving) {
                // The same setting reached through two progressions.
                (Some(here), Some(new)) if !here.beats(new) && !new.beats(here) => return,
                (Some(here), Some(new)) if !new.beats(here) => {}
                _ => core::mem::swap(place, &mut moving),
            }
        }
    }
}

/// Calls `visit` for every setting within the tolerance. For each prescaler and number of quanta
/// the sample points come best first; `visit` returns false when worse ones are of no use.
fn for_each(request: &Request, limits: &Limits, mut visit: impl FnMut(Candidate) -> bool) {
    let points = Points::new(request, limits);
    let quanta = points.quanta(limits);
    // `solve` has refused a clock above CLOCK_MAX.
    let clock = u32::try_from(request.clock.hertz()).unwrap_or(CLOCK_MAX);
    let unit =
        u64::from(request.bitrate.bits_per_second()) * u64::from(limits.clock_divider.max(1));
    for n in u32::from(quanta.min)..=u32::from(quanta.max) {
        for span in limits.prescalers.spans() {
            let Some((lowest, highest)) = span.multiples() else { continue };
            let (low, high) = prescalers_within(u64::from(clock), unit * u64::from(n), request);
            // Not 0, or there would be no multiples.
            let step = u64::from(span.step.max(1));
            let low = low.div_ceil(step).max(lowest.into());
            let high = (high / step).min(highest.into());
            for multiple in low..=high {
                let prescaler = multiple as u32 * u32::from(span.step);
                let clocks = unit * u64::from(n) * u64::from(prescaler);
                let Ok(clocks) = u32::try_from(clocks) else { break };
                let product = prescaler * n;
                let rate_error = clocks.abs_diff(clock);
                for_each_point(&points, n, |tseg2| {
                    let point_error = points.error(n, tseg2);
                    visit(Candidate {
                        rate_error,
                        product,
                        point_error,
                        quanta: n,
                        tseg2,
                        prescaler,
                    })
                });
            }
        }
    }
}

/// The prescalers whose rate error with divisor `per_step` each is within the tolerance, and at
/// most a factor of two off.
fn prescalers_within(clock: u64, per_step: u64, request: &Request) -> (u64, u64) {
    let tolerance = u128::from(request.tolerance_ppm.min(1_000_000));
    let quotient = |a: u128, b: u128| a.checked_div(b).unwrap_or(0);
    let scaled = u128::from(clock) * 1_000_000;
    let per_step = u128::from(per_step);
    let fastest = per_step * (1_000_000 + tolerance);
    let low = quotient(scaled + fastest - 1, fastest);
    let half = quotient(2 * u128::from(clock), per_step);
    let high = match 1_000_000 - tolerance {
        0 => half,
        slowest => quotient(scaled, per_step * slowest).min(half),
    };
    (low as u64, high as u64)
}

/// Calls `visit` with TSEG2 from the best outwards, ties the longer first, until it returns false.
fn for_each_point(points: &Points, quanta: u32, mut visit: impl FnMut(u32) -> bool) {
    let range = points.tseg2_range(quanta);
    let (low, high) = (range.min.max(0) as u32, range.max.max(0) as u32);
    if range.min > range.max {
        return;
    }
    let error = |tseg2: u32| points.error(quanta, tseg2);
    let best = points.best(quanta).unwrap_or(low).clamp(low, high);
    let (mut down, mut up) = (best.checked_sub(1), best + 1);
    if !visit(best) {
        return;
    }
    loop {
        let below = down.filter(|t| *t >= low);
        let above = Some(up).filter(|t| *t <= high);
        let next = match (below, above) {
            (Some(b), Some(a)) if error(b) < error(a) => b,
            (_, Some(a)) => a,
            (Some(b), None) => b,
            (None, None) => return,
        };
        if Some(next) == above {
            up += 1;
        } else {
            down = next.checked_sub(1);
        }
        if !visit(next) {
            return;
        }
    }
}
