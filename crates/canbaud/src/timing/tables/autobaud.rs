//! Autobaud tables: which count of a timer means which bit rate, and the bit timing for it.
//!
//! The method of \[AP2925 1.2.3\] (row A4): one dominant bit is measured with a timer; every
//! bit rate has a window of counts, and no two windows overlap.

use core::fmt;

use crate::timing::{Limits, Rate, RateWords, Ratio, Request, Solution, SolveError, solve};
use crate::units::{Bitrate, Hertz};

/// How far a measured count may be from the exact one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deviation {
    /// By this many ticks: what the polling loop adds and misses.
    Ticks(u32),
    /// By an eighth of the bit, and not past the middle between two neighbours.
    Widest,
}

/// The counts that mean a bit rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TickWindow {
    /// The bit rate.
    pub bitrate: Bitrate,
    /// Timer ticks in a bit, exactly.
    pub expected: Ratio,
    /// Lowest count.
    pub low: u64,
    /// Highest count.
    pub high: u64,
}

impl TickWindow {
    /// Whether a count means this bit rate.
    #[must_use]
    pub const fn contains(&self, ticks: u64) -> bool {
        ticks >= self.low && ticks <= self.high
    }
}

/// Why there is no table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum AutobaudError {
    /// The timer cannot tell two bit rates apart.
    Indistinguishable {
        /// The faster one.
        fast: TickWindow,
        /// The slower one.
        slow: TickWindow,
    },
    /// A bit is so short that a count of 0 would mean it.
    TooShort(TickWindow),
    /// The controller cannot do a bit rate.
    Solve(Bitrate, SolveError),
}

fn words(bitrate: Bitrate) -> RateWords {
    Rate::from(bitrate).words()
}

impl fmt::Display for AutobaudError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Indistinguishable { fast, slow } => write!(
                f,
                "this timer cannot tell {} ({} ticks, {} to {}) from {} ({} ticks, {} to \
                 {}); use a faster timer, a shorter polling loop, or leave one of them out",
                words(fast.bitrate),
                Count(fast.expected),
                fast.low,
                fast.high,
                words(slow.bitrate),
                Count(slow.expected),
                slow.low,
                slow.high
            ),
            Self::TooShort(window) => write!(
                f,
                "a bit at {} lasts {} ticks, fewer than the deviation allows",
                words(window.bitrate),
                Count(window.expected)
            ),
            Self::Solve(bitrate, error) => write!(f, "{}: {error}", words(*bitrate)),
        }
    }
}

impl core::error::Error for AutobaudError {}

/// A count with up to two decimals.
struct Count(Ratio);

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hundredths = self.0.scaled(100);
        match hundredths % 100 {
            0 => write!(f, "{}", hundredths / 100),
            rest => write!(f, "{}.{rest:02}", hundredths / 100),
        }
    }
}

/// The windows of some bit rates, fastest first.
///
/// ```
/// use canbaud::timing::tables::{tick_windows, AutobaudError, Deviation};
/// use canbaud::units::{Bitrate, Hertz};
/// let rates = [800_000, 1_000_000].map(|r| Bitrate::new(r).unwrap());
/// let timer = Hertz::new(10_000_000).unwrap();
/// // Koppe's worry: 10 and 12.5 ticks. One tick of deviation still keeps them apart, two do not.
/// let windows = tick_windows(timer, rates, Deviation::Ticks(1)).unwrap();
/// assert_eq!(windows.map(|w| (w.low, w.high)), [(9, 11), (12, 13)]);
/// let error = tick_windows(timer, rates, Deviation::Ticks(2)).unwrap_err();
/// assert!(error.to_string().contains("1 Mbit/s (10 ticks, 8 to 12) from 800 kbit/s"));
/// ```
///
/// # Errors
/// [`AutobaudError::Indistinguishable`] names the two rates whose windows overlap.
pub fn tick_windows<const N: usize>(
    timer: Hertz,
    mut rates: [Bitrate; N],
    deviation: Deviation,
) -> Result<[TickWindow; N], AutobaudError> {
    rates.sort_unstable_by(|a, b| b.cmp(a));
    let mut windows = rates.map(|bitrate| window(timer, bitrate, deviation));
    if deviation == Deviation::Widest {
        separate(&mut windows);
    }
    for window in &windows {
        if window.low == 0 {
            return Err(AutobaudError::TooShort(*window));
        }
    }
    for pair in windows.windows(2) {
        if let [fast, slow] = pair
            && fast.high >= slow.low
        {
            return Err(AutobaudError::Indistinguishable { fast: *fast, slow: *slow });
        }
    }
    Ok(windows)
}

