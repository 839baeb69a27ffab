//! Good files, damaged at random: no panic, no endless loop, and never an edge out of order (the
//! sink checks that). The fuzz targets in `fuzz/` do the same for longer.

mod common;

use std::io::Cursor;

use canbaud::units::Hertz;
use canbaud_capture::{Format, OpenOptions, WordSize, from_reader};
use common::{Kept, Random, archive_with, pack, samples};

const ROUNDS: u64 = 1500;

/// Changes a few bytes, or cuts, repeats or moves a piece.
fn mutate(random: &mut Random, good: &[u8]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..=random.below(4) {
        let len = bytes.len() as u64;
        if len == 0 {
            break;
        }
        let at = random.below(len) as usize;
        let end = (at + random.below(64) as usize).min(bytes.len());
        match random.below(9) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.next() as u8,
            2 => bytes.truncate(at),
            3 => bytes[at..end].fill(0xff),
            4 => bytes[at..end].fill(0),
            5 => drop(bytes.drain(at..end)),
            6 => {
                let piece = bytes[at..end].to_vec();
                let to = random.below(len) as usize;
                bytes.splice(to..to, piece);
            }
            // Text formats: another digit, sign or separator.
            7 => bytes[at] = b"0123456789-+.eE,;#$ \n\t"[random.below(22) as usize],
            _ => bytes[at..end].iter_mut().for_each(|b| *b = b.wrapping_add(1)),
        }
    }
    bytes
}

fn stream(bytes: &[u8], format: Option<Format>) -> bool {
    let needs_rate = matches!(format, Some(Format::Logic1Samples(_) | Format::Logic1Changes(_)));
    let options = OpenOptions {
        format,
        samplerate: if needs_rate { Hertz::new(1_000_000) } else { None },
        max_inflated: 1 << 24,
        ..OpenOptions::default()
    };
    match from_reader(Cursor::new(bytes.to_vec()), &options) {
        Ok(mut capture) => match capture.stream(&mut Kept::default()) {
            Ok(_) => true,
            Err(error) => {
                assert_eq!(error.to_string().lines().count(), 1);
                false
            }
        },
        Err(error) => {
            assert_eq!(error.to_string().lines().count(), 1);
            false
        }
    }
}

/// Damages `good` many times over; forced to its format and found.
fn hammer(seed: u64, good: &[u8], format: Format) {
    assert!(stream(good, Some(format)), "{format}: the file to damage is not good");
    let mut accepted = 0;
    for round in 0..ROUNDS {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (round + 1));
        let bad = mutate(&mut random, good);
        let forced = (round % 3 > 0).then_some(format);
        // The test framework prints this only when the next line panics.
        println!("repeat with: seed {seed:#x}, round {round}, {format}");
        accepted += u64::from(stream(&bad, forced));
    }
    assert!(accepted < ROUNDS, "{format}: no damage is ever noticed");
}

fn words() -> Vec<u8> {
    pack(&samples(&mut Random(7), 4000, 8), 1)
}

fn waves() -> Vec<u8> {
    (0..2000_u32).flat_map(|n| if n / 40 % 2 == 0 { 2.5_f32 } else { 3.5 }.to_le_bytes()).collect()
}

#[test]
fn sr() {
    let metadata = "[device 1]\ncapturefile=logic-1\nunitsize=1\ntotal probes=8\n\
        samplerate=8 MHz\nprobe1=A\nprobe2=B\nanalog9=H\nanalog10=L\n";
    let members: [(&str, &[u8]); 6] = [
        ("version", b"2"),
        ("metadata", metadata.as_bytes()),
        ("logic-1-1", &words()),
        ("logic-1-2", &words()),
        ("analog-1-9-1", &waves()),
        ("analog-1-10-1", &waves()),
    ];
    for (seed, method) in
        [(0x11, zip::CompressionMethod::Deflated), (0x12, zip::CompressionMethod::Stored)]
    {
        hammer(seed, &archive_with(&members, method), Format::SigrokSr);
    }
    // Damage within a sound archive: the metadata.
    for round in 0..ROUNDS {
        let mut random = Random(0x1300 + round);
        let bad = mutate(&mut random, metadata.as_bytes());
        let mut members = members;
        members[1].1 = &bad;
        println!("repeat with: metadata, round {round}");
        stream(&archive_with(&members, zip::CompressionMethod::Stored), Some(Format::SigrokSr));
    }
}

