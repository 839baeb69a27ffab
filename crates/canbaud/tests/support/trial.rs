//! One random recording: its parameters, drawn from a seed and a number, and how it is played.

use super::content::{self, Family};
use super::foreign::{self, Foreign};
use super::judge::{TrueData, Truth};
use super::line::{Capture, Glitch, Recorder, Recording};
use super::prng::Prng;
use super::sender::{Ack, BitClock, Contender, Destroyed, Player};
use canbaud::wire::{EncodedFrame, FdCrc, Frame, FrameKind, Polarity, encode};

/// Bit rates that are drawn most often, in bit/s.
pub const RATES: [f64; 24] = [
    10_000.0,
    16_667.0,
    20_000.0,
    25_000.0,
    31_250.0,
    33_333.0,
    47_619.0,
    50_000.0,
    62_500.0,
    80_000.0,
    83_333.0,
    95_238.0,
    100_000.0,
    125_000.0,
    200_000.0,
    250_000.0,
    400_000.0,
    500_000.0,
    615_385.0,
    625_000.0,
    666_667.0,
    800_000.0,
    833_333.0,
    1_000_000.0,
];
/// Data bit rates of CAN FD, in bit/s.
const DATA_RATES: [f64; 5] = [1e6, 2e6, 4e6, 5e6, 8e6];
/// Timer clocks, in Hz.
const TIMERS: [f64; 8] = [1e6, 2e6, 4e6, 8e6, 10e6, 16e6, 24e6, 72e6];
/// No bit of a trial has fewer ticks than this.
pub const LEAST_TICKS: f64 = 1.5;

/// What is hard about a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scene {
    /// One classic frame, idle around it, nothing else.
    Clean,
    /// Clean, but dominant and recessive bits differ by up to 100 ns.
    Asymmetry,
    /// Clean, but with up to 50 ns rms jitter on each edge.
    Jitter,
    /// Nobody acknowledges: error flag at the ACK delimiter, and again.
    Unacknowledged,
    /// Another node loses the arbitration; its edges are late.
    Arbitration,
    /// One glitch in the frame.
    Glitch,
    /// Ten glitches in the frame.
    Glitches,
    /// A frame destroyed by an error flag, then sent again.
    ErrorFlag,
    /// The recording begins or ends in another frame.
    Cut,
    /// One CAN FD frame.
    Fd,
    /// One CAN FD frame with asymmetry and jitter.
    FdAsymmetry,
    /// Everything at random.
    Mixed,
    /// No CAN bus at all.
    Foreign,
}

impl Scene {
    /// All scenes.
    pub const ALL: [Self; 13] = [
        Self::Clean,
        Self::Asymmetry,
        Self::Jitter,
        Self::Unacknowledged,
        Self::Arbitration,
        Self::Glitch,
        Self::Glitches,
        Self::ErrorFlag,
        Self::Cut,
        Self::Fd,
        Self::FdAsymmetry,
        Self::Mixed,
        Self::Foreign,
    ];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Asymmetry => "asymmetry",
            Self::Jitter => "jitter",
            Self::Unacknowledged => "unacknowledged",
            Self::Arbitration => "arbitration",
            Self::Glitch => "glitch",
            Self::Glitches => "glitches",
            Self::ErrorFlag => "error-flag",
            Self::Cut => "cut",
            Self::Fd => "fd",
            Self::FdAsymmetry => "fd-asymmetry",
            Self::Mixed => "mixed",
            Self::Foreign => "foreign",
        }
    }
}

/// How ticks per bit come about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// One of the usual timer clocks.
    UsualTimers,
    /// Exactly so many ticks per (shortest) bit, before the clock error.
    TicksPerBit(f64),
}

/// Everything about one recording.
#[derive(Debug, Clone)]
pub struct Trial {
    pub scene: Scene,
    pub bitrate: f64,
    pub data_bitrate: f64,
    pub timer_hz: f64,
    pub clock_error_ppm: f64,
    pub sample_point: f64,
    pub data_sample_point: f64,
    pub frame: Frame,
    pub neighbour: Frame,
    pub fd_crc: FdCrc,
    pub ack: Ack,
    pub attempts: u32,
    pub contender: Option<Contender>,
    pub destroyed: Option<Destroyed>,
    /// The recording begins after this fraction of another frame.
    pub cut_before: Option<f64>,
    /// The recording ends after this fraction of another frame.
    pub cut_after: Option<f64>,
    pub idle_before_bits: f64,
    pub idle_after_bits: f64,
    pub asymmetry_ns: f64,
    pub jitter_ns: f64,
    pub glitches: u32,
    pub glitch_ns: f64,
    pub foreign: Option<Foreign>,
    pub polarity: Polarity,
    pub capture: Capture,
    /// Where the axis begins within a tick.
    pub phase: f64,
    pub epoch: u64,
    prng: Prng,
}

