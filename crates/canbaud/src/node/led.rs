//! The two indicator LEDs of a CANopen device \[CiA 303-3\].

use crate::units::Micros;

/// How long a LED is lit and dark while it flickers, about 10 Hz.
const FLICKER: Micros = Micros::from_ms(50);
/// How long it is lit and dark while it blinks (2.5 Hz), and in a group of flashes.
const FLASH: Micros = Micros::from_ms(200);
/// The pause behind a group of flashes.
const PAUSE: Micros = Micros::from_ms(1000);

/// What a LED does.
///
/// ```
/// use canbaud::node::Pattern;
/// use canbaud::units::Micros;
/// let lit = |ms| Pattern::DoubleFlash.is_lit(Micros::from_ms(ms));
/// assert_eq!([0, 199, 200, 400, 600, 1599, 1600].map(lit),
///            [true, true, false, true, false, false, true]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// Dark.
    Off,
    /// Lit.
    On,
    /// 50 ms lit, 50 ms dark.
    Flickering,
    /// 200 ms lit, 200 ms dark.
    Blinking,
    /// 200 ms lit, 1 s dark.
    SingleFlash,
    /// Two flashes 200 ms apart, 1 s dark.
    DoubleFlash,
    /// Three flashes 200 ms apart, 1 s dark.
    TripleFlash,
    /// Four flashes 200 ms apart, 1 s dark.
    QuadrupleFlash,
}

/// How a pattern is made: a step, and how many steps of a period with flashes at the even ones.
struct Shape {
    step: Micros,
    flashes: u64,
    pause: Micros,
}

impl Pattern {
    const fn shape(self) -> Option<Shape> {
        let flashes = match self {
            Self::Off | Self::On => return None,
            Self::Flickering => return Some(Shape { step: FLICKER, flashes: 1, pause: FLICKER }),
            Self::Blinking => return Some(Shape { step: FLASH, flashes: 1, pause: FLASH }),
            Self::SingleFlash => 1,
            Self::DoubleFlash => 2,
            Self::TripleFlash => 3,
            Self::QuadrupleFlash => 4,
        };
        Some(Shape { step: FLASH, flashes, pause: PAUSE })
    }

    /// Whether the LED is lit `since` the pattern began.
    #[must_use]
    pub const fn is_lit(self, since: Micros) -> bool {
        match self.shape() {
            None => matches!(self, Self::On),
            Some(shape) => {
                let step = shape.place(since) / shape.step.0;
                step.is_multiple_of(2) && step < 2 * shape.flashes
            }
        }
    }

    /// How long until the LED has to be looked at again; `None` if it stays as it is.
    ///
    /// ```
    /// use canbaud::node::Pattern;
    /// use canbaud::units::Micros;
    /// assert_eq!(Pattern::Flickering.changes_in(Micros::from_ms(70)), Some(Micros::from_ms(30)));
    /// assert_eq!(Pattern::On.changes_in(Micros(0)), None);
    /// ```
    #[must_use]
    pub const fn changes_in(self, since: Micros) -> Option<Micros> {
        match self.shape() {
            None => None,
            Some(shape) => {
                let place = shape.place(since);
                let group = (2 * shape.flashes - 1) * shape.step.0;
                let left = if place < group {
                    shape.step.0 - place % shape.step.0
                } else {
                    group + shape.pause.0 - place
                };
                Some(Micros(left))
            }
        }
    }
}

impl Shape {
    const fn place(&self, since: Micros) -> u64 {
        since.0 % ((2 * self.flashes - 1) * self.step.0 + self.pause.0)
    }
}

/// The RUN LED (green) and the ERROR LED (red).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Leds {
    /// RUN: flickering while the rate is looked for, blinking pre-operational, on operational,
    /// single flash stopped.
    pub run: Pattern,
    /// ERROR: flickering while the rate is looked for, single flash above the warning limit, on in
    /// bus-off, blinking with a configuration that cannot work.
    pub error: Pattern,
}

impl Leds {
    /// Which are lit `since` the patterns began: RUN, ERROR.
    ///
    /// Both flickering, they do so in turn, as both blinking: a two-colour LED would show neither.
    ///
    /// ```
    /// use canbaud::node::{Leds, Pattern};
    /// use canbaud::units::Micros;
    /// let leds = Leds { run: Pattern::Flickering, error: Pattern::Flickering };
    /// assert_eq!(leds.lit(Micros::from_ms(10)), (false, true));
    /// assert_eq!(leds.lit(Micros::from_ms(60)), (true, false));
    /// ```
    #[must_use]
    pub const fn lit(self, since: Micros) -> (bool, bool) {
        let error = self.error.is_lit(since);
        let run = match (self.run, self.error) {
            (Pattern::Flickering, Pattern::Flickering) | (Pattern::Blinking, Pattern::Blinking) => {
                !error
            }
            (run, _) => run.is_lit(since),
        };
        (run, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Times of the specification in ms: lit, dark, lit ... and the period.
    #[test]
    fn patterns_have_the_times_of_cia_303_3() {
        let table: [(Pattern, &[u64]); 6] = [
            (Pattern::Flickering, &[50, 50]),
            (Pattern::Blinking, &[200, 200]),
            (Pattern::SingleFlash, &[200, 1000]),
            (Pattern::DoubleFlash, &[200, 200, 200, 1000]),
            (Pattern::TripleFlash, &[200, 200, 200, 200, 200, 1000]),
            (Pattern::QuadrupleFlash, &[200, 200, 200, 200, 200, 200, 200, 1000]),
        ];
        for (pattern, times) in table {
            let mut seen = Vec::new();
            let (mut begin, mut level) = (0, true);
            let period: u64 = times.iter().sum();
            for ms in 0..=2 * period {
                let lit = pattern.is_lit(Micros::from_ms(ms));
                if lit != level {
                    assert_eq!(level, seen.len() % 2 == 0);
                    seen.push(ms - begin);
                    (begin, level) = (ms, lit);
                }
                // The next change is where it is said to be.
                let change = pattern.changes_in(Micros::from_ms(ms)).unwrap();
                assert_eq!(pattern.is_lit(Micros::from_ms(ms) + change - Micros(1)), lit);
                assert_ne!(pattern.is_lit(Micros::from_ms(ms) + change), lit, "{pattern:?} {ms}");
            }
            assert_eq!(seen, times.repeat(2), "{pattern:?}");
        }
    }

    #[test]
    fn steady_patterns_stay() {
        for ms in [0, 1, 999, 123_456] {
            assert!(Pattern::On.is_lit(Micros::from_ms(ms)));
            assert!(!Pattern::Off.is_lit(Micros::from_ms(ms)));
        }
    }
}
