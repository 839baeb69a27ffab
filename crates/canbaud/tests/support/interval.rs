//! What the time stamps of a line without asymmetry and jitter allow: every edge lies within the
//! tick before its stamp, so each pair of edges bounds the bit time from both sides.

use super::line::{Edge, Phase};

/// The bit times that no pair of edges contradicts, in ticks: `(least, greatest)`; the true bit
/// number of every edge is given. `None` without two edges of one block.
pub fn feasible(edges: &[Edge], phase: Phase) -> Option<(f64, f64)> {
    let mut range: Option<(f64, f64)> = None;
    for (i, later) in edges.iter().enumerate() {
        for earlier in &edges[..i] {
            let (Some(a), Some(b)) = (earlier.grid, later.grid) else { continue };
            if a.phase != phase || a.block != b.block || a.index == b.index {
                continue;
            }
            let bits = f64::from(b.index - a.index);
            let ticks = (later.at - earlier.at) as f64;
            let (least, greatest) = range.unwrap_or((0.0, f64::INFINITY));
            range = Some((least.max((ticks - 1.0) / bits), greatest.min((ticks + 1.0) / bits)));
        }
    }
    range
}