impl Trial {
    /// Trial `number` under `seed`.
    pub fn draw(seed: u64, number: u64, scene: Scene, resolution: Resolution) -> Self {
        let mut prng = Prng::new(seed, number);
        let family = match scene {
            Scene::Fd | Scene::FdAsymmetry => Family::Fd,
            Scene::Mixed if prng.chance(0.4) => Family::Fd,
            _ => Family::Classic,
        };
        let frame = content::frame(&mut prng, family);
        let mut trial = Self {
            scene,
            bitrate: bitrate(&mut prng, family),
            data_bitrate: 0.0,
            timer_hz: 0.0,
            clock_error_ppm: clock_error(&mut prng),
            sample_point: prng.uniform(0.70, 0.90),
            data_sample_point: prng.uniform(0.60, 0.85),
            frame,
            neighbour: content::like(&mut prng, &frame),
            fd_crc: if prng.chance(0.9) { FdCrc::Iso } else { FdCrc::NonIso },
            ack: ack(&mut prng),
            attempts: 1,
            contender: None,
            destroyed: None,
            cut_before: None,
            cut_after: None,
            idle_before_bits: prng.uniform(12.0, 40.0),
            idle_after_bits: prng.uniform(3.0, 40.0),
            asymmetry_ns: 0.0,
            jitter_ns: 0.0,
            glitches: 0,
            glitch_ns: 0.0,
            foreign: None,
            polarity: if prng.chance(0.5) { Polarity::Normal } else { Polarity::Inverted },
            capture: if prng.chance(0.5) { Capture::Timer } else { Capture::Sampled },
            phase: prng.uniform(0.0, 1.0),
            epoch: prng.pick(&[0, u64::from(u32::MAX) - 50, 1 << 40]) + prng.below(100),
            prng: prng.clone(),
        };
        trial.draw_clocks(&mut prng, resolution);
        trial.draw_trouble(&mut prng);
        trial.prng = prng;
        trial
    }

    fn draw_clocks(&mut self, prng: &mut Prng, resolution: Resolution) {
        self.data_bitrate = if prng.chance(0.5) {
            (self.bitrate * prng.pick(&[2.0, 3.0, 4.0, 5.0, 8.0])).min(8e6)
        } else {
            prng.pick(&DATA_RATES).max(self.bitrate)
        };
        self.timer_hz = match resolution {
            Resolution::TicksPerBit(ticks) => ticks * self.fastest(),
            Resolution::UsualTimers => loop {
                let timer = prng.pick(&TIMERS);
                if timer / self.fastest() >= LEAST_TICKS {
                    break timer;
                }
            },
        };
    }

    fn draw_trouble(&mut self, prng: &mut Prng) {
        match self.scene {
            Scene::Clean | Scene::Fd => {}
            Scene::Asymmetry => self.add_asymmetry(prng),
            Scene::Jitter => self.add_jitter(prng),
            Scene::Unacknowledged => self.remove_acknowledge(prng),
            Scene::Arbitration => self.add_contender(prng),
            Scene::Glitch => self.add_glitches(prng, 1),
            Scene::Glitches => self.add_glitches(prng, 10),
            Scene::ErrorFlag => self.add_error_flag(prng),
            Scene::Cut => self.add_cuts(prng),
            Scene::FdAsymmetry => {
                self.add_asymmetry(prng);
                self.add_jitter(prng);
            }
            Scene::Mixed => self.add_anything(prng),
            Scene::Foreign => self.foreign = Some(prng.pick(&foreign::ALL)),
        }
    }

    fn add_anything(&mut self, prng: &mut Prng) {
        type Trouble = fn(&mut Trial, &mut Prng);
        let troubles: [(f64, Trouble); 7] = [
            (0.6, Self::add_asymmetry),
            (0.5, Self::add_jitter),
            (0.2, Self::remove_acknowledge),
            (0.3, Self::add_contender),
            (0.3, |trial, prng| {
                let count = prng.pick(&[1, 1, 1, 3, 10]);
                trial.add_glitches(prng, count);
            }),
            (0.4, Self::add_error_flag),
            (0.5, Self::add_cuts),
        ];
        for (probability, trouble) in troubles {
            if prng.chance(probability) {
                trouble(self, prng);
            }
        }
        self.idle_before_bits = prng.uniform(3.0, 40.0);
    }

