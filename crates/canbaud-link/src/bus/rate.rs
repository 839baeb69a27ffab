//! The bit rate of an interface that takes part in the traffic, changed for a time.

use canbaud::units::Bitrate;

use crate::LinkError;
use crate::socketcan::netlink::{Change, Link, LinkChange, TimingInfo};
use crate::socketcan::{LinkLayer, Saved};

/// Sample points within 1 % are the same: segments are whole.
const SAME: u32 = 10;

/// The bit rate of an interface that was up when it was found; put back when it goes out of use.
#[derive(Debug)]
pub(super) struct Rate {
    kernel: Box<dyn LinkLayer>,
    link: Link,
    saved: Saved,
    changed: bool,
}

impl Rate {
    pub(super) fn new(kernel: Box<dyn LinkLayer>, link: Link) -> Self {
        let saved = Saved::of(&link);
        Self { kernel, link, saved, changed: false }
    }

    pub(super) const fn link(&self) -> &Link {
        &self.link
    }

    /// Sets another bit rate, with the sample point and SJW that somebody chose; up in the end.
    pub(super) fn set(&mut self, bitrate: Bitrate) -> Result<(), LinkError> {
        self.kernel.change(&self.link, &LinkChange::only(Change::Down))?;
        self.changed = true;
        let mut done = Ok(());
        for timing in self.timings(bitrate.bits_per_second()) {
            let change = LinkChange { timing: Some(timing), ..LinkChange::default() };
            done = self.kernel.change(&self.link, &change);
            if done.is_ok() {
                break;
            }
        }
        match done {
            Ok(()) => self.kernel.change(&self.link, &LinkChange::only(Change::Up)),
            // It was up, and has to be again.
            Err(error) => self.restore().and(Err(error)),
        }
    }

    /// What to ask the kernel for, the best first: an SJW may be too long for the new segments.
    fn timings(&self, bitrate: u32) -> [TimingInfo; 2] {
        let found = self.saved.timing().unwrap_or_default();
        // What Linux chose for the old bit rate it chooses anew for this one.
        let chosen = found.sample_point.abs_diff(usual(found.bitrate)) > SAME;
        let sample_point = if chosen { found.sample_point } else { 0 };
        let timing = TimingInfo { bitrate, sample_point, ..TimingInfo::default() };
        [TimingInfo { sjw: found.sjw, ..timing }, timing]
    }

    /// What it is set to now stays; whether that is another rate than it was found at.
    pub(super) const fn keep(&mut self) -> bool {
        std::mem::replace(&mut self.changed, false)
    }

    /// Puts it back; whether there was anything to put back.
    pub(super) fn restore(&mut self) -> Result<bool, LinkError> {
        if !self.changed {
            return Ok(false);
        }
        let now = self.kernel.read_back(&self.link.name, self.link.index)?;
        let done = self.saved.restore(&mut *self.kernel, &now);
        // What the kernel refused once it may grant once more.
        self.changed = matches!(done, Err(LinkError::Io { .. }));
        done.map(|()| true)
    }

    pub(super) fn by_hand(&self) -> String {
        self.saved.by_hand(&self.link.name)
    }
}

impl Drop for Rate {
    fn drop(&mut self) {
        // On a way out that already has something else to say.
        let _ = self.restore();
    }
}

/// The sample point that Linux takes by itself, in permille.
const fn usual(bitrate: u32) -> u32 {
    match bitrate {
        800_001.. => 750,
        500_001.. => 800,
        _ => 875,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::socketcan::mock::{CHOSEN, Mock};

    fn rate(kernel: &Mock) -> Rate {
        Rate::new(Box::new(kernel.clone()), kernel.now())
    }

    fn bitrate(bits_per_second: u32) -> Bitrate {
        Bitrate::new(bits_per_second).unwrap()
    }

    fn timing(kernel: &Mock) -> TimingInfo {
        kernel.now().can.unwrap().timing.unwrap()
    }

    #[test]
    fn a_chosen_sample_point_and_sjw_are_kept_and_all_is_put_back() {
        let kernel = Mock::up(CHOSEN);
        let found = kernel.now();
        let mut rate = rate(&kernel);
        rate.set(bitrate(125_000)).unwrap();
        let set = timing(&kernel);
        assert_eq!((set.bitrate, set.sample_point, set.sjw), (125_000, 750, 3));
        assert!(kernel.now().flags.is_up());
        drop(rate);
        assert_eq!(kernel.now(), found);
        assert_eq!(kernel.up_at(), [(125_000, false), (250_000, false)]);
    }

    #[test]
    fn what_linux_chose_it_chooses_anew() {
        let usual = TimingInfo {
            sample_point: 875,
            prop_seg: 6,
            phase_seg1: 7,
            phase_seg2: 2,
            sjw: 1,
            ..CHOSEN
        };
        let kernel = Mock::up(usual);
        let mut rate = rate(&kernel);
        rate.set(bitrate(1_000_000)).unwrap();
        assert_eq!(timing(&kernel).sample_point, 750);
    }

    #[test]
    fn an_sjw_that_does_not_fit_is_left_to_linux() {
        let kernel = Mock::up(CHOSEN);
        let mut rate = rate(&kernel);
        // 8 TQ leave 2 behind a sample point of 75 %.
        rate.set(bitrate(1_000_000)).unwrap();
        assert_eq!((timing(&kernel).sample_point, timing(&kernel).sjw), (750, 1));
    }

    #[test]
    fn what_is_kept_stays() {
        let kernel = Mock::up(CHOSEN);
        let mut rate = rate(&kernel);
        rate.set(bitrate(500_000)).unwrap();
        assert!(rate.keep());
        assert!(!rate.restore().unwrap());
        drop(rate);
        assert_eq!(timing(&kernel).bitrate, 500_000);
    }

    #[test]
    fn a_rate_that_is_refused_leaves_it_as_it_was() {
        let kernel = Mock::up(CHOSEN);
        let found = kernel.now();
        kernel.refuse(500_000);
        let mut rate = rate(&kernel);
        assert!(rate.set(bitrate(500_000)).is_err());
        assert_eq!(kernel.now(), found);
    }

    #[test]
    fn what_cannot_be_put_back_is_an_error() {
        let kernel = Mock::up(CHOSEN);
        let mut rate = rate(&kernel);
        rate.set(bitrate(500_000)).unwrap();
        kernel.refuse(250_000);
        assert!(matches!(rate.restore(), Err(LinkError::NotRestored { .. })));
        assert!(rate.by_hand().contains("bitrate 250000"));
    }
}
