//! The prescalers that a controller offers.

use super::Span;

/// The multiples of `step` from `min` to `max`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrescalerSpan {
    /// Lowest prescaler.
    pub min: u16,
    /// Highest prescaler.
    pub max: u16,
    /// All prescalers are multiples of this.
    pub step: u16,
}

impl PrescalerSpan {
    /// The lowest and the highest multiple of the step; `None` if there is none.
    pub(crate) const fn multiples(self) -> Option<(u16, u16)> {
        if self.step == 0 || self.min == 0 {
            return None;
        }
        let (low, high) = (self.min.div_ceil(self.step), self.max / self.step);
        if low > high { None } else { Some((low, high)) }
    }
}

/// The prescalers that a controller offers: a union of up to four arithmetic progressions.
///
/// ```
/// use canbaud::timing::Prescalers;
/// let even = Prescalers::multiples(2, 128, 2);
/// assert!(even.contains(6) && !even.contains(7));
/// let div8 = Prescalers::range(1, 64).and(8, 512, 8);
/// assert!(div8.contains(512) && !div8.contains(65));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prescalers {
    spans: [PrescalerSpan; 4],
    used: u8,
}

impl Prescalers {
    const NONE: PrescalerSpan = PrescalerSpan { min: 1, max: 0, step: 1 };

    /// Every prescaler from `min` to `max`.
    #[must_use]
    pub const fn range(min: u16, max: u16) -> Self {
        Self::multiples(min, max, 1)
    }

    /// The multiples of `step` from `min` to `max`.
    #[must_use]
    pub const fn multiples(min: u16, max: u16, step: u16) -> Self {
        let first = PrescalerSpan { min, max, step };
        Self { spans: [first, Self::NONE, Self::NONE, Self::NONE], used: 1 }
    }

    /// Also the multiples of `step` from `min` to `max`. A fifth progression is left out, and
    /// [`Prescalers::contains`] says so.
    #[must_use]
    pub const fn and(mut self, min: u16, max: u16, step: u16) -> Self {
        let next = PrescalerSpan { min, max, step };
        let [_, second, third, fourth] = &mut self.spans;
        match self.used {
            1 => *second = next,
            2 => *third = next,
            3 => *fourth = next,
            _ => return self,
        }
        self.used += 1;
        self
    }

    /// The progressions; an unused one is empty (`min` above `max`).
    #[must_use]
    pub const fn spans(&self) -> &[PrescalerSpan; 4] {
        &self.spans
    }

    /// Whether `prescaler` is offered.
    #[must_use]
    pub const fn contains(&self, prescaler: u16) -> bool {
        let mut rest: &[PrescalerSpan] = &self.spans;
        while let Some((span, others)) = rest.split_first() {
            let in_range = prescaler >= span.min && prescaler <= span.max;
            if in_range && span.step != 0 && prescaler.is_multiple_of(span.step) {
                return true;
            }
            rest = others;
        }
        false
    }

    /// The lowest and the highest prescaler.
    #[must_use]
    pub const fn ends(&self) -> Span {
        let mut ends = Span::new(u16::MAX, 0);
        let mut rest: &[PrescalerSpan] = &self.spans;
        while let Some((span, others)) = rest.split_first() {
            if let Some((low, high)) = span.multiples() {
                let (min, max) = (low * span.step, high * span.step);
                ends.min = if min < ends.min { min } else { ends.min };
                ends.max = if max > ends.max { max } else { ends.max };
            }
            rest = others;
        }
        ends
    }
}
