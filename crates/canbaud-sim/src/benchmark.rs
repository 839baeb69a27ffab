//! Labelled captures over a grid of rates, timers, troubles and scenes: what detectors are
//! measured with. The set is computed, never stored; a case and a seed are the capture.

use canbaud::wire::{FdCrc, Frame, FrameKind, Id, Level};

use crate::around::{Capture, CaptureTimer};
use crate::bus::Transceiver;
use crate::event::{NodeId, Observer};
use crate::node::{Mode, NodeConfig};
use crate::rng::Rng;
use crate::simulation::Simulation;
use crate::time::{Span, Time};

/// What happens on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scene {
    /// Two nodes talk and acknowledge.
    Acknowledged,
    /// One node talks, nobody acknowledges.
    Unacknowledged,
    /// Every other frame is destroyed by error flags.
    ErrorFlags,
    /// A third node talks at another rate.
    Babbler,
    /// So many glitches a frame, on average, each up to a fifth of a bit long.
    Glitches(u32),
    /// The line is recorded upside down.
    Inverted,
    /// The line is stuck dominant for a while.
    Stuck,
    /// Nothing, then one frame.
    OneFrame,
}

/// What kind of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Traffic {
    /// Classic frames.
    Classic,
    /// CAN FD frames without bit rate switch.
    Fd,
    /// CAN FD frames with bit rate switch to so many bit/s.
    FdBrs(u32),
    /// As before, but with the CRC from before ISO 11898-1:2015.
    FdBrsNonIso(u32),
}

/// One point of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Case {
    /// Nominal bit rate in bit/s.
    pub bitrate: u32,
    /// Clock of the capture timer in Hz.
    pub timer_hz: u64,
    /// How much longer dominant pulses are at RXD, in ns.
    pub asymmetry_ns: i32,
    /// Largest deviation of an edge at RXD, in ns.
    pub jitter_ns: u32,
    /// Clock error of the talkers against the timer, in ppm.
    pub ppm: i32,
    /// Share of the time that frames take, in thousandths.
    pub load_permille: u32,
    /// What happens.
    pub scene: Scene,
    /// Which frames.
    pub traffic: Traffic,
}

/// What there is to know about a capture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Truth {
    /// Nominal bit rate in bit/s, as meant.
    pub bitrate: u32,
    /// Data bit rate in bit/s, if frames switch to it.
    pub data_bitrate: Option<u32>,
    /// Frames that went out with success: when EOF ended (in ticks), and which.
    pub frames: Vec<(u64, Frame)>,
    /// Whether the capture is upside down.
    pub inverted: bool,
}

/// A capture with its truth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labelled {
    /// Edges: ticks, and whether the line is high after it.
    pub edges: Vec<(u64, bool)>,
    /// Whether the line is high before the first edge.
    pub starts_high: bool,
    /// Clock of the ticks in Hz.
    pub timer_hz: u64,
    /// The truth.
    pub truth: Truth,
}

/// Bit rates of the grid.
pub const BITRATES: [u32; 24] = [
    10_000, 16_667, 20_000, 25_000, 31_250, 33_333, 47_619, 50_000, 62_500, 80_000, 83_333, 95_238,
    100_000, 125_000, 200_000, 250_000, 400_000, 500_000, 615_385, 625_000, 666_667, 800_000,
    833_333, 1_000_000,
];
/// Timer clocks of the grid.
pub const TIMERS: [u64; 8] =
    [1_000_000, 2_000_000, 4_000_000, 8_000_000, 10_000_000, 16_000_000, 24_000_000, 72_000_000];
/// Asymmetries of the grid.
pub const ASYMMETRIES: [i32; 5] = [0, 50, -50, 100, -100];
/// Clock errors of the grid.
pub const PPM: [i32; 5] = [0, 3_000, -3_000, 5_000, -5_000];
/// Loads of the grid: 0.1, 9, 50 and 95 %.
pub const LOADS: [u32; 4] = [1, 90, 500, 950];
/// Scenes of the grid.
pub const SCENES: [Scene; 10] = [
    Scene::Acknowledged,
    Scene::Unacknowledged,
    Scene::ErrorFlags,
    Scene::Babbler,
    Scene::Glitches(1),
    Scene::Glitches(10),
    Scene::Glitches(100),
    Scene::Inverted,
    Scene::Stuck,
    Scene::OneFrame,
];
/// Kinds of frames of the grid.
pub const TRAFFIC: [Traffic; 7] = [
    Traffic::Classic,
    Traffic::Fd,
    Traffic::FdBrs(1_000_000),
    Traffic::FdBrs(2_000_000),
    Traffic::FdBrs(5_000_000),
    Traffic::FdBrs(8_000_000),
    Traffic::FdBrsNonIso(2_000_000),
];

