use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;
use crate::socketcan::mock::{CHOSEN, Mock};

fn listener(kernel: &Mock) -> SocketCanListener {
    let kernel = Box::new(kernel.clone());
    SocketCanListener::on(kernel, Path::new("/nonexistent"), "can0", Clock::start()).unwrap()
}

fn at(bits_per_second: u32) -> Candidate {
    Candidate::classic(Bitrate::new(bits_per_second).unwrap())
}

#[test]
fn a_panic_leaves_the_interface_as_it_was_found() {
    let kernel = Mock::up(CHOSEN);
    let found = kernel.now();
    let mut listener = listener(&kernel);
    let broken = catch_unwind(AssertUnwindSafe(move || {
        listener.configure(&at(500_000)).unwrap();
        // The unwinding is what is looked at, not its message.
        std::panic::resume_unwind(Box::new(listener.link.can.clone()));
    }));
    assert!(broken.is_err());
    assert_eq!(kernel.now(), found);
    assert_eq!(kernel.up_at(), [(250_000, false)]);
}

#[test]
fn while_it_is_set_up_it_is_down_and_listens() {
    let kernel = Mock::up(CHOSEN);
    let mut listener = listener(&kernel);
    let set = listener.configure(&at(500_000)).unwrap();
    assert_eq!(set.nominal.bits_per_second(), 500_000);
    let now = kernel.now();
    assert!(!now.flags.is_up());
    let mode = ctrlmode::LISTEN_ONLY | ctrlmode::BERR_REPORTING;
    assert_eq!(now.can.unwrap().ctrlmode, mode);
}

#[test]
fn what_cannot_be_put_back_is_said_and_stays_down() {
    let kernel = Mock::up(CHOSEN);
    let mut listener = listener(&kernel);
    listener.configure(&at(500_000)).unwrap();
    kernel.refuse(250_000);
    let error = listener.restore().unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("can0 could not be put back as it was found"), "{text}");
    // At a wrong rate and in normal mode it would disturb the bus.
    assert!(!kernel.now().flags.is_up());
    assert_eq!(
        listener.by_hand().unwrap(),
        "ip link set can0 down; ip link set can0 type can bitrate 250000 sample-point 0.750 sjw 3 \
         listen-only off berr-reporting off; ip link set can0 up"
    );
}

#[test]
fn nothing_is_touched_before_the_scan() {
    let kernel = Mock::up(CHOSEN);
    let found = kernel.now();
    let mut listener = listener(&kernel);
    assert!(listener.restore().is_ok());
    drop(listener);
    assert_eq!((kernel.now(), kernel.up_at()), (found, Vec::new()));
}
