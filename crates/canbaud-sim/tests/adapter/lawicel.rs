//! The command set of the CAN232 manual.

use canbaud_sim::slcan::Firmware;
use canbaud_sim::{Blind, Span, Time};

use crate::bus::at;

#[test]
fn commands_of_the_can232_manual_get_its_answers() {
    let mut bus = at(250_000, Firmware::Lawicel);
    assert_eq!(bus.says("V v N"), "V1013;vcanbaud;NCB01;");
    // Nothing opens without a rate; F, P, t and C need an open channel.
    assert_eq!(bus.says("O F P t1230 C"), "!!!!!");
    assert_eq!(bus.says("S5 O"), ";;");
    // Settings are refused while it is open, opening twice is, too; python-can does not care.
    assert_eq!(bus.says("S5 s031C O L X1 Z1 M00000000"), "!!!!!!!");
    assert_eq!(bus.says("F"), "F00;");
    assert_eq!(bus.says("C C"), ";!");
    assert_eq!(bus.says("S S10 S9 s12 sZZZZ Y2 t tXYZ Q Zx q d1230"), "!!!!!!!!!!!!");
    assert_eq!(bus.says(" s031C Z1 X1 W0 Q1 U1"), ";;;;;;;");
    bus.adapter.command(&[b'T'; 5_000], &mut bus.sim);
    assert_eq!(bus.says(""), "!");
    bus.adapter.command(&[0xFF, 0xFE, b'\r'], &mut bus.sim);
    assert_eq!(bus.output(), "!");
}

#[test]
fn open_channel_sends_and_receives() {
    let mut bus = at(250_000, Firmware::Lawicel);
    assert_eq!(bus.says("S5 O"), ";;");
    bus.run_ms(1);
    assert_eq!(bus.says("t12332A2B2C T1ABCDEF00 r1234"), "z;Z;z;");
    bus.talk(1);
    assert_eq!(bus.run_ms(5), "t1233DEAD00;");
    assert_eq!(bus.sim.node(bus.adapter.node()).pending(), 0);
}

#[test]
fn listen_only_is_honoured_and_refuses_to_send() {
    for rate in ["S5", "S6", "S8", "S4"] {
        let mut bus = at(250_000, Firmware::Lawicel);
        assert_eq!(bus.says(&format!("{rate} L t1230")), ";;!");
        bus.talk(30);
        bus.run_ms(40);
        assert_eq!(bus.dominant, 0, "{rate}");
        assert_eq!(bus.sim.node(bus.talkers[0]).fault().tec(), 0);
    }
}

#[test]
fn time_stamps_count_milliseconds_of_a_minute() {
    let mut bus = at(250_000, Firmware::Lawicel);
    bus.sim.run(Time::ZERO + Span::from_ms(59_998), &mut Blind);
    assert_eq!(bus.says("S5 Z1 L"), ";;;");
    bus.talk(3);
    // 59.998 s + 0.5 ms + 68 bits of 4 us, then one and two ms later.
    assert_eq!(bus.run_ms(5), "t1233DEAD00EA5E;t1233DEAD01EA5F;t1233DEAD020000;");
}

#[test]
fn polling_hands_out_one_or_all() {
    let mut bus = at(250_000, Firmware::Lawicel);
    assert_eq!(bus.says("S5 X0 L"), ";;;");
    bus.talk(3);
    assert_eq!(bus.run_ms(10), "");
    assert_eq!(bus.says("P A P F"), "t1233DEAD00;t1233DEAD01;t1233DEAD02;A;;F00;");
    bus.talk(40);
    bus.run_ms(60);
    // 32 fit; receive FIFO full and data overrun.
    assert_eq!(bus.says("F"), "F09;");
}

#[test]
fn filter_lets_matching_identifiers_through() {
    let mut bus = at(250_000, Firmware::Lawicel);
    assert_eq!(bus.says("S5 M24800000 m001FFFFF L"), ";;;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "");
    assert_eq!(bus.says("C M24600000 L"), ";;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "t1233DEAD00;");
}
