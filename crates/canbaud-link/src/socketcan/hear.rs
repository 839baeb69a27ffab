//! What came from a socket as observations.

use core::ops::Range;
use std::time::SystemTime;

use canbaud::detect::scan::{FrameSeen, Observation, Origin};
use canbaud::units::Micros;
use canbaud::wire::{Frame, Id};

use super::error_frame;
use super::frame::Raw;
use super::raw::Reception;
use super::setup::PEAK_USB;
use crate::Clock;

/// What the driver of PEAK USB adapters leaves of an error frame, whose mark it loses: `CAN_ERR_CNT` as an identifier.
const PEAK_COUNTERS: Id = Id::Base(0x200);

/// What `heard` says to a scan whose clock shows `now`; `None` if nothing.
pub(super) fn observation(
    driver: Option<&str>,
    heard: Reception,
    now: Micros,
) -> Option<Observation> {
    let received = heard.stamp.and_then(|at| Clock::at(now, SystemTime::now(), at));
    match heard.raw {
        Raw::Error { class, data } => error_frame::observe(class, data, received),
        Raw::Frame(frame) if driver == Some(PEAK_USB) && is_counters(&frame) => {
            let count = frame.data().get(7).copied().unwrap_or(0);
            Some(Observation::ReceiveErrors(count.into()))
        }
        Raw::Frame(frame) => {
            let origin = if heard.local { Origin::Local } else { Origin::Bus };
            Some(Observation::Frame(FrameSeen { frame, origin, received }))
        }
    }
}

/// A state change that the PEAK driver passes on as if it were a data frame: state bits in byte 1,
/// counters in bytes 6 and 7.
fn is_counters(frame: &Frame) -> bool {
    let zero = |range: Range<usize>| {
        frame.data().get(range).is_some_and(|bytes| bytes.iter().all(|byte| *byte == 0))
    };
    frame.id() == PEAK_COUNTERS && frame.data().len() == 8 && zero(0..1) && zero(2..6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud::wire::FrameKind;

    fn hear(driver: &str, id: u16, data: &[u8], local: bool) -> Option<Observation> {
        let dlc = data.len() as u8;
        let frame = Frame::new(Id::Base(id), FrameKind::Data, dlc, data).unwrap();
        let heard = Reception { raw: Raw::Frame(frame), local, stamp: None };
        observation(Some(driver), heard, Micros(1_000))
    }

    /// Trap: pcan_usb_decode_error() of Linux 6.12 assigns CAN_ERR_CNT to the identifier.
    #[test]
    fn state_changes_of_peak_adapters_are_no_frames() {
        let passive = [0, 0x10, 0, 0, 0, 0, 3, 130];
        assert_eq!(hear("peak_usb", 0x200, &passive, false), Some(Observation::ReceiveErrors(130)));
        for (driver, id, data) in [
            ("gs_usb", 0x200, &passive[..]),
            ("peak_usb", 0x201, &passive[..]),
            ("peak_usb", 0x200, &[0, 0x10, 0, 0, 9, 0, 3, 130]),
            ("peak_usb", 0x200, &[0, 0x10]),
        ] {
            let heard = hear(driver, id, data, false);
            assert!(matches!(heard, Some(Observation::Frame(_))), "{driver} {id:03X} {data:?}");
        }
    }

    /// Trap: without IFF_ECHO the network stack hands local frames back, sent or not.
    #[test]
    fn frames_of_this_host_are_marked() {
        for (local, want) in [(true, Origin::Local), (false, Origin::Bus)] {
            let Some(Observation::Frame(seen)) = hear("slcan", 0x123, &[1], local) else {
                panic!()
            };
            assert_eq!(seen.origin, want);
        }
    }
}
