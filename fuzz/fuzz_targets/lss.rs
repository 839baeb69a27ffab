//! Any frames, times and calls to the LSS codec, slave and master.
#![no_main]

use canbaud::lss::{
    Automatic, Configuration, Exchange, Fastscan, FastscanOptions, LssAddress, NodeId, Pace,
    RateSet, RateSetting, Request, Response, Service, Slave, SlaveAction, SlaveOptions, Storage,
    StoreError, Strategy,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};
use libfuzzer_sys::fuzz_target;

struct Medium(u8);

impl Storage for Medium {
    fn store(&mut self, _: Configuration) -> Result<(), StoreError> {
        match self.0 % 4 {
            0 => Ok(()),
            1 => Err(StoreError::NotSupported),
            2 => Err(StoreError::Access),
            _ => Err(StoreError::Manufacturer(self.0)),
        }
    }
}

const ADDRESS: LssAddress = LssAddress::new(1, 2, 3, 4);

fn frame(bytes: [u8; 8], how: u8) -> Option<Frame> {
    let id = if how & 1 == 0 { 0x7E5 } else { 0x7E4 };
    let id = if how & 2 == 0 { Id::Base(id) } else { Id::Extended(u32::from(id)) };
    match how >> 4 {
        0 => Frame::new(id, FrameKind::Remote, 8, &[]).ok(),
        1 => Frame::new(id, FrameKind::Data, how >> 5, bytes.get(..usize::from(how >> 5))?).ok(),
        _ => Frame::new(id, FrameKind::Data, 8, &bytes).ok(),
    }
}

fuzz_target!(|input: &[u8]| {
    let Some(([setup, service, scan], steps)) = input.split_first_chunk::<3>() else { return };
    let automatic = if setup & 1 == 0 { Automatic::Offered } else { Automatic::Refused };
    let rates = if setup & 2 == 0 { RateSet::ALL } else { RateSet::NONE };
    let node_id = if setup & 4 == 0 { NodeId::UNCONFIGURED } else { NodeId::new(5).unwrap() };
    let rate = RateSetting::Fixed(Bitrate::new(250_000).unwrap());
    let options = SlaveOptions { address: ADDRESS, rates, automatic };
    let mut slave = Slave::new(options, Configuration { node_id, rate });
    let mut medium = Medium(setup >> 3);
    let service = match service % 3 {
        0 => Service::SwitchStateSelective(ADDRESS),
        1 => Service::StoreConfiguration,
        _ => Service::InquireNodeId,
    };
    let mut exchange = Exchange::new(service, Pace::default(), Micros(0));
    let known = [ADDRESS];
    let strategy = if scan & 1 == 0 { Strategy::Adaptive } else { Strategy::Document };
    let known = if scan & 2 == 0 { &known[..] } else { &[] };
    let options = FastscanOptions { strategy, known, pace: Pace::default() };
    let mut fastscan = Fastscan::new(options, Micros(0));
    let mut now = Micros(0);
    let mut stopped = false;
    for step in steps.chunks_exact(11) {
        let Some((bytes, [how, wait, call])) = step.split_first_chunk::<8>() else { return };
        if let Some(request) = Request::from_bytes(*bytes) {
            assert_eq!(Request::from_bytes(request.to_bytes()), Some(request));
        }
        if let Some(response) = Response::from_bytes(*bytes) {
            assert_eq!(Response::from_bytes(response.to_bytes()), Some(response));
        }
        now = now + Micros(1 << (wait % 40));
        match call % 16 {
            0 => slave.rate_found(),
            1 => slave.reset_communication(),
            _ => {
                if let Some(frame) = frame(*bytes, *how) {
                    slave.handle(now, &frame, &mut medium);
                    exchange.handle(now, &frame);
                    fastscan.handle(now, &frame);
                }
            }
        }
        for turn in 0.. {
            assert!(turn < 10, "the slave never wants nothing");
            match slave.poll(now) {
                Some(SlaveAction::Send(_)) => assert!(!stopped, "sent in silence"),
                Some(SlaveAction::StopSending) => stopped = true,
                Some(SlaveAction::ResumeSending) => stopped = false,
                Some(SlaveAction::SwitchBitRate(_)) => assert!(stopped, "switched while sending"),
                Some(SlaveAction::ResetCommunication(_)) => assert!(!stopped, "boots up in silence"),
                None => break,
            }
        }
        assert!(slave.deadline() > now && slave.may_send() != stopped);
        for _ in 0..10 {
            let _ = (exchange.poll(now), fastscan.poll(now));
        }
    }
});
