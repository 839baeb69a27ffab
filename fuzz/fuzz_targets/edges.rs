//! Any edges to both detectors, and to the decoder at the rate found or at any other.
#![no_main]

use canbaud::detect::{CompactDetector, PulseDetector, find_data_rate};
use canbaud::wire::{
    BusTiming, DataRateWanted, DataTiming, Decoded, Decoder, Level, Listener, Logic,
};
use libfuzzer_sys::fuzz_target;

struct Sink;

impl Listener for Sink {
    fn item(&mut self, _: &Decoded) {}

    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        find_data_rate(wanted)
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((head, steps)) = bytes.split_first_chunk::<8>() else { return };
    let any_rate = u64::from_le_bytes(*head);
    // Two bytes a run: a length and how far it is shifted.
    let mut now = 0_u64;
    let times: Vec<u64> = steps
        .chunks_exact(2)
        .map(|step| {
            now = now.saturating_add(u64::from(step[0]) << (step[1] % 48));
            now
        })
        .collect();
    let mut detector = PulseDetector::<200>::new();
    detector.begin(0, Logic::High);
    for &at in &times {
        detector.push(at);
    }
    detector.finish(now);
    let mut compact = CompactDetector::<800>::new();
    compact.begin(0, Logic::High);
    times.iter().for_each(|&at| compact.push(at));
    compact.finish(now);
    let timing = detector.bus_timing().unwrap_or(BusTiming::classic(any_rate));
    if let Some(mut decoder) = Decoder::<200>::new(&timing) {
        decoder.begin(0, Level::Recessive);
        decoder.edges(&times, &mut Sink);
        decoder.finish(now, &mut Sink);
    }
});
