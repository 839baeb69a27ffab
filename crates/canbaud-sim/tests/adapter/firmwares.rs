//! Each firmware by its documents.

use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_sim::slcan::{Firmware, SilentMode};
use canbaud_sim::{Mode, NodeConfig, Retransmission};

use crate::bus::{Bus, at, of};
use crate::common::data;

/// How each firmware is opened listen-only at its S5.
const LISTEN: [(Firmware, &str); 5] = [
    (Firmware::Lawicel, "S5 L"),
    (Firmware::Canable1, "S5 M1 O"),
    (Firmware::Canable2, "S5 L"),
    (Firmware::Canable2Stock, "S5 M1 O"),
    (Firmware::Usbtin, "S5 L"),
];

fn mode(bus: &Bus) -> Mode {
    bus.sim.node(bus.adapter.node()).config().mode
}

#[test]
fn every_firmware_hears_the_bus_in_silence() {
    for (firmware, commands) in LISTEN {
        let mut bus = at(250_000, firmware);
        bus.says(commands);
        bus.talk(2);
        assert_eq!(bus.run_ms(5), "t1233DEAD00;t1233DEAD01;", "{firmware:?}");
        assert_eq!(bus.dominant, 0, "{firmware:?}");
        let log = bus.log();
        assert_eq!(log.last().unwrap().rsplit(' ').next(), Some("listen-only"), "{log:?}");
    }
}

#[test]
fn firmwares_of_the_maker_of_canable_answer_nothing() {
    for (firmware, name) in
        [(Firmware::Canable1, "canable-fw"), (Firmware::Canable2Stock, "canable2-fw")]
    {
        let mut bus = at(250_000, firmware);
        assert_eq!(bus.says(" S5 S9 s031C L F N Z1 X1 W0 t1230 O t1230 O C C Sx"), "");
        let version = bus.says("V");
        assert!(!version.starts_with('V') && version.contains(name), "{version}");
        assert_eq!(bus.adapter.open_mode(), None);
        let log = bus.log();
        let count = |what: &str| log.iter().filter(|line| line.ends_with(what)).count();
        assert_eq!(count("L: refused") + count("F: refused") + count("s031C: refused"), 3);
        assert_eq!((count("open normal"), count("sent"), count("closed")), (1, 1, 1), "{log:?}");
    }
}

#[test]
fn canable1_keeps_its_rate_when_s9_is_asked_for() {
    let mut bus = at(250_000, Firmware::Canable1);
    bus.says("S5 S9 M1 O");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "t1233DEAD00;");
}

#[test]
fn m1_makes_canable_silent_until_it_is_set_otherwise() {
    for (commands, want) in [
        ("M1 O", Mode::BusMonitoring),
        ("O", Mode::Normal),
        ("M1 M0 O", Mode::Normal),
        // The acceptance code of Lawicel ends silent mode.
        ("M1 M00000000 O", Mode::Normal),
        ("O M1", Mode::Normal),
    ] {
        for firmware in [Firmware::Canable1, Firmware::Canable2Stock] {
            let mut bus = at(250_000, firmware);
            bus.says(commands);
            bus.run_ms(1);
            assert_eq!(mode(&bus), want, "{firmware:?} {commands}");
        }
    }
    let mut bus = at(250_000, Firmware::Canable1);
    bus.says("m1 O");
    assert_eq!(bus.adapter.open_mode(), Some(Mode::BusMonitoring));
}

#[test]
fn m1_that_is_ignored_opens_in_normal_mode() {
    let mut bus = at(250_000, Firmware::Canable1);
    bus.adapter = bus.adapter.with_silent_mode(SilentMode::Ignored);
    bus.says("S6 M1 O");
    bus.talk(10);
    bus.run_ms(15);
    assert!(bus.dominant > 10);
    assert!(bus.log().iter().any(|line| line == "! error flag on the bus"));
    assert!(bus.sim.node(bus.talkers[0]).fault().tec() > 0);
}

#[test]
fn a0_is_one_shot_and_a1_is_not() {
    for (commands, want) in [
        ("O", Retransmission::Automatic),
        ("A0 O", Retransmission::OneShot),
        ("A0 A1 O", Retransmission::Automatic),
    ] {
        let mut bus = at(250_000, Firmware::Canable2Stock);
        bus.says(commands);
        bus.run_ms(1);
        assert_eq!(bus.sim.node(bus.adapter.node()).config().retransmission, want, "{commands}");
    }
}

