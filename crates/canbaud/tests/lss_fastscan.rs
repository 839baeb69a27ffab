//! Fastscan: right on every bus, and how many requests and how long it takes.

mod lss_bus;

use canbaud::lss::{FastscanError, FastscanOptions, LssAddress, LssState, Pace, Strategy};
use canbaud::units::Micros;
use lss_bus::{Bus, Chance, Way};

const DOCUMENT: FastscanOptions<'static> = FastscanOptions {
    strategy: Strategy::Document,
    pace: Pace { answer_timeout: Micros::from_ms(100), inhibit: Micros(0), settle: Micros(0) },
    known: &[],
};

/// An address as devices have them: small numbers, two halves of 16 bits, or anything.
fn address(chance: &mut Chance) -> LssAddress {
    let mut number = || match chance.below(5) {
        0 => chance.below(4) as u32,
        1 => chance.below(0x1000) as u32,
        2 => (chance.below(8) << 16 | chance.below(16)) as u32,
        3 => chance.below(1_000_000) as u32,
        _ => chance.word() as u32,
    };
    LssAddress::new(number(), number(), number(), number())
}

fn adaptive() -> FastscanOptions<'static> {
    FastscanOptions::default()
}

#[test]
fn the_document_strategy_takes_133_requests_and_the_time_of_its_ones() {
    let address = LssAddress::new(0x1A2B_3C4D, 0x00C0_FFEE, 0x0002_0001, 0x1234);
    let ones: u32 =
        [0x1A2B_3C4D_u32, 0x00C0_FFEE, 0x0002_0001, 0x1234].map(u32::count_ones).iter().sum();
    let mut bus = Bus::new(&[address], Way::STEADY, 1);
    let found = bus.fastscan(DOCUMENT).unwrap().unwrap();
    assert_eq!(found.address, address);
    assert_eq!(found.statistics.requests, 133);
    assert_eq!(found.statistics.silences, ones);
    // Once the full time-out, to see whether anybody else answers.
    let time = u64::from(133 - ones) * 20 + u64::from(ones) * 100 + 100;
    assert_eq!(bus.now, Micros::from_ms(time));
    assert_eq!(bus.slaves[0].state(), LssState::Configuration);
}

#[test]
fn every_bit_of_every_part_is_found() {
    for strategy in [Strategy::Document, Strategy::Adaptive] {
        for bit in 0..128_u32 {
            for number in [1_u128 << bit, !(1_u128 << bit)] {
                let part = |shift: u32| (number >> shift) as u32;
                let address = LssAddress::new(part(0), part(32), part(64), part(96));
                let mut bus = Bus::new(&[address], Way::STEADY, 1);
                let options = FastscanOptions { strategy, ..adaptive() };
                let found = bus.fastscan(options).unwrap().unwrap();
                assert_eq!((found.address, found.statistics.restarts), (address, 0), "bit {bit}");
            }
        }
    }
}

#[test]
fn any_address_on_any_way_is_found_and_never_a_wrong_one() {
    let ways = [
        ("steady", Way::STEADY),
        ("jitter", Way { round_trip: (2_000, 30_000), ..Way::STEADY }),
        ("swift", Way { round_trip: (50, 2_000), ..Way::STEADY }),
        ("late answers", Way { round_trip: (10_000, 25_000), late: 20, ..Way::STEADY }),
        ("lost frames", Way { round_trip: (1_000, 5_000), lost: 3, ..Way::STEADY }),
    ];
    for (name, way) in ways {
        let count = 1_000;
        let mut unfinished = 0;
        for seed in 0..count {
            let address = address(&mut Chance::new(seed + 1_000));
            let mut bus = Bus::new(&[address], way, seed);
            match bus.fastscan(adaptive()) {
                Ok(Some(found)) => {
                    assert_eq!(found.address, address, "{name}, seed {seed}");
                    let state = bus.slaves[0].state();
                    assert_eq!(state, LssState::Configuration, "{name}, seed {seed}");
                }
                Err(_) => unfinished += 1,
                Ok(None) => panic!("{name}, seed {seed}: nobody there"),
            }
        }
        // Both of two requests to begin may be lost.
        assert!(unfinished <= way.lost, "{name}: {unfinished} of {count} unfinished");
    }
}

#[test]
fn several_devices_are_found_one_after_another() {
    for merged in [false, true] {
        for seed in 0..200 {
            let mut chance = Chance::new(seed + 5_000);
            let addresses: Vec<_> = match seed % 2 {
                0 => (0..4).map(|_| address(&mut chance)).collect(),
                // The same product, serial numbers in a row.
                _ => (0..4).map(|n| LssAddress::new(0x29C, 77, 0x0001_0003, 8_000 + n)).collect(),
            };
            let round_trip = if seed % 3 == 0 { (50, 900) } else { (4_000, 12_000) };
            let way = Way { round_trip, merged, ..Way::STEADY };
            let mut bus = Bus::new(&addresses, way, seed);
            let mut found = Vec::new();
            while let Some(one) =
                bus.fastscan(FastscanOptions { known: &found, ..adaptive() }).unwrap()
            {
                found.push(one.address);
                assert!(found.len() <= 4, "seed {seed}: {found:?}");
            }
            let sorted = |mut list: Vec<LssAddress>| {
                list.sort();
                list
            };
            assert_eq!(sorted(found), sorted(addresses), "merged {merged}, seed {seed}");
        }
    }
}