    fn add_asymmetry(&mut self, prng: &mut Prng) {
        let wanted = prng.pick(&[-100.0, -50.0, 50.0, 100.0]);
        let most = 0.4 * 1e9 / self.fastest();
        self.asymmetry_ns = f64::clamp(wanted, -most, most);
    }

    fn add_jitter(&mut self, prng: &mut Prng) {
        self.jitter_ns = prng.pick(&[5.0_f64, 10.0, 20.0, 50.0]).min(0.05 * 1e9 / self.fastest());
    }

    fn remove_acknowledge(&mut self, prng: &mut Prng) {
        self.ack = Ack::ErrorFlag;
        self.attempts = 1 + prng.below(3) as u32;
    }

    fn add_contender(&mut self, prng: &mut Prng) {
        let bits = 2 + prng.below(10) as usize;
        self.contender = Some(Contender { bits, delay: prng.uniform(0.02, 0.3) });
    }

    fn add_glitches(&mut self, prng: &mut Prng, count: u32) {
        self.glitches = count;
        self.glitch_ns = prng.pick(&[10.0_f64, 30.0, 100.0]).min(0.25 * 1e9 / self.fastest());
    }

    fn add_error_flag(&mut self, prng: &mut Prng) {
        let bits = encode(&self.frame, self.fd_crc).bits.len() as u64;
        self.destroyed = Some(Destroyed {
            bit: 1 + prng.below(bits - 1) as usize,
            flag_bits: 6 + prng.below(7) as u32,
            delay: prng.uniform(0.0, 0.3),
        });
    }

    fn add_cuts(&mut self, prng: &mut Prng) {
        let which = prng.below(3);
        if which != 1 {
            self.cut_before = Some(prng.uniform(0.0, 0.95));
        }
        if which != 0 {
            self.cut_after = Some(prng.uniform(0.0, 0.95));
        }
    }

    /// The shortest bit is one of this rate.
    fn fastest(&self) -> f64 {
        if self.switches() { self.data_bitrate } else { self.bitrate }
    }

    fn switches(&self) -> bool {
        matches!(self.frame.kind(), FrameKind::Fd { brs: true, .. })
    }

    /// Ticks of the shortest bit.
    pub fn ticks_per_bit(&self) -> f64 {
        self.timer_hz / self.fastest() * (1.0 + self.clock_error_ppm * 1e-6)
    }

    /// Standard deviation of the time stamp of an edge, in ticks: the quantisation and the jitter.
    pub fn edge_noise(&self) -> f64 {
        let jitter = self.jitter_ns * 1e-9 * self.timer_hz;
        (1.0 / 12.0 + jitter * jitter).sqrt()
    }

    fn clock(&self) -> BitClock {
        let tick = self.timer_hz * (1.0 + self.clock_error_ppm * 1e-6);
        BitClock {
            nominal: tick / self.bitrate,
            data: tick / self.data_bitrate,
            nominal_sample_point: self.sample_point,
            data_sample_point: self.data_sample_point,
        }
    }

    /// What a perfect detector would say.
    pub fn truth(&self) -> Truth {
        if self.foreign.is_some() {
            return Truth::Foreign;
        }
        let clock = self.clock();
        let data = match self.frame.kind() {
            FrameKind::Data | FrameKind::Remote => TrueData::Classic,
            FrameKind::Fd { brs: false, .. } => TrueData::NeverSwitched,
            FrameKind::Fd { brs: true, .. } => TrueData::Switched(clock.data),
        };
        Truth::Bus { nominal: clock.nominal, data, polarity: self.polarity }
    }

