//! What goes over SPI, byte by byte, as the data sheet DS20001801 has it.

use canbaud::detect::scan::{Candidate, Controller, Observation};
use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud_mcp2515::{Error, Mcp2515};
use embedded_hal_mock::eh1::spi::{Mock, Transaction};

fn write(bytes: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(bytes.to_vec()),
        Transaction::transaction_end(),
    ]
}

fn write_register(register: u8, values: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(vec![0x02, register]),
        Transaction::write_vec(values.to_vec()),
        Transaction::transaction_end(),
    ]
}

fn read(head: &[u8], answer: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(head.to_vec()),
        Transaction::read_vec(answer.to_vec()),
        Transaction::transaction_end(),
    ]
}

/// CANSTAT (0Eh) with OPMOD in bits 7 to 5.
fn mode_is(status: u8) -> Vec<Transaction<u8>> {
    read(&[0x03, 0x0E], &[status])
}

/// BIT MODIFY of REQOP, bits 7 to 5 of CANCTRL (0Fh).
fn ask_mode(mode: u8) -> Vec<Transaction<u8>> {
    write(&[0x05, 0x0F, 0xE0, mode])
}

fn reset() -> Vec<Transaction<u8>> {
    [write(&[0xC0]), mode_is(0x80)].concat()
}

fn mega(hertz: u64) -> Hertz {
    Hertz::new(hertz * 1_000_000).expect("a frequency")
}

fn candidate(bits_per_second: u32) -> Candidate {
    Candidate::classic(Bitrate::new(bits_per_second).expect("a rate"))
}

/// 8 MHz: a time quantum is 2 x 1 / 8 MHz = 250 ns, 500 kbit/s are 8 of them: SYNC_SEG 1, PRSEG 2
/// (3), PHSEG1 1 (2), PHSEG2 1 (2). CNF2 has BTLMODE (bit 7), so PHSEG2 counts.
#[test]
fn half_a_megabit_from_eight_megahertz() {
    let traffic = [
        reset(),
        ask_mode(0x80),
        mode_is(0x80),
        write_register(0x28, &[0x01, 0x8A, 0x00]),
        read(&[0x03, 0x28], &[0x01, 0x8A, 0x00]),
    ];
    let mut spi = Mock::new(&traffic.concat());
    let mut controller = Mcp2515::new(spi.clone(), mega(8)).expect("it answers");
    let configured = controller.configure(&candidate(500_000)).expect("it can");
    assert_eq!(configured.nominal.bits_per_second(), 500_000);
    spi.done();
}

#[test]
fn listen_only_is_asked_for_and_read_back() {
    let empty = [0; 4];
    let traffic = [
        reset(),
        // Masks of 0.
        write_register(0x20, &[0; 8]),
        // Filters 0 to 2 and 3 to 5; EXIDE (bit 3 of SIDL) in every other one.
        write_register(0x00, &empty),
        write_register(0x04, &[0, 0x08, 0, 0]),
        write_register(0x08, &empty),
        write_register(0x10, &[0, 0x08, 0, 0]),
        write_register(0x14, &empty),
        write_register(0x18, &[0, 0x08, 0, 0]),
        // RXM 00 (only valid frames), BUKT; no interrupt, no flag.
        write_register(0x60, &[0x04]),
        write_register(0x70, &[0x00]),
        write_register(0x2B, &[0, 0, 0]),
        ask_mode(0x60),
        // The mode comes when the frame on the bus is over.
        mode_is(0x80),
        mode_is(0x60),
    ];
    let mut spi = Mock::new(&traffic.concat());
    let mut controller = Mcp2515::new(spi.clone(), mega(8)).expect("it answers");
    controller.start_monitoring().expect("it listens");
    spi.done();
}

#[test]
fn frames_errors_and_overflows_are_told() {
    let traffic = [
        reset(),
        read(&[0x03, 0x2C], &[0x00, 0x00]),
        // RX0IF: base format 0x123, DLC 2.
        read(&[0x03, 0x2C], &[0x01, 0x00]),
        read(&[0x90], &[0x24, 0x60, 0, 0, 2, 0xAA, 0x55, 0, 0, 0, 0, 0, 0]),
        // RX1IF: extended format 0x18DAF110, a remote frame.
        read(&[0x03, 0x2C], &[0x02, 0x00]),
        read(&[0x94], &[0xC6, 0xCA, 0xF1, 0x10, 0x40, 0, 0, 0, 0, 0, 0, 0, 0]),
        // MERRF, cleared alone.
        read(&[0x03, 0x2C], &[0x80, 0x00]),
        write(&[0x05, 0x2C, 0x80, 0x00]),
        // RX1OVR.
        read(&[0x03, 0x2C], &[0x03, 0x80]),
        write(&[0x05, 0x2D, 0xC0, 0x00]),
    ];
    let mut spi = Mock::new(&traffic.concat());
    let mut controller = Mcp2515::new(spi.clone(), mega(8)).expect("it answers");
    let mut observe = || controller.observe(Micros(7)).expect("it answers");
    assert_eq!(observe(), None);
    let Some(Observation::Frame(first)) = observe() else { panic!("a frame") };
    assert_eq!((first.frame.id().raw(), first.frame.data()), (0x123, &[0xAA, 0x55][..]));
    let Some(Observation::Frame(second)) = observe() else { panic!("a frame") };
    assert_eq!(second.frame.id().raw(), 0x18DA_F110);
    assert!(second.frame.id().is_extended() && second.frame.data().is_empty());
    assert!(matches!(observe(), Some(Observation::Error(_))));
    assert_eq!(observe(), Some(Observation::Lost));
    spi.done();
}

#[test]
fn a_rate_that_the_crystal_cannot_make_is_refused_before_anything_is_written() {
    let mut spi = Mock::new(&reset());
    let mut controller = Mcp2515::new(spi.clone(), mega(8)).expect("it answers");
    let refused = controller.configure(&candidate(1_000_000));
    assert_eq!(refused, Err(Error::Timing(candidate(1_000_000).nominal)));
    spi.done();
}

#[test]
fn registers_that_read_back_wrong_are_refused() {
    let traffic = [
        reset(),
        ask_mode(0x80),
        mode_is(0x80),
        write_register(0x28, &[0x01, 0x8A, 0x00]),
        read(&[0x03, 0x28], &[0xFF, 0xFF, 0xFF]),
    ];
    let mut spi = Mock::new(&traffic.concat());
    let mut controller = Mcp2515::new(spi.clone(), mega(8)).expect("it answers");
    let refused = controller.configure(&candidate(500_000));
    assert!(matches!(refused, Err(Error::ReadBack { read: [0xFF, 0xFF, 0xFF], .. })));
    spi.done();
}