/// The window of one bit rate by itself; it holds at least the two counts around the exact one.
fn window(timer: Hertz, bitrate: Bitrate, deviation: Deviation) -> TickWindow {
    let rate = u64::from(bitrate.bits_per_second());
    let clock = timer.hertz();
    let expected = Ratio::over(clock, rate);
    let (low, high) = match deviation {
        Deviation::Ticks(ticks) => {
            let ticks = u64::from(ticks);
            (ceil(expected).saturating_sub(ticks), floor(expected) + ticks)
        }
        Deviation::Widest => {
            // At most 10^15 Hz and 2^32 bit/s: no product leaves 64 bits.
            let low = ceil(Ratio::over(clock * 7, rate * 8));
            let high = floor(Ratio::over(clock * 9, rate * 8));
            (low.min(floor(expected)), high.max(ceil(expected)))
        }
    };
    TickWindow { bitrate, expected, low, high }
}

/// Draws neighbouring windows back to the middle between them, a count in the middle belonging
/// to the slower rate; never past the counts around the exact one.
fn separate(windows: &mut [TickWindow]) {
    let mut previous: Option<&mut TickWindow> = None;
    for slow in windows {
        if let Some(fast) = previous {
            let (a, b) = (fast.expected, slow.expected);
            let both = u128::from(a.numerator()) * u128::from(b.denominator())
                + u128::from(b.numerator()) * u128::from(a.denominator());
            let twice = 2 * u128::from(a.denominator()) * u128::from(b.denominator());
            let middle = u64::try_from(both.div_ceil(twice)).unwrap_or(u64::MAX);
            fast.high = fast.high.min(middle.saturating_sub(1)).max(ceil(a));
            slow.low = slow.low.max(middle).min(floor(b));
        }
        previous = Some(slow);
    }
}

fn floor(ratio: Ratio) -> u64 {
    ratio.numerator().checked_div(ratio.denominator()).unwrap_or(u64::MAX)
}

fn ceil(ratio: Ratio) -> u64 {
    let floor = floor(ratio);
    floor + u64::from(floor * ratio.denominator() != ratio.numerator())
}

/// One line of an autobaud table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AutobaudRow {
    /// Which counts mean the bit rate.
    pub window: TickWindow,
    /// The bit timing to program then.
    pub solution: Solution,
}

/// A table from timer counts to bit timings, fastest bit rate first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AutobaudTable<const N: usize> {
    /// All set once built; `None` only while the table is being built.
    rows: [Option<AutobaudRow>; N],
}

impl<const N: usize> AutobaudTable<N> {
    /// Builds the table for a timer, a controller and some bit rates. `settings` gives clock,
    /// SJW and tolerance, and its sample point and policy to every rate.
    ///
    /// ```
    /// use canbaud::timing::tables::{AutobaudTable, Deviation};
    /// use canbaud::timing::{controllers::c167, Request, SamplePointPolicy, SjwPolicy};
    /// use canbaud::units::{Bitrate, Hertz, Permille};
    /// // [AP2925 table 1] for 20 MHz: sample point about 80 %, SJW 1, 7 ticks of deviation.
    /// let cpu = Hertz::new(20_000_000).unwrap();
    /// let rates = [1_000_000, 500_000, 250_000, 125_000].map(|r| Bitrate::new(r).unwrap());
    /// let settings = Request::new(cpu, rates[0])
    ///     .with_sample_point(Permille::new(800).unwrap(), SamplePointPolicy::Nearest)
    ///     .with_sjw(SjwPolicy::Exactly(1));
    /// let table =
    ///     AutobaudTable::build(cpu, rates, Deviation::Ticks(6), &settings, &c167::NOMINAL).unwrap();
    /// assert_eq!(table.find(37).unwrap().window.bitrate.to_string(), "500k");
    /// assert!(table.find(30).is_none());
    /// ```
    ///
    /// # Errors
    /// As [`tick_windows`], or the rate that the controller cannot do.
    pub fn build(
        timer: Hertz,
        rates: [Bitrate; N],
        deviation: Deviation,
        settings: &Request,
        limits: &Limits,
    ) -> Result<Self, AutobaudError> {
        let windows = tick_windows(timer, rates, deviation)?;
        let mut rows = [None; N];
        for (row, window) in rows.iter_mut().zip(windows) {
            let request = Request { bitrate: window.bitrate, ..*settings };
            let solution = solve(&request, limits)
                .map_err(|error| AutobaudError::Solve(window.bitrate, error))?;
            *row = Some(AutobaudRow { window, solution });
        }
        Ok(Self { rows })
    }

    /// The lines, fastest bit rate first.
    pub fn rows(&self) -> impl Iterator<Item = &AutobaudRow> {
        self.rows.iter().flatten()
    }

    /// The line whose window holds this count.
    #[must_use]
    pub fn find(&self, ticks: u64) -> Option<&AutobaudRow> {
        self.rows().find(|row| row.window.contains(ticks))
    }
}
