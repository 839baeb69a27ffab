//! How well the bit time can be known from the edges of a recording, if someone tells the bit
//! number of each: linear least squares with a start per block, one polarity offset, and white
//! noise.

use super::line::{Edge, Phase};

/// Standard deviations of the best linear unbiased estimate, and that estimate, in ticks.
#[derive(Debug, Clone, Copy)]
pub struct Bound {
    pub nominal: Option<Estimate>,
    pub data: Option<Estimate>,
}

/// A bit time and its standard deviation, in ticks.
#[derive(Debug, Clone, Copy)]
pub struct Estimate {
    pub ticks: f64,
    pub sigma: f64,
}

/// Unknowns shared by all blocks: nominal bit time, data bit time, polarity offset.
const SHARED: usize = 3;

type Row = [f64; SHARED];

impl Bound {
    /// The bound for `edges` (those on a grid count), each with standard deviation `noise` ticks.
    pub fn of(edges: &[Edge], noise: f64) -> Self {
        let (normal, right) = normal_equations(edges);
        let active: Vec<usize> = (0..SHARED).filter(|&i| normal[i][i] > 1e-9).collect();
        let estimate = |which: usize| {
            let place = active.iter().position(|&i| i == which)?;
            let inverse = invert(&normal, &active)?;
            let row = &inverse[place];
            let ticks = row.iter().zip(&active).map(|(c, &i)| c * right[i]).sum();
            Some(Estimate { ticks, sigma: noise * row[place].sqrt() })
        };
        Self { nominal: estimate(0), data: estimate(1) }
    }
}

/// Normal equations after the start of every block has been eliminated by centring.
fn normal_equations(edges: &[Edge]) -> ([Row; SHARED], Row) {
    let origin = edges.first().map_or(0, |edge| edge.at);
    let mut normal = [[0.0; SHARED]; SHARED];
    let mut right = [0.0; SHARED];
    let mut tagged: Vec<(u32, Row, f64)> = edges
        .iter()
        .filter_map(|edge| {
            let grid = edge.grid?;
            let mut row = [0.0; SHARED];
            match grid.phase {
                Phase::Nominal => row[0] = f64::from(grid.index),
                Phase::Data => row[1] = f64::from(grid.index),
            }
            row[2] = f64::from(u8::from(grid.dominant_end));
            Some((grid.block, row, (edge.at - origin) as f64))
        })
        .collect();
    tagged.sort_by_key(|(block, ..)| *block);
    for block in tagged.chunk_by(|a, b| a.0 == b.0) {
        let count = block.len() as f64;
        let mean_row: Row =
            std::array::from_fn(|i| block.iter().map(|(_, row, _)| row[i]).sum::<f64>() / count);
        let mean_at = block.iter().map(|(.., at)| at).sum::<f64>() / count;
        for (_, row, at) in block {
            for i in 0..SHARED {
                for j in 0..SHARED {
                    normal[i][j] += (row[i] - mean_row[i]) * (row[j] - mean_row[j]);
                }
                right[i] += (row[i] - mean_row[i]) * (at - mean_at);
            }
        }
    }
    (normal, right)
}

/// The inverse of the `active` rows and columns (Gauss-Jordan with pivoting); `None` if singular.
fn invert(normal: &[Row; SHARED], active: &[usize]) -> Option<Vec<Vec<f64>>> {
    let size = active.len();
    let mut work: Vec<Vec<f64>> = active
        .iter()
        .enumerate()
        .map(|(place, &i)| {
            let mut row: Vec<f64> = active.iter().map(|&j| normal[i][j]).collect();
            row.extend((0..size).map(|column| f64::from(u8::from(column == place))));
            row
        })
        .collect();
    for column in 0..size {
        let pivot = (column..size)
            .max_by(|&a, &b| work[a][column].abs().total_cmp(&work[b][column].abs()))?;
        if work[pivot][column].abs() < 1e-9 {
            return None;
        }
        work.swap(column, pivot);
        let scale = work[column][column];
        work[column].iter_mut().for_each(|cell| *cell /= scale);
        let reference = work[column].clone();
        for (_, row) in work.iter_mut().enumerate().filter(|(row, _)| *row != column) {
            let factor = row[column];
            row.iter_mut().zip(&reference).for_each(|(cell, r)| *cell -= factor * r);
        }
    }
    Some(work.into_iter().map(|row| row[size..].to_vec()).collect())
}
