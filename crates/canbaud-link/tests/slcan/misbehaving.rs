//! Adapters that go away, lie, babble or say nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use canbaud_link::slcan::{SilentMode, SlcanListener};
use canbaud_link::{Clock, LinkError};
use canbaud_sim::Span;
use canbaud_sim::slcan::Pty;

use crate::bench::{Bench, Setup, scan};

/// Nothing here may take longer, whatever the adapter does.
const LONGEST: Duration = Duration::from_secs(20);

/// An adapter that says `answer` to each command; `None` is unplugging.
struct Liar {
    port: String,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Vec<String>>,
}

impl Liar {
    fn start(mut answer: impl FnMut(&str) -> Option<Vec<u8>> + Send + 'static) -> Self {
        let pty = Pty::open().unwrap();
        let port = pty.path().to_str().unwrap().to_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut told = Vec::new();
            let mut line = Vec::new();
            while !stopped.load(Ordering::Relaxed) {
                pty.wait(Duration::from_millis(5)).unwrap();
                let mut bytes = [0; 512];
                let count = pty.read(&mut bytes).unwrap();
                for byte in &bytes[..count] {
                    if *byte != b'\r' {
                        line.push(*byte);
                        continue;
                    }
                    let command = String::from_utf8(std::mem::take(&mut line)).unwrap();
                    let said = answer(&command);
                    told.push(command);
                    let Some(said) = said else { return told };
                    let mut rest = &said[..];
                    while !rest.is_empty() && !stopped.load(Ordering::Relaxed) {
                        rest = &rest[pty.write(rest).unwrap()..];
                    }
                }
            }
            told
        });
        Self { port, stop, thread }
    }

    fn open(&self) -> Result<SlcanListener, LinkError> {
        SlcanListener::open(&self.port, 115_200, SilentMode::Refused, Clock::start())
    }

    fn told(self) -> Vec<String> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

#[test]
fn unplugged_in_mid_scan_is_an_error_and_no_hang() {
    for after in [400, 700] {
        let unplug_after = Some(Duration::from_millis(after));
        // Nobody talks: the scan goes on until the adapter is gone.
        let period = Span::from_ms(60_000);
        let bench = Bench::start(Setup { unplug_after, period, ..Setup::at(250_000) });
        let clock = Clock::start();
        let began = Instant::now();
        let opened = SlcanListener::open(&bench.port, 115_200, SilentMode::Refused, clock);
        let mut listener = opened.unwrap();
        let error = scan(&mut listener, clock, &[10_000, 20_000, 50_000]).unwrap_err();
        drop(listener);
        assert!(matches!(error, LinkError::Gone { .. }), "{error}");
        assert!(began.elapsed() < LONGEST);
        bench.log();
    }
}

#[test]
fn who_says_nothing_is_no_adapter() {
    let liar = Liar::start(|_| Some(Vec::new()));
    let error = liar.open().unwrap_err();
    assert!(matches!(error, LinkError::NoAnswer { .. }), "{error}");
    assert_eq!(liar.told(), ["C", "C", "V"]);
}

#[test]
fn who_confirms_everything_is_not_believed() {
    let liar = Liar::start(|_| Some(b"\r".to_vec()));
    let error = liar.open().unwrap_err();
    assert!(matches!(error, LinkError::NoListenOnly { .. }), "{error}");
    let told = liar.told();
    assert!(!told.iter().any(|command| command.starts_with(['L', 'O', 't'])), "{told:?}");
}

#[test]
fn who_has_no_listen_only_is_never_opened() {
    let liar = Liar::start(|command| {
        Some(match command {
            "V" => b"V0001\r".to_vec(),
            "L" | "v" | "N" | "#" => b"\x07".to_vec(),
            _ => b"\r".to_vec(),
        })
    });
    let clock = Clock::start();
    let mut listener = liar.open().unwrap();
    let error = scan(&mut listener, clock, &[]).unwrap_err();
    drop(listener);
    assert!(matches!(&error, LinkError::Refused { command, .. } if command == "L"), "{error}");
    let told = liar.told();
    assert!(!told.iter().any(|command| command.starts_with('O')), "{told:?}");
    assert_eq!(told.last().unwrap(), "C");
}

#[test]
fn garbage_and_floods_end_in_bounded_time() {
    // A frame of another id each, half a line, BEL, bytes of all values, in answer to anything.
    let liar = Liar::start(|command| {
        let mut said = Vec::new();
        for round in 0..40_u32 {
            said.extend(format!("t{:03X}1{:02X}\r", round, round).bytes());
            said.extend((0..=255_u8).filter(|byte| *byte != b'\r'));
        }
        said.extend(if command.is_empty() { b"\x07" } else { b"\r" });
        Some(said)
    });
    let began = Instant::now();
    let clock = Clock::start();
    if let Ok(mut listener) = liar.open() {
        // Whatever comes of it.
        let _ = scan(&mut listener, clock, &[125_000, 250_000]);
    }
    assert!(began.elapsed() < LONGEST, "{:?}", began.elapsed());
    let told = liar.told();
    assert!(!told.iter().any(|command| command.starts_with(['O', 't', 'T'])), "{told:?}");
}

#[test]
fn unplugged_while_it_is_asked_who_it_is() {
    for gone_at in ["C", "V", "N"] {
        let mut done = false;
        let liar = Liar::start(move |command| {
            done |= command == gone_at;
            let said = if command == "C" { "" } else { "V1013" };
            (!done).then(|| format!("{said}\r").into_bytes())
        });
        let error = liar.open().unwrap_err();
        assert!(matches!(error, LinkError::Gone { .. }), "{gone_at}: {error}");
        liar.told();
    }
}