/// The plainest case, from which the grid departs one axis at a time.
pub const PLAIN: Case = Case {
    bitrate: 500_000,
    timer_hz: 8_000_000,
    asymmetry_ns: 0,
    jitter_ns: 10,
    ppm: 0,
    load_permille: 500,
    scene: Scene::Acknowledged,
    traffic: Traffic::Classic,
};

/// Every rate with every timer, and with every value of each other axis.
#[must_use]
pub fn grid() -> Vec<Case> {
    let mut cases = Vec::new();
    for bitrate in BITRATES {
        let plain = Case { bitrate, ..PLAIN };
        cases.extend(TIMERS.map(|timer_hz| Case { timer_hz, ..plain }));
        cases.extend(ASYMMETRIES.map(|asymmetry_ns| Case { asymmetry_ns, ..plain }));
        cases.extend(PPM.map(|ppm| Case { ppm, ..plain }));
        cases.extend(LOADS.map(|load_permille| Case { load_permille, ..plain }));
        cases.extend(SCENES.map(|scene| Case { scene, ..plain }));
    }
    for bitrate in [250_000, 500_000, 1_000_000] {
        // A data bit of 8 Mbit/s has nine ticks at 72 MHz.
        let plain = Case { bitrate, timer_hz: 72_000_000, ..PLAIN };
        let faster = |traffic: &Traffic| match traffic {
            Traffic::Classic | Traffic::Fd => true,
            Traffic::FdBrs(rate) | Traffic::FdBrsNonIso(rate) => *rate > bitrate,
        };
        cases.extend(TRAFFIC.into_iter().filter(faster).map(|t| Case { traffic: t, ..plain }));
    }
    let mut seen = std::collections::HashSet::new();
    cases.retain(|case| seen.insert(*case));
    cases
}

/// Keeps captured edges and frames.
struct Recorder {
    timer: CaptureTimer,
    transceiver: Transceiver,
    salt: u64,
    count: u64,
    captures: Vec<Capture>,
    frames: Vec<(u64, Frame)>,
}

impl Observer for Recorder {
    fn bus(&mut self, at: Time, level: Level) {
        self.count += 1;
        let at = self.transceiver.to_rxd(at, level, self.salt ^ self.count);
        let ticks = self.timer.ticks(at);
        match self.captures.last() {
            // A pulse that the asymmetry, the jitter or the timer eats up.
            Some(last) if last.ticks >= ticks => {
                self.captures.pop();
            }
            Some(_) | None => self.captures.push(Capture { ticks, level, overrun: false }),
        }
    }

    fn event(&mut self, at: Time, _: NodeId, event: &crate::event::Event) {
        if let crate::event::Event::Transmitted { frame } = event {
            self.frames.push((self.timer.ticks(at), *frame));
        }
    }
}

impl Case {
    /// The capture of this case: about `frames` frames, chosen by `seed`; `None` if no node can
    /// have the bit rates.
    #[must_use]
    pub fn generate(&self, seed: u64, frames: u32) -> Option<Labelled> {
        let mut sim = Simulation::new(seed);
        let mut rng = Rng::for_purpose(seed, 1);
        let talkers: Vec<NodeId> =
            (0..2).map(|n| sim.add_node(self.talker(n)?).ok()).collect::<Option<_>>()?;
        let bit_fs = 1_000_000_000_000_000 / u64::from(self.bitrate);
        let frame_fs = 130 * bit_fs;
        let gap = frame_fs * 1_000 / u64::from(self.load_permille.max(1));
        let begin = Time::ZERO + Span::from_fs(20 * bit_fs);
        let count = if self.scene == Scene::OneFrame { 1 } else { frames };
        let mut at = begin;
        for n in 0..count {
            // Back to back would be a load that nobody has; random within its period.
            let offset = rng.below((gap - frame_fs.min(gap)) + 1);
            let sender =
                talkers[if self.scene == Scene::Unacknowledged { 0 } else { n as usize % 2 }];
            sim.send_at(at + Span::from_fs(offset), sender, self.frame(&mut rng)?);
            at += Span::from_fs(gap);
        }
        let end = at + Span::from_fs(frame_fs);
        self.add_scene(&mut sim, &mut rng, begin, end)?;
        let mut recorder = Recorder {
            timer: CaptureTimer::new(self.timer_hz, 0, 64, Span::ZERO).ok()?,
            transceiver: self.ear(),
            salt: crate::rng::mix(seed ^ 0xEA5),
            count: 0,
            captures: Vec::new(),
            frames: Vec::new(),
        };
        sim.run(end, &mut recorder);
        Some(self.label(recorder))
    }

