//! The channel that sends, over a pty: an adapter in normal mode.

use std::time::Duration;

use canbaud::units::Bitrate;
use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_link::bus::{FrameBus, SlcanBus};

use crate::bench::{Bench, Setup};

#[test]
fn frames_are_sent_and_received_at_the_rate_that_was_set() {
    let bench = Bench::start(Setup::at(250_000));
    let rate = |rate| Bitrate::new(rate).unwrap();
    let mut bus = SlcanBus::open(&bench.port, 115_200, rate(500_000)).unwrap();
    bus.set_bitrate(rate(250_000)).unwrap();
    let frame = Frame::new(Id::Base(0x7E5), FrameKind::Data, 2, &[4, 1]).unwrap();
    bus.send(&frame).unwrap();
    let heard = bus.receive(Duration::from_secs(10)).unwrap().unwrap();
    assert_eq!(heard.id(), Id::Base(0x155));
    drop(bus);
    let log = bench.log();
    for want in ["S6: set", "S5: set", "O: open normal", "t7E520401: sent"] {
        assert!(log.iter().any(|line| line == want), "{want}: {log:#?}");
    }
    assert_eq!(log.iter().rev().find(|line| line.starts_with('C')).unwrap(), "C: closed");
}