#[test]
fn canable2_answers_as_its_document_says() {
    let mut bus = at(125_000, Firmware::Canable2);
    assert_eq!(bus.says("V I N"), "VL2K1;I30A0;N0000;");
    assert_eq!(
        bus.says("i"),
        "i: protocol=\"ISO-CANFD\", clock_mhz=160, controller=\"STM32G431CB\";"
    );
    // No S9, Y3, P, A, X, U, E; W0 and W1 not either; C and F and Q need an open channel.
    assert_eq!(bus.says("S9 Y3 P A A0 X1 U1 E W0 W1 C F f Q1 M1"), "!!!!!!!!!!!!!!!");
    // The example of the document is 125 kbit/s; that is also what it starts with.
    assert_eq!(bus.says("s10460908 y021E0908 W2 Z0 L"), ";;;;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(5), "t1233DEAD00;");
    assert_eq!(bus.says("S4 O Q0 F t1230 C L C"), "!!;F00;!;;;");
}

#[test]
fn canable2_confirms_frames_at_once_or_when_they_went_out() {
    let mut bus = at(250_000, Firmware::Canable2);
    assert_eq!(bus.says("S5 O"), ";;");
    bus.run_ms(1);
    assert_eq!(bus.says("t1231AA T000001230"), "z;Z;");
    assert_eq!(bus.run_ms(5), "");
    // Reports: received and sent frames with ESI.
    assert_eq!(bus.says("C z0013 O"), ";;;");
    bus.run_ms(1);
    assert_eq!(bus.says("t1231AA D000001230"), ";;");
    bus.talk(1);
    assert_eq!(bus.run_ms(5), "zt1231AA;ZD0000012300;t1233DEAD00;");
    assert_eq!(bus.says("C z0002 O"), ";;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(5), "");
}

#[test]
fn canable2_tells_microseconds_of_an_hour() {
    let mut bus = at(250_000, Firmware::Canable2);
    assert_eq!(bus.says("S5 Z2 L Z0 Z3"), ";;;!!");
    bus.run_ms(10);
    bus.talk(1);
    let frame = bus.run_ms(5);
    let stamp = u32::from_str_radix(&frame.trim_end_matches(';')["t1233DEAD00".len()..], 16);
    // 10 ms, half a millisecond, and the frame: 67 bits up to the last but one of EOF and at
    // most 12 stuff bits, of 4 us each.
    let us = stamp.unwrap() - 10_500;
    assert!((67 * 4..=79 * 4).contains(&us), "{frame}");
}

#[test]
fn canable2_filters_by_identifier() {
    let mut bus = at(250_000, Firmware::Canable2);
    assert_eq!(bus.says("S5 M80000124 m00000000 L"), ";;;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "");
    assert_eq!(bus.says("C M80000123 L"), ";;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "t1233DEAD00;");
}

#[test]
fn stock_canable2_reaches_83_kbit_s_and_ends_its_error_register_without_a_line_end() {
    let mut bus = at(83_333, Firmware::Canable2Stock);
    assert_eq!(bus.says("S9 M1 O"), "");
    bus.sim.send_at(bus.sim.now(), bus.talkers[0], data(0x7FF, &[1]));
    assert_eq!(bus.run_ms(5), "t7FF101;");
    assert_eq!(bus.says("E"), "CANable Error Register: 0");
}

#[test]
fn can_fd_frames_go_both_ways() {
    for firmware in [Firmware::Canable2, Firmware::Canable2Stock] {
        let mut bus = at(500_000, firmware);
        bus.says("S6 Y2 O");
        bus.run_ms(1);
        bus.says("d1239000102030405060708090A0B B000000011AA");
        bus.run_ms(2);
        assert_eq!(bus.sim.node(bus.adapter.node()).pending(), 0, "{firmware:?}");
        let kind = FrameKind::Fd { brs: true, esi: false };
        let frame = Frame::new(Id::Base(1), kind, 1, &[7]).unwrap();
        bus.sim.send_at(bus.sim.now(), bus.talkers[0], frame);
        assert_eq!(bus.run_ms(5), "b001107;", "{firmware:?}");
    }
}

#[test]
fn classic_controllers_see_can_fd_as_errors() {
    for firmware in [Firmware::Lawicel, Firmware::Canable1, Firmware::Usbtin] {
        let mut bus = at(250_000, firmware);
        let (_, commands) = LISTEN.into_iter().find(|(of, _)| *of == firmware).unwrap();
        bus.says(commands);
        let kind = FrameKind::Fd { brs: true, esi: false };
        let frame = Frame::new(Id::Base(1), kind, 8, &[0x55; 8]).unwrap();
        bus.sim.send_at(bus.sim.now(), bus.talkers[0], frame);
        assert_eq!(bus.run_ms(5), "", "{firmware:?}");
        let error = matches!(firmware, Firmware::Lawicel);
        let flags = bus.says("F");
        assert_eq!(flags == "F80;", error, "{firmware:?} {flags}");
    }
}

#[test]
fn usbtin_takes_registers_of_the_mcp2515() {
    // 24 MHz / 2 / 12 / 12 quanta.
    let mut bus = of(NodeConfig::at("talker", 83_333).unwrap(), Firmware::Usbtin);
    assert_eq!(bus.says("V v N F"), "V0100;v0108;NFFFF;F00;");
    assert_eq!(bus.says(" s0B9B s0B9B02 L"), "!!;;");
    bus.sim.send_at(bus.sim.now(), bus.talkers[0], data(0x7FF, &[1]));
    assert_eq!(bus.run_ms(5), "t7FF101;");
    assert_eq!(bus.says("S5 O t1230 C C Z1 Y2 X0"), "!!!;!;!!");
    assert_eq!(bus.says("S5 O"), ";;");
    assert_eq!(bus.says("t1230 T000001230"), "z;Z;");
}

#[test]
fn usbtin_tells_its_states_unasked_after_f1() {
    let mut bus = at(250_000, Firmware::Usbtin);
    assert_eq!(bus.says("f1 f4 S6 O"), ";!;;");
    bus.talk(40);
    let told = bus.run_ms(60);
    // Warning, then error passive; nothing in between.
    assert_eq!(told, "F04;F24;");
    // States are not forgotten when they are read.
    assert_eq!(bus.says("F F"), "F24;F24;");
}
