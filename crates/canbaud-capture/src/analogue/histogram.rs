//! How often each voltage occurs, in constant memory and without knowing the range beforehand.

/// Bits of an `f32` that make a bin: sign, exponent and 8 bits of the significand, that is steps
/// of 0.4 % of the value.
const BIN_BITS: u32 = 17;

/// Counts per bin of voltage; bins are ordered by voltage.
pub(crate) struct Histogram {
    counts: Vec<u32>,
}

impl Histogram {
    pub(crate) fn new() -> Self {
        Self { counts: vec![0; 1 << BIN_BITS] }
    }

    /// Counts the finite values.
    pub(crate) fn add(&mut self, values: &[f32]) {
        for &value in values {
            if !value.is_finite() {
                continue;
            }
            let bits = value.to_bits();
            // Negative floats order backwards by their bits.
            let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
            if let Some(count) = self.counts.get_mut((ordered >> (32 - BIN_BITS)) as usize) {
                *count = count.saturating_add(1);
            }
        }
    }

    /// The bins that are not empty, as (middle, count) with rising voltage.
    pub(crate) fn bins(&self) -> Vec<(f64, u64)> {
        let filled = self.counts.iter().enumerate().filter(|&(_, &count)| count > 0);
        filled
            .map(|(bin, &count)| {
                // The bin number has BIN_BITS bits by construction.
                let ordered = (bin as u32) << (32 - BIN_BITS) | 1 << (31 - BIN_BITS);
                let bits = if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered };
                (f64::from(f32::from_bits(bits)), u64::from(count))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_ordered_and_close_to_their_values() {
        let mut histogram = Histogram::new();
        let values = [-3.3, -0.01, 0.0, 0.02, 2.5, 3.5, f32::NAN, f32::INFINITY];
        histogram.add(&values);
        let bins = histogram.bins();
        assert_eq!(bins.len(), 6);
        for (bin, value) in bins.iter().zip(values) {
            let value = f64::from(value);
            assert!((bin.0 - value).abs() <= value.abs() / 256.0 + 1e-30, "{bin:?} {value}");
            assert_eq!(bin.1, 1);
        }
    }
}
