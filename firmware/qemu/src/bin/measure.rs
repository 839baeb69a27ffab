//! Instructions and stack of the detectors and of the method of AP2925, on the same edges.
//!
//! Prints `key value` lines; `scripts/firmware` compares them with those in `docs/firmware.md`.
#![no_std]
#![no_main]

use canbaud::detect::{CompactDetector, MinimumPulse, PulseDetector, Verdict};
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
    let (mut deepest, mut deepest_compact) = (0, 0);
    // One frame with more runs than a detector for classic frames holds.
    for recording in RECORDINGS.iter().filter(|recording| recording.name != "fd-1m-8m-72mhz") {
        let mut detector = PulseDetector::<160>::new();
        let (verdict, depth) = stack::measure(|| replay(&mut detector, recording));
        deepest = deepest.max(depth);
        let mut detector = CompactDetector::<128>::new();
        let (compact, depth) = stack::measure(|| replay(&mut detector, recording));
        deepest_compact = deepest_compact.max(depth);
        // It finds less, but nothing wrong; of two rates it names the first that it proves.
        let contradicts = matches!(compact, Verdict::Found(_)) && !recording.expects(&compact);
        if !recording.expects(&verdict) || contradicts && recording.verdict != "conflict" {
            print("wrong verdict: ");
            print(recording.name);
            print("\n");
            status = Status::Failed;
        }
    }
    print_pair("detector_ram_bytes", size_of::<PulseDetector>() as u64);
    print_pair("detector_stack_bytes", deepest as u64);
    print_pair("compact_ram_bytes", size_of::<CompactDetector>() as u64);
    print_pair("compact_stack_bytes", deepest_compact as u64);
    print_pair("minimum_ram_bytes", size_of::<MinimumPulse>() as u64);
    for (name, bitrate, timer_hz) in CASES {
        let mut edges = [0_u32; 160];
        let (count, end) = sample(FRAME, bitrate, timer_hz, &mut edges);
        let edges = edges.get(..count).unwrap_or(&[]);
        let case = Case { name, edges, end };
        figure("edges", name, count as u64);
        if !measure(&counter, "detector", PulseDetector::<160>::new(), case) {
            status = Status::Failed;
        }
        // Fewer ticks are beyond it.
        if timer_hz >= 4 * bitrate
            && !measure(&counter, "compact", CompactDetector::<128>::new(), case)
        {
            status = Status::Failed;
        }
        measure_minimum(&counter, case);
    }
    for (name, timer_hz) in CLOCKS {
        let detector = found_permille(PulseDetector::<160>::new, timer_hz);
        figure("detector_found_permille", name, detector);
        let compact = found_permille(CompactDetector::<128>::new, timer_hz);
        figure("compact_found_permille", name, compact);
    }
    console::exit(status)
}

/// The frame that is measured: seven random bytes.
const FRAME: &str = "stuff-bit-after-crc-data-base-3";

/// A name for the figures, the bit rate, the clock of the timer.
const CASES: [(&str, u64, u64); 6] = [
    ("1m_16mhz", 1_000_000, 16_000_000),
    ("500k_72mhz", 500_000, 72_000_000),
    ("125k_1mhz", 125_000, 1_000_000),
    ("1m_4mhz", 1_000_000, 4_000_000),
    ("1m_2mhz", 1_000_000, 2_000_000),
    ("1m_1.5mhz", 1_000_000, 1_500_000),
];

/// Clocks of timers on a bus of 1 Mbit/s.
const CLOCKS: [(&str, u64); 7] = [
    ("1.5mhz", 1_500_000),
    ("2mhz", 2_000_000),
    ("3mhz", 3_000_000),
    ("4mhz", 4_000_000),
    ("5mhz", 5_000_000),
    ("6mhz", 6_000_000),
    ("8mhz", 8_000_000),
];

/// What both detectors do.
trait Detector {
    fn begin(&mut self, at: u64, level: Logic);
    fn push(&mut self, at: u64);
    fn finish(&mut self, at: u64);
    fn verdict(&self) -> Verdict;
}

macro_rules! detector {
    ($name:ident) => {
        impl<const N: usize> Detector for $name<N> {
            fn begin(&mut self, at: u64, level: Logic) {
                $name::begin(self, at, level);
            }
            fn push(&mut self, at: u64) {
                $name::push(self, at);
            }
            fn finish(&mut self, at: u64) {
                $name::finish(self, at);
            }
            fn verdict(&self) -> Verdict {
                $name::verdict(self)
            }
        }
    };
}

detector!(PulseDetector);
detector!(CompactDetector);

#[inline(never)]
fn replay(detector: &mut impl Detector, recording: &Recording) -> Verdict {
    detector.begin(0, recording.initial);
    for &edge in recording.edges {
        detector.push(u64::from(edge));
    }
    detector.finish(recording.end);
    detector.verdict()
}

/// Of the classic frames among the corner cases, the share whose rate of 1 Mbit/s is found right, to
/// 1.6 %, from that frame alone.
#[inline(never)]
fn found_permille<D: Detector>(new: fn() -> D, timer_hz: u64) -> u64 {
    let (mut frames, mut found) = (0, 0);
    for (name, _) in FRAMES.iter().filter(|(name, _)| name.starts_with("stuff-bit-after-crc")) {
        let mut edges = [0_u32; 160];
        let (count, end) = sample(name, 1_000_000, timer_hz, &mut edges);
        let mut detector = new();
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

/// One frame as a timer sees it.
#[derive(Clone, Copy)]
struct Case<'a> {
    name: &'a str,
    edges: &'a [u32],
    end: u64,
}

/// The frame edge by edge; whether its rate was found.
#[inline(never)]
fn measure(counter: &Counter, who: &str, mut detector: impl Detector, case: Case<'_>) -> bool {
    let Case { name, edges, end } = case;
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
    let found = matches!(verdict, Verdict::Found(_));
    if !found {
        print("not found: ");
        print(who);
        print(" ");
        print(name);
        print("\n");
    }
    let count = edges.len().max(1) as u64;
    let figure = |what: &str, value: u64| {
        print(who);
        figure(what, name, value);
    };
    figure("_edge_mean", (total + last).div_ceil(count));
    figure("_edge_push_mean", total.div_ceil(count));
    figure("_edge_push_max", most);
    figure("_verdict", last);
    figure("_known_rate_edge_mean", again.div_ceil(count));
    found
}

#[inline(never)]
fn measure_minimum(counter: &Counter, case: Case<'_>) {
    let mut minimum = MinimumPulse::new();
    let mut total = 0;
    for pair in case.edges.chunks_exact(2) {
        if let &[falling, rising] = pair {
            let ((), instructions) = counter.count(|| minimum.push(rising - falling));
            total += instructions;
        }
    }
    let (_, last) = counter.count(|| minimum.shortest());
    let count = case.edges.len().max(1) as u64;
    figure("minimum_edge_mean", case.name, (total + last).div_ceil(count));
}

fn figure(what: &str, name: &str, value: u64) {
    print(what);
    print("_");
    print(name);
    print(" ");
    print_number(value);
    print("\n");
}