    fn talker(&self, n: i64) -> Option<NodeConfig> {
        let mut config = NodeConfig::at("talker", self.bitrate).ok()?;
        // Two talkers that differ by 100 ppm.
        config.oscillator.ppb = i64::from(self.ppm) * 1_000 + n * 100_000;
        let data = match self.traffic {
            Traffic::Classic | Traffic::Fd => None,
            Traffic::FdBrs(rate) => Some(rate),
            Traffic::FdBrsNonIso(rate) => {
                config.fd_crc = FdCrc::NonIso;
                Some(rate)
            }
        };
        if let Some(rate) = data {
            config = config.with_data_bitrate(rate).ok()?;
            config.tdc = crate::node::Tdc::Offset(config.data?.sample_quanta());
        }
        if self.scene == Scene::Unacknowledged && n == 1 {
            config.mode = Mode::BusMonitoring;
        }
        Some(config)
    }

    fn ear(&self) -> Transceiver {
        let base = 100_000 + u64::from(self.jitter_ns) * 1_000;
        let extra = u64::from(self.asymmetry_ns.unsigned_abs()) * 1_000;
        let ps = |value: u64| Span::from_fs(value * 1_000);
        // Dominant pulses get longer when their end comes late.
        let (dominant, recessive) =
            if self.asymmetry_ns >= 0 { (base, base + extra) } else { (base + extra, base) };
        Transceiver {
            rx_dominant: ps(dominant),
            rx_recessive: ps(recessive),
            jitter: Span::from_ns(self.jitter_ns.into()),
            ..Transceiver::symmetrical(Span::ZERO)
        }
    }

    fn frame(&self, rng: &mut Rng) -> Option<Frame> {
        let kind = match self.traffic {
            Traffic::Classic => FrameKind::Data,
            Traffic::Fd => FrameKind::Fd { brs: false, esi: false },
            Traffic::FdBrs(_) | Traffic::FdBrsNonIso(_) => FrameKind::Fd { brs: true, esi: false },
        };
        let id = if rng.below(4) == 0 {
            Id::extended(rng.below(0x2000_0000) as u32)
        } else {
            Id::base(rng.below(0x800) as u16)
        }?;
        let dlc = rng.below(9) as u8;
        let bytes: Vec<u8> = (0..Frame::data_length(kind, dlc)).map(|_| rng.bits() as u8).collect();
        Frame::new(id, kind, dlc, &bytes).ok()
    }

    fn add_scene(&self, sim: &mut Simulation, rng: &mut Rng, begin: Time, end: Time) -> Option<()> {
        let bit = Span::from_fs(1_000_000_000_000_000 / u64::from(self.bitrate));
        let length = end.since(begin).femtoseconds();
        match self.scene {
            Scene::Acknowledged | Scene::Unacknowledged | Scene::Inverted | Scene::OneFrame => {}
            Scene::ErrorFlags => {
                let step = 260 * bit.femtoseconds() * 1_000 / u64::from(self.load_permille.max(1));
                let mut at = begin;
                while at < end {
                    at += Span::from_fs(1 + rng.below(2 * step));
                    sim.dominant_at(at, Span::from_fs(6 * bit.femtoseconds()));
                }
            }
            Scene::Babbler => {
                let rate = if self.bitrate == 250_000 { 125_000 } else { 250_000 };
                let babbler = sim.add_node(NodeConfig::at("babbler", rate).ok()?).ok()?;
                for _ in 0..4 {
                    let at = begin + Span::from_fs(rng.below(length));
                    sim.send_at(at, babbler, self.frame(rng)?);
                }
            }
            Scene::Glitches(per_frame) => {
                let step = 130 * bit.femtoseconds() / u64::from(per_frame.max(1));
                let mut at = begin;
                while at < end {
                    at += Span::from_fs(1 + rng.below(2 * step));
                    let width = Span::from_fs(1 + rng.below(bit.femtoseconds() / 5));
                    if rng.below(2) == 0 {
                        sim.dominant_at(at, width);
                    } else {
                        sim.recessive_at(at, width);
                    }
                }
            }
            Scene::Stuck => {
                let at = begin + Span::from_fs(length / 3);
                sim.dominant_at(at, Span::from_fs(length / 10));
            }
        }
        Some(())
    }

    fn label(&self, recorder: Recorder) -> Labelled {
        let inverted = self.scene == Scene::Inverted;
        let high = |level: Level| (level == Level::Recessive) != inverted;
        let edges = recorder.captures.iter().map(|c| (c.ticks, high(c.level))).collect();
        let data_bitrate = match self.traffic {
            Traffic::Classic | Traffic::Fd => None,
            Traffic::FdBrs(rate) | Traffic::FdBrsNonIso(rate) => Some(rate),
        };
        let frames = recorder.frames;
        let truth = Truth { bitrate: self.bitrate, data_bitrate, frames, inverted };
        Labelled { edges, starts_high: !inverted, timer_hz: self.timer_hz, truth }
    }
}
