//! What is asked for.

use crate::units::{Bitrate, Hertz, Permille};

/// Where the sample point may lie beside the one asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplePointPolicy {
    /// As near as possible, on either side.
    Nearest,
    /// As near as possible, never later.
    NotLater,
    /// As near as possible, never earlier.
    NotEarlier,
    /// As near as possible, inside a window (both ends included).
    Within {
        /// Earliest allowed sample point.
        earliest: Permille,
        /// Latest allowed sample point.
        latest: Permille,
    },
}

/// How the synchronization jump width is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SjwPolicy {
    /// The largest that SJW field, PHASE_SEG1 and PHASE_SEG2 allow: the best oscillator tolerance.
    Largest,
    /// The smaller of this and the largest possible.
    AtMost(u16),
    /// Exactly this; an error if it does not fit.
    Exactly(u16),
}

/// A wish: clock, bit rate, sample point, SJW, and how far off the bit rate may be.
///
/// ```
/// use canbaud::timing::{Request, SamplePointPolicy};
/// use canbaud::units::{Bitrate, Hertz, Permille};
/// let request = Request::new(Hertz::new(80_000_000).unwrap(), Bitrate::new(1_000_000).unwrap())
///     .with_sample_point(Permille::new(800).unwrap(), SamplePointPolicy::NotLater);
/// assert_eq!(request.tolerance_ppm, Request::DEFAULT_TOLERANCE_PPM);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// The clock that the controller's data sheet starts from.
    pub clock: Hertz,
    /// The bit rate.
    pub bitrate: Bitrate,
    /// The sample point.
    pub sample_point: Permille,
    /// Where the sample point may lie beside it.
    pub policy: SamplePointPolicy,
    /// How SJW is chosen.
    pub sjw: SjwPolicy,
    /// Largest accepted bit rate error in 10⁻⁶.
    pub tolerance_ppm: u32,
}

impl Request {
    /// 0.5 %: a rate error uses up oscillator tolerance, of which no classic setting has more
    /// than 1.58 %.
    pub const DEFAULT_TOLERANCE_PPM: u32 = 5_000;

    /// A request with the [`default_sample_point`], nearest, the largest SJW and a tolerance of
    /// 0.5 %.
    #[must_use]
    pub const fn new(clock: Hertz, bitrate: Bitrate) -> Self {
        Self {
            clock,
            bitrate,
            sample_point: default_sample_point(bitrate),
            policy: SamplePointPolicy::Nearest,
            sjw: SjwPolicy::Largest,
            tolerance_ppm: Self::DEFAULT_TOLERANCE_PPM,
        }
    }

    /// With this sample point and policy.
    #[must_use]
    pub const fn with_sample_point(mut self, point: Permille, policy: SamplePointPolicy) -> Self {
        self.sample_point = point;
        self.policy = policy;
        self
    }

    /// With this way to choose SJW.
    #[must_use]
    pub const fn with_sjw(mut self, sjw: SjwPolicy) -> Self {
        self.sjw = sjw;
        self
    }

    /// With this largest bit rate error in 10⁻⁶.
    #[must_use]
    pub const fn with_tolerance_ppm(mut self, tolerance_ppm: u32) -> Self {
        self.tolerance_ppm = tolerance_ppm;
        self
    }

    /// Earliest and latest sample point in thousandths that the policy allows.
    pub(crate) const fn window(&self) -> (u32, u32) {
        let asked = self.sample_point.permille() as u32;
        match self.policy {
            SamplePointPolicy::Nearest => (0, 1000),
            SamplePointPolicy::NotLater => (0, asked),
            SamplePointPolicy::NotEarlier => (asked, 1000),
            SamplePointPolicy::Within { earliest, latest } => {
                (earliest.permille() as u32, latest.permille() as u32)
            }
        }
    }
}

/// The sample point that CANopen tables and Linux use: 87.5 % up to 500 kbit/s, 80 % up to
/// 800 kbit/s, 75 % above. \[CiA DSP-305 table in the iCC 2003 paper\]
#[must_use]
pub const fn default_sample_point(bitrate: Bitrate) -> Permille {
    let permille = match bitrate.bits_per_second() {
        0..=500_000 => 875,
        500_001..=800_000 => 800,
        _ => 750,
    };
    match Permille::new(permille) {
        Some(point) => point,
        None => Permille::ZERO,
    }
}
