//! Simulated time over wall time for the loads that docs/simulator.md quotes:
//! `speed [SECONDS [PART OF A NAME]]`.

use std::time::Instant;

use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_sim::check::Checker;
use canbaud_sim::{Blind, NodeConfig, NodeId, Observer, Simulation, Span, Time};

/// When nodes ask to send within a period.
#[derive(Clone, Copy)]
enum Requests {
    /// All at once: each frame is won in an arbitration of all that are left.
    Together,
    /// One after the other.
    Spread,
}

/// Each node sends a frame of eight bytes in a period.
#[derive(Clone, Copy)]
struct Load {
    nodes: usize,
    bitrate: u32,
    period: Span,
    requests: Requests,
}

impl Load {
    /// A frame of eight bytes has about 122 bits with its stuff bits and the intermission.
    fn of(nodes: usize, bitrate: u32, percent: u64, requests: Requests) -> Self {
        let bits = nodes as u64 * 122 * 100 / percent;
        let period = Span::from_ns(bits * 1_000_000_000 / u64::from(bitrate));
        Self { nodes, bitrate, period, requests }
    }

    /// A bus with nodes of different clocks.
    fn bus(self) -> (Simulation, Vec<NodeId>) {
        let mut sim = Simulation::new(1);
        let node = |n: usize| {
            let config = NodeConfig::at("node", self.bitrate).expect("80 MHz makes this rate");
            config.with_ppb(n as i64 * 10_000 - 40_000)
        };
        let ids = (0..self.nodes).map(|n| sim.add_node(node(n)).expect("a good clock")).collect();
        (sim, ids)
    }

    /// Simulated over wall time of a run of `seconds`.
    fn run<O: Observer>(self, seconds: u64, observer: impl FnOnce(&Simulation) -> O) -> f64 {
        let (mut sim, ids) = self.bus();
        let mut observer = observer(&sim);
        let end = Time::ZERO + Span::from_s(seconds);
        let mut at = Time::ZERO + Span::from_us(500);
        let mut count = 0_u64;
        let start = Instant::now();
        while at < end {
            for (n, id) in ids.iter().enumerate() {
                let data = (count.wrapping_mul(0x9E37_79B9_7F4A_7C15)).to_be_bytes();
                let frame = Frame::new(Id::Base(0x100 + n as u16), FrameKind::Data, 8, &data);
                let wait = match self.requests {
                    Requests::Together => 0,
                    Requests::Spread => self.period.femtoseconds() / self.nodes as u64 * n as u64,
                };
                sim.send_at(at + Span::from_fs(wait), *id, frame.expect("eight bytes"));
                count += 1;
            }
            at += self.period;
            sim.run(at, &mut observer);
        }
        seconds as f64 / start.elapsed().as_secs_f64()
    }
}

fn main() {
    let seconds = std::env::args().nth(1).map_or(20, |text| text.parse().expect("seconds"));
    let wanted = std::env::args().nth(2).unwrap_or_default();
    let (together, spread) = (Requests::Together, Requests::Spread);
    let quiet = Load { period: Span::from_s(100), ..Load::of(8, 500_000, 100, together) };
    let loads = [
        ("500 kbit/s, 8 nodes, 60 % load, requests together", Load::of(8, 500_000, 60, together)),
        ("500 kbit/s, 8 nodes, 60 % load, requests spread", Load::of(8, 500_000, 60, spread)),
        ("1 Mbit/s, 2 nodes, 90 % load, requests together", Load::of(2, 1_000_000, 90, together)),
        ("1 Mbit/s, 2 nodes, 90 % load, requests spread", Load::of(2, 1_000_000, 90, spread)),
    ];
    for (name, load) in loads.into_iter().filter(|(name, _)| name.contains(&wanted)) {
        let plain = load.run(seconds, |_| Blind);
        let checked = load.run(seconds, Checker::new);
        println!("{name}: {plain:.0} x, with all checkers {checked:.0} x");
    }
    if "idle bus, 8 nodes".contains(&wanted) {
        println!("idle bus, 8 nodes: {:.0} x", quiet.run(500 * seconds, |_| Blind));
    }
}
