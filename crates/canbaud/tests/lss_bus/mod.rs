//! A bus of LSS slaves in virtual time, for the procedures of the master.
#![allow(dead_code, unreachable_pub, reason = "each test uses its part")]

use canbaud::lss::{
    Automatic, Configuration, Exchange, ExchangeAction, Fastscan, FastscanAction, FastscanError,
    FastscanOptions, Found, LssAddress, NodeId, Pace, RateSet, RateSetting, Reply, Response,
    Service, ServiceError, Slave, SlaveAction, SlaveOptions, Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::Frame;

/// xorshift64*: the same run for the same seed.
pub struct Chance(u64);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn word(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    pub fn below(&mut self, end: u64) -> u64 {
        (self.word() >> 16) % end
    }

    pub fn between(&mut self, (low, high): (u64, u64)) -> u64 {
        low + self.below(high - low + 1)
    }

    pub fn permille(&mut self, share: u64) -> bool {
        self.below(1000) < share
    }
}

pub struct Memory(pub Option<Configuration>);

impl Storage for Memory {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        self.0 = Some(configuration);
        Ok(())
    }
}

/// How answers come back.
#[derive(Clone, Copy)]
pub struct Way {
    /// From a request to the answer, µs.
    pub round_trip: (u64, u64),
    /// Of 1000 frames, so many are lost, each way.
    pub lost: u64,
    /// Of 1000 answers, so many take ten times as long.
    pub late: u64,
    /// Whether answers of several slaves to one request arrive as one, as on a real bus.
    pub merged: bool,
}

impl Way {
    pub const STEADY: Self = Self { round_trip: (20_000, 20_000), lost: 0, late: 0, merged: false };
}

pub struct Bus {
    pub slaves: Vec<Slave>,
    pub memories: Vec<Memory>,
    pub now: Micros,
    way: Way,
    chance: Chance,
    /// On the way to the master.
    flying: Vec<(Micros, Frame)>,
    /// The last answer of each slave: its next one does not overtake it.
    last: Vec<Micros>,
    /// Sends nothing more from this request on.
    pub dies_after: Option<u32>,
    requests: u32,
    /// How much longer each slave takes, µs.
    pub slower: Vec<u64>,
    /// How much longer everybody takes to answer the first question, µs.
    pub slow_start: u64,
}

pub fn slave(address: LssAddress, node_id: u8) -> Slave {
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic: Automatic::Offered };
    let stored = Configuration {
        node_id: NodeId::new(node_id).unwrap(),
        rate: RateSetting::Fixed(Bitrate::new(250_000).unwrap()),
    };
    Slave::new(options, stored)
}

impl Bus {
    pub fn new(addresses: &[LssAddress], way: Way, seed: u64) -> Self {
        Self {
            slaves: addresses.iter().map(|address| slave(*address, 255)).collect(),
            memories: addresses.iter().map(|_| Memory(None)).collect(),
            now: Micros(0),
            way,
            chance: Chance::new(seed),
            flying: Vec::new(),
            last: vec![Micros(0); addresses.len()],
            dies_after: None,
            requests: 0,
            slower: Vec::new(),
            slow_start: 0,
        }
    }

    pub fn send(&mut self, frame: &Frame) {
        self.requests += 1;
        if self.dies_after.is_some_and(|limit| self.requests > limit) {
            return;
        }
        let slow_start = core::mem::take(&mut self.slow_start);
        let mut first: Option<Micros> = None;
        for index in 0..self.slaves.len() {
            if self.chance.permille(self.way.lost) {
                continue;
            }
            self.slaves[index].handle(self.now, frame, &mut self.memories[index]);
            while let Some(action) = self.slaves[index].poll(self.now) {
                match action {
                    SlaveAction::Send(frame) => {
                        let mut travel = self.chance.between(self.way.round_trip);
                        travel += self.slower.get(index).copied().unwrap_or(0);
                        travel += slow_start;
                        if self.chance.permille(self.way.late) {
                            travel *= 10;
                        }
                        let at = (self.now + Micros(travel)).max(self.last[index]);
                        self.last[index] = at;
                        if self.chance.permille(self.way.lost) {
                            continue;
                        }
                        match first {
                            Some(_) if self.way.merged => {}
                            _ => self.flying.push((at, frame)),
                        }
                        first = first.or(Some(at));
                    }
                    SlaveAction::ResetCommunication(_) => self.slaves[index].reset_communication(),
                    _ => {}
                }
            }
        }
    }

    /// The next answer until `deadline`, or the time has gone on to it.
    pub fn receive(&mut self, deadline: Micros) -> Option<Frame> {
        let next = self.flying.iter().enumerate().min_by_key(|(_, (at, _))| *at);
        match next.map(|(index, (at, _))| (index, *at)) {
            Some((index, at)) if at <= deadline => {
                self.now = self.now.max(at);
                Some(self.flying.remove(index).1)
            }
            _ => {
                assert!(deadline < Micros::MAX, "nothing will ever happen");
                self.now = self.now.max(deadline);
                None
            }
        }
    }

    pub fn fastscan(
        &mut self,
        options: FastscanOptions<'_>,
    ) -> Result<Option<Found>, FastscanError> {
        let mut scan = Fastscan::new(options, self.now);
        loop {
            while let Some(action) = scan.poll(self.now) {
                match action {
                    FastscanAction::Send(frame) => self.send(&frame),
                    FastscanAction::Done(result) => return result,
                }
            }
            if let Some(frame) = self.receive(scan.deadline()) {
                scan.handle(self.now, &frame);
            }
        }
    }

    pub fn exchange(&mut self, service: Service) -> Result<Reply, ServiceError> {
        let mut exchange = Exchange::new(service, Pace::default(), self.now);
        loop {
            while let Some(action) = exchange.poll(self.now) {
                match action {
                    ExchangeAction::Send(frame) => self.send(&frame),
                    ExchangeAction::Done(result) => return result,
                }
            }
            if let Some(frame) = self.receive(exchange.deadline()) {
                exchange.handle(self.now, &frame);
            }
        }
    }

    /// An answer that nobody asked for now, such as a late one.
    pub fn stray(&mut self, after: Micros, response: Response) {
        self.flying.push((self.now + after, response.to_frame()));
    }
}
