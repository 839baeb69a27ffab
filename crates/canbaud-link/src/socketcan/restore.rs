//! An interface as it was found, and back to it.

use std::fmt::Write as _;

use super::netlink::{CanInfo, Change, Link, LinkChange, TdcInfo, TimingInfo, ctrlmode};
use super::rtnl::LinkLayer;
use crate::LinkError;

const TDC: u32 = ctrlmode::TDC_AUTO | ctrlmode::TDC_MANUAL;

/// The state of an interface, as far as anything here changes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Saved {
    up: bool,
    ctrlmode: u32,
    /// Control modes that can be switched at all.
    supported: u32,
    timing: Option<TimingInfo>,
    data_timing: Option<TimingInfo>,
    tdc: Option<TdcInfo>,
}

impl Saved {
    pub(crate) fn of(link: &Link) -> Self {
        let none = CanInfo::default();
        let can = link.can.as_ref().unwrap_or(&none);
        let fd = can.ctrlmode & ctrlmode::FD != 0;
        Self {
            up: link.flags.is_up(),
            ctrlmode: can.ctrlmode,
            supported: can.ctrlmode_supported.unwrap_or(ctrlmode::LISTEN_ONLY),
            timing: can.set_timing(),
            data_timing: can.set_data_timing().filter(|_| fd),
            tdc: can.tdc.filter(|_| fd && can.ctrlmode & TDC != 0),
        }
    }

    pub(crate) const fn was_up(&self) -> bool {
        self.up
    }

    pub(crate) const fn bitrate(&self) -> Option<u32> {
        match self.timing {
            Some(timing) => Some(timing.bitrate),
            None => None,
        }
    }

    pub(super) const fn ctrlmode(&self) -> u32 {
        self.ctrlmode
    }

    /// Puts the interface `now` back, and checks that it is.
    pub(crate) fn restore(&self, rtnl: &mut dyn LinkLayer, now: &Link) -> Result<(), LinkError> {
        if now.flags.is_up() {
            rtnl.change(now, &LinkChange::only(Change::Down))?;
        }
        // Mostly it was the kernel that computed the segments, and will again.
        let mut tried = rtnl.change(now, &self.change(now, Form::Bitrate));
        let mut reached = rtnl.read_back(&now.name, now.index)?;
        let fixed = now.can.as_ref().is_some_and(|can| can.timing_const.is_none());
        if !fixed && !self.has_segments(&reached) {
            tried = rtnl.change(&reached, &self.change(&reached, Form::Segments));
            reached = rtnl.read_back(&now.name, now.index)?;
            // The kernel computes the prescaler from a rounded TQ: better the rate than that.
            if self.difference(&reached).is_some() {
                tried = rtnl.change(&reached, &self.change(&reached, Form::Bitrate));
                reached = rtnl.read_back(&now.name, now.index)?;
            }
        }
        let complaint = match (self.difference(&reached), tried) {
            (None, _) => None,
            (Some(difference), Ok(())) => Some(difference),
            (Some(_), Err(error)) => Some(error.to_string()),
        };
        // Up only in the right mode: a wrong rate in normal mode would disturb the bus.
        if let Some(reason) = complaint {
            return Err(LinkError::NotRestored { adapter: now.name.clone(), reason });
        }
        if self.up {
            rtnl.change(&reached, &LinkChange::only(Change::Up))?;
        }
        Ok(())
    }

    /// The nominal bit timing, if there was one.
    pub(crate) const fn timing(&self) -> Option<TimingInfo> {
        self.timing
    }

    /// The commands that put the interface `name` back by hand.
    pub(crate) fn by_hand(&self, name: &str) -> String {
        let mut words = format!("ip link set {name} down; ip link set {name} type can");
        let mut timing = |prefix: &str, timing: Option<TimingInfo>| {
            if let Some(TimingInfo { bitrate, sample_point, sjw, .. }) = timing {
                let (whole, rest) = (sample_point / 1000, sample_point % 1000);
                let _ = write!(
                    words,
                    " {prefix}bitrate {bitrate} {prefix}sample-point {whole}.{rest:03} {prefix}sjw {sjw}"
                );
            }
        };
        timing("", self.timing);
        timing("d", self.data_timing);
        for (bit, word) in [
            (ctrlmode::LISTEN_ONLY, "listen-only"),
            (ctrlmode::LOOPBACK, "loopback"),
            (ctrlmode::BERR_REPORTING, "berr-reporting"),
            (ctrlmode::PRESUME_ACK, "presume-ack"),
            (ctrlmode::FD, "fd"),
        ] {
            // Drivers refuse what they do not have, even to switch it off.
            match (self.ctrlmode & bit != 0, self.supported & bit != 0) {
                (true, _) => words.extend([" ", word, " on"]),
                (false, true) => words.extend([" ", word, " off"]),
                (false, false) => {}
            }
        }
        if self.up {
            let _ = write!(words, "; ip link set {name} up");
        }
        words
    }

