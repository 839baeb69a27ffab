//! The listen-only scan with a controller in memory, for each rate of CANopen, and what a step of it
//! costs.
#![no_std]
#![no_main]

use canbaud::detect::scan::{Candidates, Controller, Driver, Outcome, Progress, Scan, Settings};
use canbaud::node::Settings as NodeSettings;
use canbaud::units::{Bitrate, Micros};
use canbaud_firmware::board::Counter;
use canbaud_firmware::bus::MemoryController;
use canbaud_firmware::console::{self, Status, print, print_number, print_pair};
use canbaud_firmware::stack;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let counter = Counter::new();
    let (mut status, mut most, mut steps, mut total) = (Status::Ok, 0, 0, 0);
    for &rate in NodeSettings::CANOPEN_RATES {
        let (found, depth) = stack::measure(|| {
            scan(rate, &counter, &mut |cost| {
                most = most.max(cost);
                total += cost;
                steps += 1;
            })
        });
        most_stack(depth);
        if found != Some(rate) {
            print("not found: ");
            print_number(u64::from(rate.bits_per_second()));
            print("\n");
            status = Status::Failed;
        }
    }
    print_pair("scan_ram_bytes", size_of::<Scan<8>>() as u64);
    print_pair("scan_stack_bytes", most_stack(0) as u64);
    print_pair("scan_step_mean", total / u64::max(steps, 1));
    print_pair("scan_step_max", most);
    console::exit(status)
}

/// The deepest stack so far.
fn most_stack(depth: usize) -> usize {
    use core::sync::atomic::{AtomicUsize, Ordering};
    static MOST: AtomicUsize = AtomicUsize::new(0);
    let most = MOST.load(Ordering::Relaxed).max(depth);
    MOST.store(most, Ordering::Relaxed);
    most
}

fn scan(bus: Bitrate, counter: &Counter, step: &mut dyn FnMut(u64)) -> Option<Bitrate> {
    let controller = MemoryController::new(bus);
    let candidates = Candidates::<8>::canopen().ok()?;
    let scan = Scan::new(&candidates, &controller.capabilities(), Settings::default());
    // A clock that goes on by a quarter of a millisecond each time it is looked at.
    let mut now = 0;
    let mut driver = Driver::new(controller, scan, |_: &MemoryController| {
        now += 250;
        Micros(now)
    });
    for _ in 0..1_000_000 {
        let (progress, cost) = counter.count(|| driver.turn());
        step(cost);
        match progress {
            Ok(Progress::Done(Outcome::Found(found))) => return Some(found.nominal()),
            Ok(Progress::Listening(_)) => {}
            Ok(Progress::Done(_)) | Err(_) => return None,
        }
    }
    None
}
