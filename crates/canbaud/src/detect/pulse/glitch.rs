//! Runs too short to be bits, taken out before the bit time is known.

/// Widths tried, each twice the one before.
const WIDTHS: u32 = 8;

/// The widths below which runs are taken for glitches, one after the other: from twice the
/// shortest run, as long as longer runs are left to be bits.
pub(super) fn widths(runs: &[u32]) -> impl Iterator<Item = u32> + use<> {
    let shortest = runs.iter().copied().min().unwrap_or(0).max(1);
    let longest = runs.iter().copied().max().unwrap_or(0);
    (1..=WIDTHS)
        .map_while(move |shift| shortest.checked_mul(1 << shift))
        .take_while(move |width| *width <= longest / 3)
}

/// Copies `runs` to `out` without runs below `width`; a dropped run joins the two beside it.
///
/// Returns what was copied; `None` if nothing was dropped, or the first run would be.
pub(super) fn without<'a>(runs: &[u32], width: u32, out: &'a mut [u32]) -> Option<&'a [u32]> {
    let mut len = 0_usize;
    let mut joining = false;
    let mut dropped = false;
    for &run in runs {
        let last = len.checked_sub(1).and_then(|last| out.get_mut(last));
        match last {
            Some(last) if joining || run < width => {
                *last = last.saturating_add(run);
                joining = !joining;
                dropped = true;
            }
            None if run < width => return None,
            _ => {
                *out.get_mut(len)? = run;
                len += 1;
            }
        }
    }
    // A join left open means that the last dominant run itself is too short to be one.
    (dropped && !joining).then(|| out.get(..len)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_run_joins_its_neighbours() {
        let mut out = [0; 8];
        assert_eq!(without(&[10, 4, 1, 5, 10], 2, &mut out), Some(&[10, 10, 10][..]));
        assert_eq!(without(&[10, 4, 1, 1, 1, 5, 10], 2, &mut out), Some(&[10, 12, 10][..]));
    }

    #[test]
    fn clean_runs_and_runs_with_a_short_end_are_left_alone() {
        let mut out = [0; 8];
        assert_eq!(without(&[10, 4, 10], 2, &mut out), None);
        assert_eq!(without(&[1, 4, 10], 2, &mut out), None);
        assert_eq!(without(&[10, 4, 1], 2, &mut out), None);
    }
}
