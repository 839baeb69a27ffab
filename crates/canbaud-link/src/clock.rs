//! The clock of a scan: microseconds since it began.

use std::time::{Duration, Instant, SystemTime};

use canbaud::units::Micros;

/// Frames wait no longer than this between kernel and here; anything older is a clock that was set.
const OLDEST: Duration = Duration::from_secs(60);

/// A clock that starts at 0 and never goes back.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    start: Instant,
}

impl Clock {
    /// A clock that shows 0 now.
    #[must_use]
    pub fn start() -> Self {
        Self { start: Instant::now() }
    }

    /// What it shows.
    #[must_use]
    pub fn now(&self) -> Micros {
        Micros(u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX))
    }

    /// What it showed at `instant` of the wall clock, which was read as `wall_now` when this clock
    /// showed `now`; `None` if the wall clock was set in between.
    #[must_use]
    pub fn at(now: Micros, wall_now: SystemTime, instant: SystemTime) -> Option<Micros> {
        let age = wall_now.duration_since(instant).ok().filter(|age| *age <= OLDEST)?;
        now.0.checked_sub(u64::try_from(age.as_micros()).ok()?).map(Micros)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_of_the_wall_clock_is_that_much_older_than_now() {
        let wall = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000);
        let at = |before| Clock::at(Micros(5_000), wall, wall - Duration::from_micros(before));
        assert_eq!(at(1_500), Some(Micros(3_500)));
        // Before the start.
        assert_eq!(at(5_001), None);
        // A wall clock that was set: the frame is from the future, or of another day.
        assert_eq!(Clock::at(Micros(5_000), wall, wall + Duration::from_secs(1)), None);
        assert_eq!(Clock::at(Micros::MAX, wall, SystemTime::UNIX_EPOCH), None);
    }
}
