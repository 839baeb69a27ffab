//! No stream of edges, however absurd, makes detector or decoder panic, overflow or stall.
//!
//! Overflow checks are on in tests, so a wrapped sum is a failure here.

use canbaud::detect::{CompactDetector, PulseDetector, find_data_rate};
use canbaud::wire::{
    BusTiming, DataRateWanted, DataTiming, Decoded, Decoder, FdCrc, Level, Listener, Logic,
};

struct Prng(u64);

impl Prng {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}

struct Sink;

impl Listener for Sink {
    fn item(&mut self, decoded: &Decoded) {
        assert!(decoded.nominal.fit().ticks_q20().is_none_or(|ticks| ticks > 0));
    }

    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        find_data_rate(wanted)
    }
}

/// Times of edges of many characters: bits of a bus, glitches, pauses, no progress, the end of
/// time, time running backwards.
fn edges(random: &mut Prng) -> Vec<u64> {
    let bit = 1 << random.below(34);
    let mut now = if random.below(8) == 0 { u64::MAX - random.below(1 << 40) } else { 0 };
    (0..random.below(400))
        .map(|_| {
            let step = match random.below(40) {
                0 => 0,
                1 => 1,
                2 => random.next() >> random.below(64),
                3 => bit * 20,
                _ => bit * (1 + random.below(5)),
            };
            now = if random.below(300) == 0 {
                now.wrapping_sub(step)
            } else {
                now.saturating_add(step)
            };
            now
        })
        .collect()
}

fn timing(random: &mut Prng) -> BusTiming {
    let any = |random: &mut Prng| random.next() >> random.below(64);
    BusTiming {
        ticks_q20: any(random),
        data: (random.below(2) == 0)
            .then(|| DataTiming { ticks_q20: any(random), brs_ticks_q20: any(random) }),
        fd_crc: FdCrc::Iso,
        asymmetry_q20: any(random) as i64,
    }
}

#[test]
fn detector_survives_any_edges() {
    for seed in 1..3000 {
        let mut random = Prng(0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(seed));
        let (mut small, mut large) = (PulseDetector::<9>::new(), PulseDetector::<200>::new());
        let (mut least, mut compact) = (CompactDetector::<1>::new(), CompactDetector::<128>::new());
        for _ in 0..1 + random.below(3) {
            let level = if random.below(2) == 0 { Logic::High } else { Logic::Low };
            let at = random.next() >> random.below(64);
            small.begin(at, level);
            large.begin(at, level);
            least.begin(at, level);
            compact.begin(at, level);
            for at in edges(&mut random) {
                small.push(at);
                large.push(at);
                least.push(at);
                compact.push(at);
            }
            let end = random.next() >> random.below(64);
            small.finish(end);
            large.finish(end);
            least.finish(end);
            compact.finish(end);
        }
        let _ = (small.verdict(), large.verdict(), large.bus_timing());
        let _ = (least.verdict(), compact.verdict());
    }
}

#[test]
fn decoder_survives_any_edges_at_any_rate() {
    for seed in 1..6000 {
        let mut random = Prng(0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(seed));
        let Some(mut decoder) = Decoder::<100>::new(&timing(&mut random)) else { continue };
        for _ in 0..1 + random.below(3) {
            let level = if random.below(2) == 0 { Level::Dominant } else { Level::Recessive };
            decoder.begin(random.next() >> random.below(64), level);
            decoder.edges(&edges(&mut random), &mut Sink);
            decoder.finish(random.next() >> random.below(64), &mut Sink);
        }
    }
}

/// What a bus would send, at bit times that fit the edges: deep into every reader.
#[test]
fn decoder_survives_random_bits_at_their_own_rate() {
    for seed in 1..2000 {
        let mut random = Prng(0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(seed));
        let magnitude = random.below(27);
        let bit = 1 + random.below(1 << magnitude);
        let mut now = 0;
        let times: Vec<u64> = (0..1000)
            .map(|_| {
                now += match random.below(60) {
                    0 => bit * 12,
                    1 => bit * 7,
                    _ => bit * (1 + random.below(5)),
                };
                now
            })
            .collect();
        let timing = BusTiming::classic(bit << 20);
        let Some(mut decoder) = Decoder::<100>::new(&timing) else { continue };
        decoder.begin(0, Level::Recessive);
        decoder.edges(&times, &mut Sink);
        decoder.finish(now + 20 * bit, &mut Sink);
    }
}
