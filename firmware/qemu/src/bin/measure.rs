//! Instructions and stack of the pulse detector and of the method of AP2925, on the same edges.
//!
//! Prints `key value` lines; `scripts/firmware` compares them with those in `docs/firmware.md`.
#![no_std]
#![no_main]

use canbaud::detect::{MinimumPulse, PulseDetector, Verdict};
use canbaud::wire::Logic;
use canbaud_firmware::board::Counter;
use canbaud_firmware::console::{self, Status, print, print_number, print_pair};
use canbaud_firmware::recordings::{RECORDINGS, Recording, sample};
use canbaud_firmware::stack;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let counter = Counter::new();
    let mut status = Status::Ok;
    let mut deepest = 0;
    for recording in RECORDINGS {
        let (verdict, depth) = stack::measure(|| replay(recording));
        deepest = deepest.max(depth);
        if !recording.expects(&verdict) {
            print("wrong verdict: ");
            print(recording.name);
            print("\n");
            status = Status::Failed;
        }
    }
    print_pair("detector_ram_bytes", size_of::<PulseDetector>() as u64);
    print_pair("detector_stack_bytes", deepest as u64);
    print_pair("minimum_ram_bytes", size_of::<MinimumPulse>() as u64);
    for (name, bitrate, timer_hz) in CASES {
        measure(&counter, name, bitrate, timer_hz, &mut status);
    }
    console::exit(status)
}

/// A name for the figures, the bit rate, the clock of the timer.
const CASES: [(&str, u64, u64); 6] = [
    ("500k_8mhz", 500_000, 8_000_000),
    ("500k_72mhz", 500_000, 72_000_000),
    ("125k_1mhz", 125_000, 1_000_000),
    ("1m_4mhz", 1_000_000, 4_000_000),
    ("1m_2mhz", 1_000_000, 2_000_000),
    ("1m_1.5mhz", 1_000_000, 1_500_000),
];

fn replay(recording: &Recording) -> Verdict {
    let mut detector = PulseDetector::<160>::new();
    detector.begin(0, recording.initial);
    for &edge in recording.edges {
        detector.push(u64::from(edge));
    }
    detector.finish(recording.end);
    detector.verdict()
}

/// One frame of eight random bytes.
fn measure(counter: &Counter, name: &str, bitrate: u64, timer_hz: u64, status: &mut Status) {
    let mut edges = [0_u32; 160];
    let (count, end) =
        sample("stuff-bit-after-crc-data-base-3", bitrate, timer_hz, &mut edges);
    let edges = edges.get(..count).unwrap_or(&[]);
    let mut detector = PulseDetector::<160>::new();
    detector.begin(0, Logic::High);
    let (mut total, mut most) = (0, 0);
    for &edge in edges {
        let ((), instructions) = counter.count(|| detector.push(u64::from(edge)));
        total += instructions;
        most = most.max(instructions);
    }
    let (verdict, last) = counter.count(|| {
        detector.finish(end);
        detector.verdict()
    });
    if !matches!(verdict, Verdict::Found(_)) {
        print("not found: ");
        print(name);
        print("\n");
        *status = Status::Failed;
    }
    let figure = |what: &str, value: u64| {
        print(what);
        print("_");
        print(name);
        print(" ");
        print_number(value);
        print("\n");
    };
    let edges_count = count.max(1) as u64;
    figure("detector_edge_mean", (total + last).div_ceil(edges_count));
    figure("detector_edge_push_mean", total.div_ceil(edges_count));
    figure("detector_edge_push_max", most);
    figure("detector_verdict", last);
    let mut minimum = MinimumPulse::new();
    let mut total = 0;
    for pair in edges.chunks_exact(2) {
        if let &[falling, rising] = pair {
            let ((), instructions) = counter.count(|| minimum.push(rising - falling));
            total += instructions;
        }
    }
    let (_, last) = counter.count(|| minimum.shortest());
    figure("minimum_edge_mean", (total + last).div_ceil(edges_count));
}