/// A slow device answers one request after the fast one has answered the next.
#[test]
fn slow_and_fast_devices_are_told_apart() {
    for slow in [5_000, 30_000, 60_000, 200_000, 400_000] {
        for seed in 0..20 {
            let mut chance = Chance::new(seed + 7_000);
            let addresses = [address(&mut chance), address(&mut chance), address(&mut chance)];
            let way = Way { round_trip: (800, 1_200), ..Way::STEADY };
            let mut bus = Bus::new(&addresses, way, seed);
            bus.slower = vec![0, slow, slow / 2];
            let mut found = Vec::new();
            while let Some(one) = bus.fastscan(adaptive()).unwrap() {
                found.push(one.address);
                assert!(found.len() <= 3, "{slow} us, seed {seed}: {found:?}");
            }
            let sorted = |mut list: Vec<LssAddress>| {
                list.sort();
                list
            };
            assert_eq!(sorted(found), sorted(addresses.to_vec()), "{slow} us, seed {seed}");
        }
    }
}

/// Seen with processes on vcan: the first answers take 10 ms, all others a fraction of one.
#[test]
fn a_slow_start_of_several_devices_is_not_held_against_them() {
    for seed in 0..20 {
        let mut chance = Chance::new(seed + 9_000);
        let addresses = [address(&mut chance), address(&mut chance), address(&mut chance)];
        let way = Way { round_trip: (150, 250), ..Way::STEADY };
        let mut bus = Bus::new(&addresses, way, seed);
        bus.slow_start = 10_000;
        let found = bus.fastscan(adaptive()).unwrap().unwrap();
        assert!(addresses.contains(&found.address), "seed {seed}");
        assert_eq!(found.statistics.restarts, 0, "seed {seed}");
    }
}

#[test]
fn a_known_address_takes_few_requests() {
    let address = LssAddress::new(0x1A2B_3C4D, 0x00C0_FFEE, 0x0002_0001, 0x1234);
    let other = LssAddress::new(7, 7, 7, 7);
    let mut bus = Bus::new(&[address], Way::STEADY, 1);
    let known = [other, address];
    let found = bus.fastscan(FastscanOptions { known: &known, ..adaptive() }).unwrap().unwrap();
    assert_eq!(found.address, address);
    // Three to begin; a wrong number; for each part "is it this?" and "go on"; eight bits of the
    // serial number, with "is all right so far?" behind two silences in a row.
    assert!(found.statistics.requests <= 3 + 1 + 4 * 2 + 8 + 4, "{:?}", found.statistics);
}

#[test]
fn nobody_without_node_id_is_no_error() {
    let mut bus = Bus::new(&[], Way::STEADY, 1);
    assert_eq!(bus.fastscan(adaptive()), Ok(None));
    // Asked twice: one lost frame is no proof of an empty bus.
    assert_eq!(bus.now, Micros::from_ms(1001));
}

#[test]
fn a_device_that_goes_away_is_lost() {
    for limit in [1, 4, 20, 40] {
        let address = LssAddress::new(0x1A2B_3C4D, 0x00C0_FFEE, 3, 4);
        let mut bus = Bus::new(&[address], Way::STEADY, 1);
        bus.dies_after = Some(limit);
        assert_eq!(bus.fastscan(adaptive()), Err(FastscanError::Lost), "after {limit} requests");
    }
}

/// What python-canopen's fast_scan takes: the bits of the document, 10 ms of sleep behind each.
fn python_canopen(address: LssAddress, round_trip: u64, timeout: u64) -> u64 {
    use canbaud::lss::Part;
    let ones: u32 = Part::ALL.iter().map(|part| address.part(*part).count_ones()).sum();
    let ones = u64::from(ones);
    (133 - ones) * round_trip + ones * timeout + 133 * 10
}

#[test]
fn fastscan_is_several_times_as_fast_as_bit_by_bit() {
    let mut sums = [0_u64; 3];
    let (mut requests, mut most) = (0, 0);
    let count = 300;
    for seed in 0..count {
        let address = address(&mut Chance::new(seed + 9_000));
        let mut bus = Bus::new(&[address], Way::STEADY, seed);
        let found = bus.fastscan(adaptive()).unwrap().unwrap();
        requests += u64::from(found.statistics.requests);
        most = most.max(found.statistics.requests);
        sums[0] += bus.now.ms();
        sums[1] += python_canopen(address, 20, 500);
        sums[2] += python_canopen(address, 20, 150);
    }
    let [own, peer, hurried] = sums.map(|sum| sum / count);
    println!(
        "20 ms there and back, {count} addresses: {own} ms with {} requests (at most {most}); \
         bit by bit {peer} ms at a time-out of 500 ms, {hurried} ms at 150 ms",
        requests / count
    );
    assert!(peer >= 5 * own, "{own} ms against {peer} ms");
    assert!(hurried >= 2 * own, "{own} ms against {hurried} ms");
}