    fn change(&self, now: &Link, form: Form) -> LinkChange {
        let current = now.can.as_ref().map_or(0, |can| can.ctrlmode);
        // Bits that stay set are named, too: drivers with fixed ones insist on it.
        let mut mask = (current | self.ctrlmode) & !TDC;
        if self.tdc.is_some() {
            mask |= self.ctrlmode & TDC;
        }
        let timing = |timing: Option<TimingInfo>| timing.map(|timing| form.of(timing));
        LinkChange {
            timing: timing(self.timing),
            data_timing: timing(self.data_timing),
            ctrlmode: Some((mask, self.ctrlmode & mask)),
            tdc: self.tdc.map(|tdc| self.given(tdc)),
            ..LinkChange::default()
        }
    }

    /// The kernel takes a delay only where it is set by hand.
    const fn given(&self, tdc: TdcInfo) -> TdcInfo {
        let manual = self.ctrlmode & ctrlmode::TDC_MANUAL != 0;
        TdcInfo { tdcv: if manual { tdc.tdcv } else { None }, ..tdc }
    }

    /// Whether prescaler and segments are those of the state, where there are any.
    fn has_segments(&self, link: &Link) -> bool {
        let none = CanInfo::default();
        let can = link.can.as_ref().unwrap_or(&none);
        let same = |was: Option<TimingInfo>, is: Option<TimingInfo>| {
            // TQ is left out: which way the kernel rounds it depends on how it was asked.
            was.is_none_or(|was| is.is_some_and(|is| TimingInfo { tq: was.tq, ..is } == was))
        };
        same(self.timing, can.timing) && same(self.data_timing, can.data_timing)
    }

    /// What of the state `link` does not have; a bit rate that was never set cannot be taken away.
    fn difference(&self, link: &Link) -> Option<String> {
        let can = link.can.as_ref()?;
        if can.ctrlmode != self.ctrlmode {
            let (is, was) = (can.ctrlmode, self.ctrlmode);
            return Some(format!("its control mode is {is:#x}, it was {was:#x}"));
        }
        let pairs = [("", self.timing, can.timing), ("data ", self.data_timing, can.data_timing)];
        pairs.into_iter().find_map(|(phase, was, is)| {
            let what = unlike(was?, is.unwrap_or_default())?;
            Some(format!("its {phase}{what}"))
        })
    }
}

/// In what `is` is another bit timing than `was`; what was not read of that is not compared. How many
/// TQ make the same times is no difference.
fn unlike(was: TimingInfo, is: TimingInfo) -> Option<String> {
    // In ticks of the controller's clock; a controller with fixed rates has no prescaler.
    let sjw_ticks = |timing: TimingInfo| timing.sjw.saturating_mul(timing.brp.max(1));
    if is.bitrate != was.bitrate {
        return Some(format!("bit rate is {} bit/s, it was {} bit/s", is.bitrate, was.bitrate));
    }
    if was.sample_point != 0 && is.sample_point != was.sample_point {
        let (is, was) = (percent(is.sample_point), percent(was.sample_point));
        return Some(format!("sample point is {is}, it was {was}"));
    }
    (was.sjw != 0 && sjw_ticks(is) != sjw_ticks(was)).then(|| {
        let of = |timing: TimingInfo| format!("{} TQ of {} ns", timing.sjw, timing.tq);
        format!("SJW is {}, it was {}", of(is), of(was))
    })
}

fn percent(permille: u32) -> String {
    format!("{}.{} %", permille / 10, permille % 10)
}

/// How to say a bit timing to the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// Rate, sample point and SJW; the kernel computes the segments.
    Bitrate,
    /// TQ and segments.
    Segments,
}

impl Form {
    fn of(self, timing: TimingInfo) -> TimingInfo {
        match self {
            Self::Bitrate => TimingInfo {
                bitrate: timing.bitrate,
                sample_point: timing.sample_point,
                sjw: timing.sjw,
                ..TimingInfo::default()
            },
            Self::Segments => TimingInfo { bitrate: 0, sample_point: 0, brp: 0, ..timing },
        }
    }
}

#[cfg(test)]
mod tests;
