//! The independent Python reference reads what a monitoring node samples, frame for frame.

mod common;

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use canbaud::wire::{FdCrc, Frame, FrameKind, Id, Level};
use canbaud_sim::{Event, Mode, NodeId, Observer, Rng, Sample, Sampling, Simulation, Span, Time};
use common::node;

/// What one node samples and accepts.
struct Ear {
    node: NodeId,
    bits: String,
    frames: Vec<Frame>,
    errors: usize,
}

impl Observer for Ear {
    const SAMPLING: Sampling = Sampling::InTime;

    fn sample(&mut self, _: Time, node: NodeId, sample: &Sample) {
        if node == self.node {
            self.bits.push(if sample.level == Level::Dominant { '0' } else { '1' });
        }
    }

    fn event(&mut self, _: Time, node: NodeId, event: &Event) {
        match event {
            Event::Received { frame } if node == self.node => self.frames.push(*frame),
            Event::Error { .. } if node == self.node => self.errors += 1,
            _ => {}
        }
    }
}

fn any_frame(rng: &mut Rng, fd: bool) -> Frame {
    let id = match rng.below(2) {
        0 => Id::Base(rng.below(0x800) as u16),
        _ => Id::Extended(rng.below(0x2000_0000) as u32),
    };
    let kind = match (fd && rng.below(3) > 0, rng.below(4)) {
        (true, n) => FrameKind::Fd { brs: n % 2 == 0, esi: n > 2 },
        (false, 0) => FrameKind::Remote,
        (false, _) => FrameKind::Data,
    };
    let dlc = rng.below(16) as u8;
    let style = rng.below(4);
    let bytes: Vec<u8> = (0..Frame::data_length(kind, dlc))
        .map(|_| [0, 0xFF, 0x3C, rng.bits() as u8][style as usize])
        .collect();
    Frame::new(id, kind, dlc, &bytes).unwrap()
}

/// A bus of 500 kbit/s (2 Mbit/s) as node 3, which only monitors, sees it.
fn listen(seed: u64, fd: bool, fd_crc: FdCrc, disturbed: bool) -> Ear {
    let mut sim = Simulation::new(seed);
    let mut rng = Rng::new(seed);
    let ids: Vec<_> = (0..4_i64)
        .map(|n| {
            let mut config = node("n").with_ppb(n * 300_000 - 450_000);
            config.fd_crc = fd_crc;
            if n == 3 {
                config.mode = Mode::BusMonitoring;
            }
            sim.add_node(config.with_data_bitrate(2_000_000).unwrap()).unwrap()
        })
        .collect();
    for n in 0..400 {
        sim.send_at(Time::ZERO + Span::from_us(100), ids[n % 3], any_frame(&mut rng, fd));
    }
    if disturbed {
        for _ in 0..60 {
            sim.dominant_at(Time::ZERO + Span::from_us(rng.below(80_000)), Span::from_us(13));
        }
    }
    let mut ear = Ear { node: ids[3], bits: String::new(), frames: Vec::new(), errors: 0 };
    sim.run(Time::ZERO + Span::from_ms(250), &mut ear);
    ear
}

const PYTHON: &str = "
import sys
from receiver import Receiver
events = Receiver(iso=sys.argv[1] == 'iso', integrated=False).run([int(c) for c in sys.stdin.read()])
for event in events:
    if event.kind == 'frame':
        f = event.frame
        print(f'{f.id:X} {int(f.extended)} {f.kind} {f.dlc} {f.data.hex().upper()}')
";

/// The lines that the reference prints for `bits`; `None` if it is not there.
fn reference(bits: &str, fd_crc: FdCrc) -> Option<Vec<String>> {
    let directory = std::env::var("CANBAUD_REFERENCE").map_or_else(
        |_| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../vectors/reference"),
        PathBuf::from,
    );
    if !directory.join("receiver.py").exists() {
        eprintln!("{} is absent: nothing was compared with it", directory.display());
        return None;
    }
    let crc = if fd_crc == FdCrc::Iso { "iso" } else { "non-iso" };
    let python = Command::new("python3")
        .args(["-B", "-c", PYTHON, crc])
        .current_dir(directory)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn();
    let Ok(mut python) = python else {
        eprintln!("python3 is absent: nothing was compared with the reference");
        return None;
    };
    python.stdin.take().unwrap().write_all(bits.as_bytes()).unwrap();
    let output = python.wait_with_output().unwrap();
    assert!(output.status.success());
    Some(String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect())
}

fn line(frame: &Frame) -> String {
    let kind = match frame.kind() {
        FrameKind::Data => "data",
        FrameKind::Remote => "remote",
        FrameKind::Fd { .. } => "fd",
    };
    let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    let extended = u8::from(frame.id().is_extended());
    format!("{:X} {extended} {kind} {} {data}", frame.id().raw(), frame.dlc())
}

#[test]
fn python_reference_reads_the_same_frames() {
    for (seed, fd, fd_crc, disturbed) in [
        (1, false, FdCrc::Iso, false),
        (2, true, FdCrc::Iso, false),
        (3, true, FdCrc::NonIso, false),
        (4, false, FdCrc::Iso, true),
        (5, true, FdCrc::Iso, true),
    ] {
        let ear = listen(seed, fd, fd_crc, disturbed);
        assert!(ear.frames.len() >= 400, "seed {seed}: {}", ear.frames.len());
        assert_eq!(ear.errors > 20, disturbed, "seed {seed}: {}", ear.errors);
        let Some(read) = reference(&ear.bits, fd_crc) else { return };
        let want: Vec<_> = ear.frames.iter().map(line).collect();
        assert_eq!(read, want, "seed {seed}");
    }
}
