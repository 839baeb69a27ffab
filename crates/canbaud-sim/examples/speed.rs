//! Simulated time over wall time for the loads that docs/simulator.md quotes.

use std::time::Instant;

use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_sim::{Blind, NodeConfig, Simulation, Span, Time};

/// When nodes ask to send within a period.
#[derive(Clone, Copy)]
enum Requests {
    /// All at once: each frame is won in an arbitration of all that are left.
    Together,
    /// One after the other.
    Spread,
}

/// `nodes` nodes of which each sends a frame of eight bytes every `period`, for `seconds`.
fn run(nodes: usize, bitrate: u32, period: Span, requests: Requests, seconds: u64) -> (f64, u64) {
    let mut sim = Simulation::new(1);
    let ids: Vec<_> = (0..nodes)
        .map(|n| {
            let config = NodeConfig::at("node", bitrate).expect("80 MHz makes this rate");
            sim.add_node(config.with_ppb(n as i64 * 10_000 - 40_000)).expect("a good clock")
        })
        .collect();
    let end = Time::ZERO + Span::from_s(seconds);
    let mut at = Time::ZERO + Span::from_us(500);
    let mut count = 0_u64;
    let start = Instant::now();
    while at < end {
        for (n, id) in ids.iter().enumerate() {
            let data = (count.wrapping_mul(0x9E37_79B9_7F4A_7C15)).to_be_bytes();
            let frame = Frame::new(Id::Base(0x100 + n as u16), FrameKind::Data, 8, &data);
            let wait = match requests {
                Requests::Together => 0,
                Requests::Spread => period.femtoseconds() / nodes as u64 * n as u64,
            };
            sim.send_at(at + Span::from_fs(wait), *id, frame.expect("eight bytes"));
            count += 1;
        }
        at += period;
        sim.run(at, &mut Blind);
    }
    (seconds as f64 / start.elapsed().as_secs_f64(), sim.steps())
}

fn main() {
    // A frame of eight bytes has about 122 bits with its stuff bits and the intermission.
    let seconds = std::env::args().nth(1).map_or(20, |text| text.parse().expect("seconds"));
    let wanted = std::env::args().nth(2).unwrap_or_default();
    let loads = [
        ("500 kbit/s, 8 nodes, 60 % load, requests together", 8, 500_000, 60, Requests::Together),
        ("500 kbit/s, 8 nodes, 60 % load, requests spread", 8, 500_000, 60, Requests::Spread),
        ("1 Mbit/s, 2 nodes, 90 % load, requests together", 2, 1_000_000, 90, Requests::Together),
        ("1 Mbit/s, 2 nodes, 90 % load, requests spread", 2, 1_000_000, 90, Requests::Spread),
    ];
    for (name, nodes, bitrate, percent, requests) in loads {
        if !name.contains(&wanted) {
            continue;
        }
        let bits = nodes as u64 * 122 * 100 / percent;
        let period = Span::from_ns(bits * 1_000_000_000 / u64::from(bitrate));
        let (ratio, steps) = run(nodes, bitrate, period, requests, seconds);
        println!("{name}: {ratio:.0} x ({steps} steps)");
    }
    if !"idle".contains(&wanted) {
        return;
    }
    let (ratio, _) = run(8, 500_000, Span::from_s(100), Requests::Together, 10_000);
    println!("idle bus, 8 nodes: {ratio:.0} x");
}
