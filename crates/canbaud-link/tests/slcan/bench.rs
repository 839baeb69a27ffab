//! A simulated bus behind a pty, in real time, and a scan on it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use canbaud::detect::scan::{Candidates, Driver, Outcome, Progress, Scan, Settings};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_link::slcan::{SilentMode, SlcanListener};
use canbaud_link::{Clock, LinkError, Listener};
use canbaud_sim::slcan::SilentMode as M1;
use canbaud_sim::slcan::{Adapter, Entry, ErrorReports, Firmware, Pty};
use canbaud_sim::{Blind, Mode, NodeConfig, Simulation, Span, Stop};

/// What a bench is made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    pub(crate) bitrate: u32,
    pub(crate) firmware: Firmware,
    pub(crate) reports: Option<ErrorReports>,
    pub(crate) m1: M1,
    /// Between two frames.
    pub(crate) period: Span,
    /// How long the adapter takes for each thing it says.
    pub(crate) delay: Duration,
    /// The adapter is unplugged then.
    pub(crate) unplug_after: Option<Duration>,
}

impl Setup {
    pub(crate) const fn at(bitrate: u32) -> Self {
        Self {
            bitrate,
            firmware: Firmware::Lawicel,
            reports: None,
            m1: M1::Honoured,
            period: Span::from_ms(if bitrate < 50_000 { 40 } else { 6 }),
            delay: Duration::ZERO,
            unplug_after: None,
        }
    }
}

/// A running bus.
pub(crate) struct Bench {
    pub(crate) port: String,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Vec<Entry>>,
}

impl Bench {
    pub(crate) fn start(setup: Setup) -> Self {
        let pty = Pty::open().unwrap();
        let port = pty.path().to_str().unwrap().to_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || serve(setup, &pty, &stopped));
        Self { port, stop, thread }
    }

    /// Ends it, and gives everything that the adapter was told and did.
    pub(crate) fn log(self) -> Vec<String> {
        self.stop.store(true, Ordering::Relaxed);
        let entries = self.thread.join().unwrap();
        // Without the time.
        entries.iter().map(|one| one.to_string().split_once(' ').unwrap().1.to_owned()).collect()
    }
}

fn serve(setup: Setup, pty: &Pty, stop: &AtomicBool) -> Vec<Entry> {
    let mut sim = Simulation::new(7);
    let node = |name: &str| NodeConfig::at(name, setup.bitrate).unwrap();
    let talker = sim.add_node(node("talker")).unwrap();
    sim.add_node(node("partner")).unwrap();
    let config = node("adapter");
    let id = sim.add_node(config.clone().with_mode(Mode::Disabled)).unwrap();
    sim.watch(id);
    let mut adapter = Adapter::new(id, config, setup.firmware).with_silent_mode(setup.m1);
    if let Some(reports) = setup.reports {
        adapter = adapter.with_error_reports(reports);
    }
    let began = Instant::now();
    let mut next = sim.now() + Span::from_us(100);
    let mut count = 0_u8;
    let gone = |now: Instant| setup.unplug_after.is_some_and(|after| now >= began + after);
    while !gone(Instant::now()) {
        // What was written before the end is read before the end.
        let ends = stop.load(Ordering::Relaxed);
        pty.wait(Duration::from_millis(1)).unwrap();
        let mut bytes = [0; 4096];
        let read = pty.read(&mut bytes).unwrap();
        if ends && read == 0 {
            break;
        }
        if read > 0 {
            std::thread::sleep(setup.delay);
            adapter.command(&bytes[..read], &mut sim);
        }
        let elapsed = u64::try_from(began.elapsed().as_micros()).unwrap();
        let until = canbaud_sim::Time::ZERO + Span::from_us(elapsed);
        while next < until {
            count = count.wrapping_add(1);
            let data = [0x55, count, !count, 0x0F];
            let frame = Frame::new(Id::Base(0x155), FrameKind::Data, 4, &data).unwrap();
            sim.send_at(next.max(sim.now()), talker, frame);
            next += setup.period;
        }
        while sim.run(until.max(sim.now()), &mut Blind) != Stop::Reached {
            for (at, _, event) in sim.take_news() {
                adapter.notice(at, &event, &sim);
            }
        }
        for (at, _, event) in sim.take_news() {
            adapter.notice(at, &event, &sim);
        }
        let output = adapter.take_output();
        let mut rest = &output[..];
        while !rest.is_empty() && !gone(Instant::now()) {
            rest = &rest[pty.write(rest).unwrap()..];
        }
    }
    adapter.take_log()
}

/// Scans the CANopen rates, or these.
pub(crate) fn scan(
    listener: &mut dyn Listener,
    clock: Clock,
    rates: &[u32],
) -> Result<Outcome, LinkError> {
    let candidates: Candidates<16> = if rates.is_empty() {
        Candidates::canopen().unwrap()
    } else {
        let rates: Vec<_> = rates.iter().map(|rate| Bitrate::new(*rate).unwrap()).collect();
        Candidates::of_rates(&rates).unwrap()
    };
    // The traffic of these benches pauses for 40 ms at most.
    let settings = Settings { pause: Micros::from_ms(150), ..Settings::default() };
    let scan: Scan<16> = Scan::new(&candidates, &listener.capabilities(), settings);
    let mut driver = Driver::new(listener, scan, |_: &&mut dyn Listener| clock.now());
    loop {
        match driver.turn()? {
            Progress::Done(outcome) => return Ok(outcome),
            Progress::Listening(until) => {
                let left = until.map_or(20_000, |at| (at - clock.now()).0).min(20_000);
                driver.controller_mut().wait(Duration::from_micros(left))?;
            }
        }
    }
}

/// The rate that a scan of the bench finds, and what the adapter was told and did.
pub(crate) fn find(setup: Setup, rates: &[u32]) -> (Option<u32>, Vec<String>) {
    let bench = Bench::start(setup);
    let clock = Clock::start();
    let trust = SilentMode::Trusted;
    let mut listener = SlcanListener::open(&bench.port, 115_200, trust, clock).unwrap();
    let outcome = scan(&mut listener, clock, rates).unwrap();
    listener.restore().unwrap();
    drop(listener);
    let found = match outcome {
        Outcome::Found(found) => Some(found.nominal().bits_per_second()),
        _ => None,
    };
    (found, bench.log())
}

/// Nothing was sent, nothing but listening was opened, and the channel is closed in the end.
#[track_caller]
pub(crate) fn assert_silent(log: &[String]) {
    for line in log {
        let bad = line.starts_with('!') || line.ends_with(": sent") || line.contains("open normal");
        assert!(!bad, "{line} in {log:#?}");
    }
    let last = log.iter().rev().find(|line| !line.contains(": refused")).unwrap();
    assert_eq!(last, "C: closed", "{log:#?}");
}
