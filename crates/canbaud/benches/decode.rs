//! Edges in memory to frames, with the rate given and with the rate found on the way.
//!
//! The figure to watch is elements per second: edges.

use std::hint::black_box;

use canbaud::detect::PulseDetector;
use canbaud::wire::{
    BusTiming, Decoded, Decoder, FdCrc, Frame, FrameKind, Id, ItemKind, Level, Listener, Logic,
    encode,
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// Ticks of one bit: 8 MHz at 1 Mbit/s.
const TICKS: u64 = 8;
/// Frames of the recording.
const FRAMES: u32 = 2000;

struct Count(u32);

impl Listener for Count {
    fn item(&mut self, decoded: &Decoded) {
        self.0 += u32::from(matches!(decoded.item.kind, ItemKind::Frame(_)));
    }
}

/// The edges of a full bus of extended frames with 8 bytes each, seeded.
fn recording() -> Vec<u64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    let mut edges = Vec::new();
    let (mut now, mut level) = (20 * TICKS, Level::Recessive);
    for _ in 0..FRAMES {
        let id = Id::Extended((random() & 0x1FFF_FFFF) as u32);
        let frame = Frame::new(id, FrameKind::Data, 8, &random().to_le_bytes()).expect("8 bytes");
        for bit in encode(&frame, FdCrc::Iso).acknowledged().bits.iter() {
            if bit != level {
                edges.push(now);
                level = bit;
            }
            now += TICKS;
        }
        now += 3 * TICKS;
    }
    edges
}

fn decode(timing: &BusTiming, edges: &[u64]) -> u32 {
    let mut decoder = Decoder::<800>::new(timing).expect("a bit time");
    let mut count = Count(0);
    decoder.begin(0, Level::Recessive);
    decoder.edges(edges, &mut count);
    decoder.finish(edges.last().map_or(0, |last| last + 20 * TICKS), &mut count);
    count.0
}

/// The rate from the first edges, then all frames.
fn find_and_decode(edges: &[u64]) -> u32 {
    let mut detector = PulseDetector::<800>::new();
    detector.begin(0, Logic::High);
    let timing = edges
        .iter()
        .find_map(|&at| {
            detector.push(at);
            detector.bus_timing()
        })
        .expect("a rate");
    decode(&timing, edges)
}

fn benches(criterion: &mut Criterion) {
    let edges = recording();
    let mut group = criterion.benchmark_group("decode");
    group.throughput(Throughput::Elements(edges.len() as u64));
    let timing = BusTiming::classic(TICKS << 20);
    assert_eq!(decode(&timing, &edges), FRAMES);
    assert_eq!(find_and_decode(&edges), FRAMES);
    group.bench_function("rate given", |b| b.iter(|| decode(&timing, black_box(&edges))));
    group.bench_function("rate found", |b| b.iter(|| find_and_decode(black_box(&edges))));
    group.finish();
}

criterion_group!(decoding, benches);
criterion_main!(decoding);