#[test]
fn dsview() {
    let header = "[version]\nversion = 3\n[header]\ndevice mode = 0\ntotal samples = 32000\n\
        samplerate = 25 MHz\nprobe0 = A\nprobe1 = B\n";
    let members: [(&str, &[u8]); 3] =
        [("header", header.as_bytes()), ("L-0/0", &words()), ("L-1/0", &words())];
    hammer(0x20, &archive_with(&members, zip::CompressionMethod::Stored), Format::DsView);
}

#[test]
fn vcd() {
    let mut text = String::from(
        "$comment Acquisition with 2/2 channels at 24 MHz $end $timescale 100 ps $end\n\
         $var wire 1 ! a $end $var real 64 \" H $end $var real 64 # L $end $var reg 4 $ d [3:0] $end\n\
         $enddefinitions $end\n#0 0! r2.5 \" r2.5 # b0 $\n",
    );
    for n in 1..60 {
        text.push_str(&format!(
            "#{} {}! r{} \" r{} # b{:b} $\n",
            n * 417,
            n % 2,
            2.5 + f64::from(n % 2),
            2.5 - f64::from(n % 2),
            n % 16
        ));
    }
    hammer(0x30, text.as_bytes(), Format::Vcd);
}

#[test]
fn csv() {
    let mut scope = String::from("Model,X\nSample Interval,4e-08,\nTIME,CH1,CH2,D7-D0\n");
    let mut saleae = String::from("Time [s],A,B\n");
    let mut sigrok =
        String::from("; Channels (2/8): A, B\n; Samplerate: 4 MHz\nnanoseconds,logic,logic\n");
    for n in 0..80 {
        scope.push_str(&format!(
            "{:.5e},{},{},0x{n:02X}\n",
            f64::from(n) * 4e-8,
            2.5 + f64::from(n / 8 % 2),
            2.5 - f64::from(n / 8 % 2)
        ));
        saleae.push_str(&format!("{:.9},{},{}\n", f64::from(n * n) * 1e-6, n % 2, n / 2 % 2));
        sigrok.push_str(&format!("{},{},{}\n", 250 * (n + 1), n % 2, n / 2 % 2));
    }
    hammer(0x40, scope.as_bytes(), Format::ScopeCsv);
    hammer(0x41, saleae.as_bytes(), Format::SaleaeCsv);
    hammer(0x42, sigrok.as_bytes(), Format::SigrokCsv);
}

#[test]
fn saleae() {
    let mut digital = b"<SALEAE>\x01\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0".to_vec();
    for chunk in 0..2 {
        digital.extend(1_u32.to_le_bytes());
        let begin = f64::from(chunk) * 0.01;
        [24e6, begin, begin + 0.005].iter().for_each(|v| digital.extend(v.to_le_bytes()));
        digital.extend(40_u64.to_le_bytes());
        (1..=40).for_each(|n| digital.extend((begin + f64::from(n) * 1e-6).to_le_bytes()));
    }
    hammer(0x50, &digital, Format::SaleaeBinary);
    let mut analogue = b"<SALEAE>\0\0\0\0\x01\0\0\0".to_vec();
    analogue.extend(0.0_f64.to_le_bytes());
    [50_000_000_u64, 2, 2000].iter().for_each(|v| analogue.extend(v.to_le_bytes()));
    analogue.extend(waves());
    hammer(0x51, &analogue, Format::SaleaeBinary);
    let changes: Vec<u8> = (0..60_u64)
        .flat_map(|n| [(n * n).to_le_bytes().as_slice(), &[(n % 2) as u8, 0]].concat())
        .collect();
    hammer(0x52, &changes, Format::Logic1Changes(WordSize::Bits16));
}

#[test]
fn isf() {
    let mut file =
        b":WFMPRE:BYT_NR 2;BYT_OR LSB;XINCR 4E-9;YMULT 1E-3;YOFF 0;:CURVE #3400".to_vec();
    (0..200).for_each(|n: i32| file.extend(((n / 20 % 2 * 3000) as i16).to_le_bytes()));
    hammer(0x60, &file, Format::TekIsf);
}

#[test]
fn logicdata() {
    let mut file =
        b"\x7f\x01\x05\x01\x09Data save\x03\0\x12\x7a\0\x01\x10\x01\x01\0\x01\x03CAN\0\0".to_vec();
    file.extend([1, 40, 0, 1, 40, 0, 1, 40]);
    (0..40_u8).for_each(|n| file.push((n + 1) | ((n % 2) << 7)));
    file.extend([0; 15]);
    file.extend([1, 2, 0, 1, 2, 0, 1, 2]);
    for (position, start, before) in [(0_u64, 0_u64, u64::MAX), (210, 20, 19)] {
        [position, start, before, 1].iter().for_each(|v| file.extend(v.to_le_bytes()));
    }
    hammer(0x70, &file, Format::LogicData);
}
