//! `canbaud lss serve`: devices for a master to be tried against.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use canbaud::lss::{
    Automatic, Configuration, LssAddress, NodeId, RateSet, RateSetting, Slave, SlaveAction,
    SlaveOptions, Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_link::LinkError;
use canbaud_link::bus::FrameBus;

use super::args::ServeArgs;
use super::session::Session;
use super::trouble::Trouble;
use crate::outlet::Outlet;

/// Longest wait for a frame.
const SLICE: Duration = Duration::from_millis(50);

struct Memory {
    works: bool,
    name: String,
}

impl Storage for Memory {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        if !self.works {
            return Err(StoreError::NotSupported);
        }
        let Configuration { node_id, rate } = configuration;
        told(&format!("{} stores node-ID {node_id}, bit rate {rate}", self.name));
        Ok(())
    }
}

struct Device {
    slave: Slave,
    memory: Memory,
    /// Commands on their way through the device.
    inbox: VecDeque<(Micros, Frame)>,
    /// It takes the next frame that it hears for the proof of the bit rate.
    detecting: bool,
}

/// Serves until the time is over.
pub(super) fn serve(args: &ServeArgs, session: &mut Session) -> Result<(), Trouble> {
    play(args, session).map_err(|error| session.trouble(error))
}

fn play(args: &ServeArgs, session: &mut Session) -> Result<(), LinkError> {
    // A channel that cannot listen silently must not be used for detection.
    let automatic = match session.bus() {
        Some(bus) if bus.is_virtual() => Automatic::Offered,
        Some(_) | None => Automatic::Refused,
    };
    let mut devices: Vec<Device> = (0..args.count).map(|n| device(args, automatic, n)).collect();
    for device in &devices {
        told(&format!("{} waits", device.memory.name));
    }
    let Some(bus) = session.bus() else { return Ok(()) };
    let latency = args.latency;
    let began = Instant::now();
    let end = args.duration.map_or(Micros::MAX, micros);
    loop {
        let now = micros(began.elapsed());
        if now >= end {
            return Ok(());
        }
        for device in &mut devices {
            device.run(now, bus)?;
        }
        let due = devices.iter().map(Device::deadline).min().unwrap_or(Micros::MAX).min(end);
        let wait = Duration::from_micros((due - now).0).min(SLICE);
        if let Some(frame) = bus.receive(wait)? {
            let now = micros(began.elapsed());
            for device in &mut devices {
                device.inbox.push_back((now + latency, frame));
            }
        }
    }
}

fn micros(time: Duration) -> Micros {
    Micros(u64::try_from(time.as_micros()).unwrap_or(u64::MAX))
}

fn device(args: &ServeArgs, automatic: Automatic, place: u8) -> Device {
    let first = args.address;
    let serial_number = first.serial_number.wrapping_add(place.into());
    let address = LssAddress { serial_number, ..first };
    let node_id = match args.node_id {
        Some(id) if id.is_configured() => id.get().checked_add(place).and_then(NodeId::new),
        _ => None,
    };
    let rate = args.line.own_bitrate.or(Bitrate::new(125_000));
    let stored = Configuration {
        node_id: node_id.unwrap_or(NodeId::UNCONFIGURED),
        rate: rate.map_or(RateSetting::Automatic, RateSetting::Fixed),
    };
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic };
    let memory = Memory { works: !args.no_storage, name: address.to_string() };
    let slave = Slave::new(options, stored);
    Device { slave, memory, inbox: VecDeque::new(), detecting: false }
}

impl Device {
    fn deadline(&self) -> Micros {
        let inbox = self.inbox.front().map_or(Micros::MAX, |(at, _)| *at);
        self.slave.deadline().min(inbox)
    }

    fn run(&mut self, now: Micros, bus: &mut dyn FrameBus) -> Result<(), LinkError> {
        self.carry_out(now, bus)?;
        while let Some((at, frame)) = self.inbox.pop_front() {
            if at > now {
                self.inbox.push_front((at, frame));
                break;
            }
            if self.detecting {
                self.detecting = false;
                told(&format!("{} has found the bit rate", self.memory.name));
                self.slave.rate_found();
            } else {
                self.slave.handle(now, &frame, &mut self.memory);
            }
            self.carry_out(now, bus)?;
        }
        Ok(())
    }

    fn carry_out(&mut self, now: Micros, bus: &mut dyn FrameBus) -> Result<(), LinkError> {
        let name = self.memory.name.clone();
        while let Some(action) = self.slave.poll(now) {
            match action {
                SlaveAction::Send(frame) => bus.send(&frame)?,
                SlaveAction::StopSending => told(&format!("{name} falls silent")),
                SlaveAction::SwitchBitRate(RateSetting::Fixed(rate)) => {
                    bus.set_bitrate(rate)?;
                    told(&format!("{name} switches to {rate}"));
                }
                SlaveAction::SwitchBitRate(RateSetting::Automatic) => {
                    self.detecting = true;
                    told(&format!("{name} listens for the bit rate"));
                }
                SlaveAction::ResumeSending => told(&format!("{name} may send again")),
                SlaveAction::ResetCommunication(node_id) => {
                    self.slave.reset_communication();
                    told(&format!("{name} boots up with node-ID {node_id}"));
                    let id = Id::Base(0x700 + u16::from(node_id.get()));
                    if let Ok(frame) = Frame::new(id, FrameKind::Data, 1, &[0]) {
                        bus.send(&frame)?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// A line for whoever watches; a closed pipe is nobody's problem.
fn told(what: &str) {
    let _ = Outlet::Output.write(&format!("{what}\n"), None);
}
