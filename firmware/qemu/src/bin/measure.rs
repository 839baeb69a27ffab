//! Instructions and stack of the pulse detector and of the method of AP2925, on the same edges.
//!
//! Prints `key value` lines; `scripts/firmware` compares them with those in `docs/firmware.md`.
#![no_std]
#![no_main]

use canbaud::detect::{MinimumPulse, PulseDetector, Verdict};
use canbaud::wire::Logic;
use canbaud_firmware::board::Counter;
use canbaud_firmware::console::{self, Status, print, print_number, print_pair};
use canbaud_firmware::recordings::{FRAMES, RECORDINGS, Recording, sample};
use canbaud_firmware::stack;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let counter = Counter::new();
    let mut status = Status::Ok;
    let mut deepest = 0;
    // One frame with more runs than a detector for classic frames holds.
    for recording in RECORDINGS.iter().filter(|recording| recording.name != "fd-1m-8m-72mhz") {
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
    for (key, timer_hz) in
        [("found_permille_1m_at_2mhz", 2_000_000), ("found_permille_1m_at_1.5mhz", 1_500_000)]
    {
        print_pair(key, found_permille(timer_hz));
    }
    console::exit(status)
}

/// A name for the figures, the bit rate, the clock of the timer.
const CASES: [(&str, u64, u64); 6] = [
    ("1m_16mhz", 1_000_000, 16_000_000),
    ("500k_72mhz", 500_000, 72_000_000),
    ("125k_1mhz", 125_000, 1_000_000),
    ("1m_4mhz", 1_000_000, 4_000_000),
    ("1m_2mhz", 1_000_000, 2_000_000),
    ("1m_1.5mhz", 1_000_000, 1_500_000),
];

/// Of the 24 classic frames among the corner cases, the share whose rate of 1 Mbit/s is found right, to 1.6 %,
/// from that frame alone.
#[inline(never)]
fn found_permille(timer_hz: u64) -> u64 {
    let (mut frames, mut found) = (0, 0);
    for (name, _) in FRAMES.iter().filter(|(name, _)| name.starts_with("stuff-bit-after-crc")) {
        let mut edges = [0_u32; 160];
        let (count, end) = sample(name, 1_000_000, timer_hz, &mut edges);
        let mut detector = PulseDetector::<160>::new();
        detector.begin(0, Logic::High);
        edges.iter().take(count).for_each(|&edge| detector.push(u64::from(edge)));
        detector.finish(end);
        frames += 1;
        if let Verdict::Found(bit) = detector.verdict() {
            let right = (timer_hz << 20) / 1_000_000;
            found += u64::from(bit.nominal.ticks_q20.abs_diff(right) * 1000 <= right * 16);
        }
    }
    found * 1000 / u64::max(frames, 1)
}

#[inline(never)]
fn replay(recording: &Recording) -> Verdict {
    let mut detector = PulseDetector::<160>::new();
    detector.begin(0, recording.initial);
    for &edge in recording.edges {
        detector.push(u64::from(edge));
    }
    detector.finish(recording.end);
    detector.verdict()
}

/// One frame of seven random bytes.
#[inline(never)]
fn measure(counter: &Counter, name: &str, bitrate: u64, timer_hz: u64, status: &mut Status) {
    let mut edges = [0_u32; 160];
    let (count, end) = sample("stuff-bit-after-crc-data-base-3", bitrate, timer_hz, &mut edges);
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
    // The same frame again, at the rate that is known now.
    let ((), again) = counter.count(|| {
        detector.begin(end, Logic::High);
        edges.iter().for_each(|&edge| detector.push(end + u64::from(edge)));
        detector.finish(2 * end);
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
    figure("edges", edges_count);
    figure("detector_edge_mean", (total + last).div_ceil(edges_count));
    figure("detector_edge_push_mean", total.div_ceil(edges_count));
    figure("detector_edge_push_max", most);
    figure("detector_verdict", last);
    figure("detector_known_rate_edge_mean", again.div_ceil(edges_count));
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
