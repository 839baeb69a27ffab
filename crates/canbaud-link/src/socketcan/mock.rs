//! A kernel with one interface, for tests: it keeps the rules of the real one and what was asked.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::netlink::{
    CanInfo, Change, Link, LinkChange, LinkFlags, TimingConst, TimingInfo, ctrlmode,
};
use super::rtnl::LinkLayer;
use crate::LinkError;

const EBUSY: i32 = 16;
const EINVAL: i32 = 22;

/// Shared: the test keeps one, the code under test another.
#[derive(Debug, Clone)]
pub(crate) struct Mock(Arc<Mutex<State>>);

#[derive(Debug)]
struct State {
    link: Link,
    /// Refuses this nominal bit rate from now on.
    refused: Option<u32>,
    takes: Takes,
    /// Every bit rate that the interface was up with, and whether it only listened.
    up_at: Vec<(u32, bool)>,
}

/// What a driver takes of a bit timing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Takes {
    Everything,
    /// The bit rate; the others are its own, whatever is asked for.
    RateOnly,
    /// All but the SJW, which is 1.
    AllButSjw,
}

impl Mock {
    /// An interface in normal mode that is up at `timing`.
    pub(crate) fn up(timing: TimingInfo) -> Self {
        let can = CanInfo {
            timing: Some(timing),
            timing_const: Some(TimingConst {
                name: "sja1000".to_owned(),
                tseg1: (1, 16),
                tseg2: (1, 8),
                sjw_max: 4,
                brp: (1, 64),
                brp_inc: 1,
            }),
            clock: Some(8_000_000),
            ctrlmode_supported: Some(ctrlmode::LISTEN_ONLY | ctrlmode::BERR_REPORTING),
            ..CanInfo::default()
        };
        let link = Link {
            index: 5,
            name: "can0".to_owned(),
            flags: LinkFlags(1),
            hardware: 280,
            mtu: 16,
            txqueuelen: 10,
            kind: Some("can".to_owned()),
            can: Some(can),
        };
        Self(Arc::new(Mutex::new(State {
            link,
            refused: None,
            takes: Takes::Everything,
            up_at: Vec::new(),
        })))
    }

    /// The interface as it is now.
    pub(crate) fn now(&self) -> Link {
        self.state().link.clone()
    }

    /// From now on it takes this nominal bit rate no more.
    pub(crate) fn refuse(&self, bitrate: u32) {
        self.state().refused = Some(bitrate);
    }

    /// From now on sample point and SJW are those that it chooses.
    pub(crate) fn take_rates_only(&self) {
        self.state().takes = Takes::RateOnly;
    }

    /// From now on the SJW is 1.
    pub(crate) fn take_no_sjw(&self) {
        self.state().takes = Takes::AllButSjw;
    }

    /// What the interface was up with since: bit rate, and whether it only listened.
    pub(crate) fn up_at(&self) -> Vec<(u32, bool)> {
        self.state().up_at.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LinkLayer for Mock {
    fn link(&mut self, _: &str) -> Result<Link, LinkError> {
        Ok(self.now())
    }

    fn read_back(&mut self, _: &str, _: u32) -> Result<Link, LinkError> {
        Ok(self.now())
    }

    fn change(&mut self, _: &Link, change: &LinkChange) -> Result<(), LinkError> {
        let mut state = self.state();
        state.change(change).map_err(|errno| {
            LinkError::io("cannot configure can0", io::Error::from_raw_os_error(errno))
        })
    }
}

impl State {
    fn change(&mut self, change: &LinkChange) -> Result<(), i32> {
        let up = self.link.flags.is_up();
        let can = self.link.can.as_mut().unwrap();
        if up && (change.timing.is_some() || change.ctrlmode.is_some()) {
            return Err(EBUSY);
        }
        if let Some((mask, values)) = change.ctrlmode {
            can.ctrlmode = can.ctrlmode & !mask | values & mask;
        }
        if let Some(asked) = change.timing {
            let timing = calculate(match self.takes {
                Takes::Everything => asked,
                Takes::AllButSjw => TimingInfo { sjw: 1, ..asked },
                Takes::RateOnly if asked.bitrate == 0 => return Err(EINVAL),
                Takes::RateOnly => TimingInfo { bitrate: asked.bitrate, ..TimingInfo::default() },
            })?;
            if self.refused == Some(timing.bitrate) {
                return Err(EINVAL);
            }
            can.timing = Some(timing);
        }
        match change.set {
            Some(Change::Down) => self.link.flags = LinkFlags(0),
            Some(Change::Up) => {
                let timing = can.set_timing().ok_or(EINVAL)?;
                let listens = can.ctrlmode & ctrlmode::LISTEN_ONLY != 0;
                self.up_at.push((timing.bitrate, listens));
                self.link.flags = LinkFlags(1);
            }
            None => {}
        }
        Ok(())
    }
}

/// 16 TQ of an 8 MHz clock; at 1 Mbit/s 8.
fn calculate(asked: TimingInfo) -> Result<TimingInfo, i32> {
    if asked.bitrate == 0 {
        let bitrate = 1_000_000_000 / (asked.tq * asked.quanta());
        let before = asked.quanta() - asked.phase_seg2;
        let sample_point = 1000 * before / asked.quanta();
        return Ok(TimingInfo { bitrate, sample_point, brp: asked.tq / 125, ..asked });
    }
    let quanta = if asked.bitrate > 500_000 { 8 } else { 16 };
    let usual = if asked.bitrate > 800_000 { 750 } else { 875 };
    let sample_point = if asked.sample_point == 0 { usual } else { asked.sample_point };
    let phase_seg2 = quanta * (1000 - sample_point) / 1000;
    // As Linux since 6.2: no longer than the phase segments.
    if asked.sjw > phase_seg2 {
        return Err(EINVAL);
    }
    let phase_seg1 = (quanta - 1 - phase_seg2) / 2;
    Ok(TimingInfo {
        bitrate: asked.bitrate,
        sample_point,
        tq: 1_000_000_000 / (quanta * asked.bitrate),
        prop_seg: quanta - 1 - phase_seg2 - phase_seg1,
        phase_seg1,
        phase_seg2,
        sjw: asked.sjw.max(1),
        brp: 8_000_000 / (quanta * asked.bitrate),
    })
}

/// 250 kbit/s as somebody chose it: neither sample point nor SJW are what Linux would take.
pub(crate) const CHOSEN: TimingInfo = TimingInfo {
    bitrate: 250_000,
    sample_point: 750,
    tq: 250,
    prop_seg: 6,
    phase_seg1: 5,
    phase_seg2: 4,
    sjw: 3,
    brp: 2,
};
