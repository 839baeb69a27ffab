//! What a controller can hold: ranges, prescaler sets, rules between segments.

use core::fmt;

use super::{BitTiming, Prescalers};

/// An inclusive range of a field, in real values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// Lowest value.
    pub min: u16,
    /// Highest value.
    pub max: u16,
}

impl Span {
    /// `min..=max`.
    #[must_use]
    pub const fn new(min: u16, max: u16) -> Self {
        Self { min, max }
    }

    /// Whether `value` lies inside.
    #[must_use]
    pub const fn contains(self, value: u32) -> bool {
        value >= self.min as u32 && value <= self.max as u32
    }
}

/// Rules between segments beyond their own ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rules {
    /// TSEG1 must exceed TSEG2 by at least this; `None`: no such rule.
    pub tseg1_excess_min: Option<i16>,
    /// SJW must be below PHASE_SEG2 by at least this (1 for the MCP2515, else 0).
    pub sjw_gap: u16,
}

/// What one phase of a controller can hold, in real values.
///
/// Built from a `const` of `controllers` or by hand for any other chip:
///
/// ```
/// use canbaud::timing::{Limits, Prescalers, Span};
/// const MINE: Limits = Limits::new(Span::new(1, 16), Span::new(1, 8), 4, Prescalers::range(1, 64))
///     .with_clock_divider(2);
/// assert_eq!((MINE.quanta().min, MINE.quanta().max), (3, 25));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// TSEG1 = PROP_SEG + PHASE_SEG1.
    pub tseg1: Span,
    /// TSEG2 = PHASE_SEG2.
    pub tseg2: Span,
    /// PROP_SEG, where the controller has a field of its own for it.
    pub prop_seg: Span,
    /// PHASE_SEG1, where the controller has a field of its own for it.
    pub phase_seg1: Span,
    /// Highest SJW.
    pub sjw_max: u16,
    /// Time quanta in a bit.
    pub bit_quanta: Span,
    /// The prescalers on offer.
    pub prescalers: Prescalers,
    /// Fixed division between the clock and the prescaler, at least 1.
    pub clock_divider: u16,
    /// Rules between segments.
    pub rules: Rules,
}

impl Limits {
    /// Limits of a controller with one TSEG1 field and no further rules.
    #[must_use]
    pub const fn new(tseg1: Span, tseg2: Span, sjw_max: u16, prescalers: Prescalers) -> Self {
        Self {
            tseg1,
            tseg2,
            prop_seg: Span::new(0, u16::MAX),
            phase_seg1: Span::new(1, u16::MAX),
            sjw_max,
            bit_quanta: Span::new(3, u16::MAX),
            prescalers,
            clock_divider: 1,
            rules: Rules { tseg1_excess_min: None, sjw_gap: 0 },
        }
    }

    /// With fields of their own for PROP_SEG and PHASE_SEG1.
    #[must_use]
    pub const fn with_segments(mut self, prop_seg: Span, phase_seg1: Span) -> Self {
        self.prop_seg = prop_seg;
        self.phase_seg1 = phase_seg1;
        self
    }

    /// With a range for the time quanta in a bit.
    #[must_use]
    pub const fn with_bit_quanta(mut self, bit_quanta: Span) -> Self {
        self.bit_quanta = bit_quanta;
        self
    }

    /// With a fixed division between the clock and the prescaler; 0 counts as 1.
    #[must_use]
    pub const fn with_clock_divider(mut self, clock_divider: u16) -> Self {
        self.clock_divider = if clock_divider == 0 { 1 } else { clock_divider };
        self
    }

    /// With the rule that TSEG1 exceeds TSEG2 by at least `excess`.
    #[must_use]
    pub const fn with_tseg1_excess(mut self, excess: i16) -> Self {
        self.rules.tseg1_excess_min = Some(excess);
        self
    }

    /// With the rule that SJW is below PHASE_SEG2 by at least `gap`.
    #[must_use]
    pub const fn with_sjw_gap(mut self, gap: u16) -> Self {
        self.rules.sjw_gap = gap;
        self
    }

    /// With these prescalers instead.
    #[must_use]
    pub const fn with_prescalers(mut self, prescalers: Prescalers) -> Self {
        self.prescalers = prescalers;
        self
    }

    /// TSEG1 and TSEG2 narrowed by the segment fields and by the rule between them.
    pub(crate) const fn segments(&self) -> (Bounds, Bounds) {
        let fields_min = self.prop_seg.min as i32 + self.phase_seg1.min as i32;
        let fields_max = self.prop_seg.max as i32 + self.phase_seg1.max as i32;
        let mut t1 = Bounds {
            min: max(max(self.tseg1.min as i32, fields_min), 1),
            max: min(self.tseg1.max as i32, fields_max),
        };
        let mut t2 = Bounds { min: max(self.tseg2.min as i32, 1), max: self.tseg2.max as i32 };
        if let Some(excess) = self.rules.tseg1_excess_min {
            t1.min = max(t1.min, t2.min + excess as i32);
            t2.max = min(t2.max, t1.max - excess as i32);
        }
        (t1, t2)
    }

