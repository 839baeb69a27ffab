//! The timer method: a recorded bus goes through a model of an input-capture timer and its
//! interrupt into the pulse detector; then the bit timing for bxCAN is worked out.
//!
//! The interrupt only stores the time and polarity of an edge. The main loop takes them, makes 64-bit
//! ticks of the times and feeds the detector: this is the split that a real board has, too.
#![no_std]
#![no_main]

use canbaud::detect::{PulseDetector, Verdict};
use canbaud::rates;
use canbaud::timing::controllers::{Configuration, bxcan};
use canbaud::timing::{Request, solve};
use canbaud::units::{Bitrate, Hertz, Timebase};
use canbaud_firmware::console::{self, Status, print, print_hex, print_number};
use canbaud_firmware::recordings::{RECORDINGS, Recording};
use canbaud_firmware::timer::{CaptureQueue, CaptureTimer, Recorder};
use cortex_m_rt::entry;

/// What the interrupt writes and the main loop reads.
static QUEUE: CaptureQueue<64> = CaptureQueue::new();

#[entry]
fn main() -> ! {
    let mut status = Status::Ok;
    for recording in RECORDINGS.iter().filter(|recording| recording.verdict == "found") {
        // Runs of more than a classic frame have no room here.
        if recording.edges.len() <= 160 && !run(recording) {
            status = Status::Failed;
        }
    }
    console::exit(status)
}

fn run(recording: &Recording) -> bool {
    let mut detector = PulseDetector::<160>::new();
    let mut timer = CaptureTimer::new(recording.initial, recording.edges);
    QUEUE.clear();
    let mut recorder = Recorder::new(0);
    // The interrupt comes whenever it wants; here, some edges before the main loop looks.
    while timer.interrupt(&QUEUE, 7) {
        recorder.take(&QUEUE, &mut detector);
    }
    detector.finish(recording.end);
    report(recording, &detector.verdict())
}

fn report(recording: &Recording, verdict: &Verdict) -> bool {
    print(recording.name);
    let Verdict::Found(found) = verdict else {
        print(": not found\n");
        return false;
    };
    let timer = Hertz::new(recording.timebase_hz).map(Timebase::from_frequency);
    let measured = timer.and_then(|timer| found.nominal.millibits_per_second(timer)).unwrap_or(0);
    // The rate that is meant, where the measurement leaves only one in use.
    let known = rates::nearest(rates::nominal(), measured, found.nominal.uncertainty_ppb);
    let rate = known.map_or(measured, |known| known.millibits_per_second());
    print(": ");
    print_number(rate / 1000);
    print(" bit/s, proof ");
    print_number(u64::from(found.proof_bits));
    print(" bits");
    match register(rate) {
        Some(word) => {
            print(", bxCAN at 36 MHz: BTR ");
            print_hex(word);
        }
        None => print(", bxCAN at 36 MHz cannot"),
    }
    print("\n");
    recording.expects(verdict)
}

/// BTR of bxCAN for a rate in thousandths of a bit/s, from 36 MHz.
fn register(millibits: u64) -> Option<u32> {
    let bitrate = Bitrate::new(u32::try_from((millibits + 500) / 1000).ok()?)?;
    let request = Request::new(Hertz::new(36_000_000)?, bitrate);
    let solution = solve(&request, &bxcan::NOMINAL).ok()?;
    bxcan::BTR.pack(&Configuration::classic(solution.timing)).ok()
}