    /// Plays and records.
    pub fn record(&self) -> Recording {
        let mut prng = self.prng.clone();
        let clock = self.clock();
        let bit = clock.nominal;
        let mut player = Player::new();
        player.idle(self.phase);
        let mut window = (0.0, 0.0);
        if let Some(kind) = self.foreign {
            player.idle(self.idle_before_bits * bit);
            foreign::play(&mut player, kind, bit, &mut prng);
            player.idle(self.idle_after_bits * bit);
            window.1 = player.now;
        } else {
            window.0 = self.play_before(&mut player, &clock);
            self.play_frame(&mut player, &clock);
            window.1 = self.play_after(&mut player, &clock);
        }
        let glitches = self.draw_glitches(&mut prng, window);
        let tick = self.timer_hz * 1e-9;
        let recorder = Recorder {
            capture: self.capture,
            polarity: self.polarity,
            asymmetry: self.asymmetry_ns * tick,
            jitter: self.jitter_ns * tick,
            window,
            epoch: self.epoch,
        };
        recorder.record(&player.intervals, &glitches, &mut prng)
    }

    /// What precedes the frame; the start of the recording.
    fn play_before(&self, player: &mut Player, clock: &BitClock) -> f64 {
        let bit = clock.nominal;
        let mut from = 0.0;
        if let Some(fraction) = self.cut_before {
            let start = player.now;
            let whole = self.neighbour_ends(clock);
            player.frame(&encode(&self.neighbour, self.fd_crc), clock, self.acknowledged(), None);
            from = start + fraction * whole;
            player.idle(3.0 * bit);
        }
        player.idle(self.idle_before_bits * bit);
        if let Some(how) = self.destroyed {
            player.destroyed(&encode(&self.frame, self.fd_crc), clock, how);
            player.idle(3.0 * bit);
        }
        player.untag(0);
        from
    }

    fn play_frame(&self, player: &mut Player, clock: &BitClock) {
        let encoded = encode(&self.frame, self.fd_crc);
        for attempt in 0..self.attempts {
            if attempt > 0 {
                player.idle(3.0 * clock.nominal);
            }
            player.frame(&encoded, clock, self.ack, self.contender);
        }
    }

    /// What follows the frame; the end of the recording.
    fn play_after(&self, player: &mut Player, clock: &BitClock) -> f64 {
        player.idle(self.idle_after_bits * clock.nominal);
        let Some(fraction) = self.cut_after else {
            return player.now;
        };
        let first = player.intervals.len();
        let start = player.now;
        player.frame(&encode(&self.neighbour, self.fd_crc), clock, self.acknowledged(), None);
        player.untag(first);
        start + fraction * self.neighbour_ends(clock)
    }

    /// The other frames of a recording are acknowledged, whoever sends them.
    fn acknowledged(&self) -> Ack {
        match self.ack {
            Ack::Silent | Ack::ErrorFlag => Ack::Given { delay: 0.05, longer: 0.05 },
            given @ Ack::Given { .. } => given,
        }
    }

    /// Ticks from SOF to the CRC delimiter of the neighbour.
    fn neighbour_ends(&self, clock: &BitClock) -> f64 {
        let encoded: EncodedFrame = encode(&self.neighbour, self.fd_crc);
        match encoded.brs {
            Some(brs) => {
                brs as f64 * clock.nominal + (encoded.crc_delimiter - brs) as f64 * clock.data
            }
            None => encoded.crc_delimiter as f64 * clock.nominal,
        }
    }

    fn draw_glitches(&self, prng: &mut Prng, window: (f64, f64)) -> Vec<Glitch> {
        let tick = self.timer_hz * 1e-9;
        (0..self.glitches)
            .map(|_| Glitch {
                at: prng.uniform(window.0, window.1),
                width: prng.uniform(0.2, 1.0) * self.glitch_ns * tick,
            })
            .collect()
    }
}

fn bitrate(prng: &mut Prng, family: Family) -> f64 {
    let least = match family {
        Family::Classic => 5_000.0,
        Family::Fd => 100_000.0,
    };
    if prng.chance(0.15) {
        return prng.uniform(f64::ln(least), f64::ln(1e6)).exp();
    }
    loop {
        let rate = prng.pick(&RATES);
        if rate >= least {
            return rate;
        }
    }
}

fn clock_error(prng: &mut Prng) -> f64 {
    if prng.chance(0.5) {
        prng.uniform(-5000.0, 5000.0)
    } else {
        prng.pick(&[0.0, -3000.0, 3000.0, -5000.0, 5000.0])
    }
}

fn ack(prng: &mut Prng) -> Ack {
    if prng.chance(0.5) {
        Ack::Silent
    } else {
        Ack::Given { delay: prng.uniform(0.0, 0.2), longer: prng.uniform(0.0, 0.3) }
    }
}