    /// The time quanta in a bit that segments and rules leave; empty if they contradict.
    #[must_use]
    pub const fn quanta(&self) -> Span {
        let (t1, t2) = self.segments();
        let low = max(1 + t1.min + t2.min, self.bit_quanta.min as i32);
        let high = min(1 + t1.max + t2.max, self.bit_quanta.max as i32);
        if t1.min > t1.max || t2.min > t2.max || low > high {
            return Span::new(1, 0);
        }
        Span::new(low as u16, high as u16)
    }

    /// Splits TSEG1: PHASE_SEG1 equal to PHASE_SEG2 where the fields allow it, PROP_SEG the rest.
    pub(crate) const fn split(&self, tseg1: u32, tseg2: u32) -> (u16, u16) {
        let tseg1 = tseg1 as i32;
        // A bit has a PROP_SEG of at least 1 (ISO 11898-1) unless TSEG1 is 1 altogether.
        let prop_min = max(self.prop_seg.min as i32, if tseg1 > 1 { 1 } else { 0 });
        let low = max(self.phase_seg1.min as i32, tseg1 - self.prop_seg.max as i32);
        let high = min(self.phase_seg1.max as i32, tseg1 - prop_min);
        let phase = max(low, min(high, tseg2 as i32));
        (max(tseg1 - phase, 0) as u16, phase as u16)
    }

    /// The largest SJW for these segments.
    #[must_use]
    pub const fn sjw_limit(&self, phase_seg1: u16, phase_seg2: u16) -> u16 {
        let phases = min(phase_seg1 as i32, phase_seg2 as i32 - self.rules.sjw_gap as i32);
        max(min(self.sjw_max as i32, phases), 1) as u16
    }

    /// Whether a setting keeps every limit; the first one broken if not.
    pub const fn check(&self, timing: &BitTiming) -> Result<(), Violation> {
        if !self.prescalers.contains(timing.prescaler) {
            let ends = self.prescalers.ends();
            return Err(Violation::new("prescaler", timing.prescaler as u32, ends));
        }
        let checks = [
            ("TSEG1", timing.tseg1(), self.tseg1),
            ("TSEG2", timing.tseg2(), self.tseg2),
            ("PROP_SEG", timing.prop_seg as u32, self.prop_seg),
            ("PHASE_SEG1", timing.phase_seg1 as u32, self.phase_seg1),
            ("time quanta per bit", timing.quanta(), self.bit_quanta),
            ("SJW", timing.sjw as u32, Span::new(1, self.sjw_max)),
        ];
        let mut rest: &[(&'static str, u32, Span)] = &checks;
        while let Some((check, others)) = rest.split_first() {
            if !check.2.contains(check.1) {
                return Err(Violation::new(check.0, check.1, check.2));
            }
            rest = others;
        }
        self.check_rules(timing)
    }

    const fn check_rules(&self, timing: &BitTiming) -> Result<(), Violation> {
        if let Some(excess) = self.rules.tseg1_excess_min {
            let highest = max(timing.tseg1() as i32 - excess as i32, 0);
            if timing.tseg2() as i32 > highest {
                let allowed = Span::new(self.tseg2.min, highest as u16);
                return Err(Violation::new("TSEG2", timing.tseg2(), allowed));
            }
        }
        let highest = max(timing.phase_seg2 as i32 - self.rules.sjw_gap as i32, 1) as u16;
        if timing.sjw > highest {
            return Err(Violation::new("SJW", timing.sjw as u32, Span::new(1, highest)));
        }
        Ok(())
    }
}

/// A setting outside what the controller can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Violation {
    /// What is out of range.
    pub what: &'static str,
    /// The value.
    pub value: u32,
    /// What is allowed.
    pub allowed: Span,
}

impl Violation {
    const fn new(what: &'static str, value: u32, allowed: Span) -> Self {
        Self { what, value, allowed }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Span { min, max } = self.allowed;
        let Self { what, value, .. } = self;
        if min > max {
            write!(f, "{what} {value} fits no setting of the controller")
        } else if self.allowed.contains(*value) {
            write!(f, "{what} {value} is not among those that the controller offers")
        } else {
            write!(f, "{what} {value} outside {min} to {max}")
        }
    }
}

impl core::error::Error for Violation {}

/// Bounds in a signed type, in which the rules are computed.
#[derive(Clone, Copy)]
pub(crate) struct Bounds {
    pub(crate) min: i32,
    pub(crate) max: i32,
}

pub(crate) const fn min(a: i32, b: i32) -> i32 {
    if a < b { a } else { b }
}

pub(crate) const fn max(a: i32, b: i32) -> i32 {
    if a > b { a } else { b }
}
