//! Edges out of captures held in memory.

use core::hint::black_box;
use core::ops::ControlFlow;
use std::io::Cursor;

use canbaud::units::Hertz;
use canbaud::wire::Logic;
use canbaud_capture::{EdgeSink, Format, OpenOptions, WordSize, from_reader};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// Adds the edges up, so that none can be left out.
struct Sum(u64);

impl EdgeSink for Sum {
    fn begin(&mut self, _: usize, _: u64, _: Logic) {}
    fn edges(&mut self, _: usize, times: &[u64]) -> ControlFlow<()> {
        self.0 = times.iter().fold(self.0, |sum, time| sum.wrapping_add(*time));
        ControlFlow::Continue(())
    }
    fn end(&mut self, _: usize, _: u64) {}
}

fn stream(bytes: &'static [u8], options: &OpenOptions) -> u64 {
    let mut capture = from_reader(Cursor::new(bytes), options).expect("a good capture");
    let mut sum = Sum(0);
    capture.stream(&mut sum).expect("a good capture");
    sum.0
}

fn samples(word: WordSize) -> OpenOptions {
    OpenOptions {
        format: Some(Format::Logic1Samples(word)),
        samplerate: Hertz::new(24_000_000),
        ..OpenOptions::default()
    }
}

fn packed(c: &mut Criterion) {
    const LEN: usize = 64 << 20;
    let mut group = c.benchmark_group("packed");
    group.throughput(Throughput::Bytes(LEN as u64)).sample_size(20);
    let quiet: &'static [u8] = vec![0xff; LEN].leak();
    group.bench_function("quiet bus, 8 channels", |b| {
        b.iter(|| black_box(stream(quiet, &samples(WordSize::Bits8))));
    });
    group.bench_function("quiet bus, 16 channels", |b| {
        b.iter(|| black_box(stream(quiet, &samples(WordSize::Bits16))));
    });
    // 24 MHz on a full 1 Mbit/s bus: an edge every 48 samples or so, here a fixed pattern of runs.
    let mut busy = vec![0xff; LEN];
    let mut at = 0;
    let mut level = 0xff;
    for run in [24, 48, 120, 24, 72, 24, 24, 96].into_iter().cycle() {
        let Some(stretch) = busy.get_mut(at..at + run) else { break };
        stretch.fill(level);
        level ^= 1;
        at += run;
    }
    let busy: &'static [u8] = busy.leak();
    group.bench_function("full bus, 8 channels", |b| {
        b.iter(|| black_box(stream(busy, &samples(WordSize::Bits8))));
    });
    group.finish();
}

/// `#stamp` and a change per line, in the manner of sigrok.
fn vcd(c: &mut Criterion) {
    let mut text = String::from(
        "$timescale 10 ns $end\n$var wire 1 ! CAN $end\n$enddefinitions $end\n#0 1!\n",
    );
    for n in 0_u32..1_000_000 {
        text.push_str(&format!("#{} {}!\n", 5000 + u64::from(n) * 200, n % 2));
    }
    let text: &'static [u8] = text.into_bytes().leak();
    let mut group = c.benchmark_group("text");
    group.throughput(Throughput::Elements(1_000_000)).sample_size(20);
    group.bench_function("vcd changes", |b| {
        b.iter(|| black_box(stream(text, &OpenOptions::default())));
    });
    let mut rows = String::from("Time(s),CH1(V),CH2(V)\n");
    for n in 0_u32..1_000_000 {
        let (high, low) = if n / 50 % 3 == 0 { ("3.5123", "1.4877") } else { ("2.5021", "2.4980") };
        rows.push_str(&format!("{:.7e},{high},{low}\n", f64::from(n) * 4e-8));
    }
    let rows: &'static [u8] = rows.into_bytes().leak();
    group.bench_function("scope csv rows, two channels and their difference", |b| {
        b.iter(|| black_box(stream(rows, &OpenOptions::default())));
    });
    group.finish();
}

criterion_group!(benches, packed, vcd);
criterion_main!(benches);
