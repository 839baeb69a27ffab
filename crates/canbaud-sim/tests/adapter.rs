//! The slcan adapter: its commands, and what it says at a wrong rate in each of its three ways.

mod common;

use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_sim::slcan::{Adapter, Dialect, ErrorReports};
use canbaud_sim::{Blind, Mode, NodeConfig, NodeId, Simulation, Span, Stop, Time};
use common::{data, node};

/// A bus of 250 kbit/s with two talkers and an adapter.
struct Bus {
    sim: Simulation,
    adapter: Adapter,
    talkers: [NodeId; 2],
    dominant: u64,
}

struct Dominant<'a>(NodeId, &'a mut u64);

impl canbaud_sim::Observer for Dominant<'_> {
    fn txd(&mut self, _: Time, node: NodeId, level: canbaud::wire::Level) {
        *self.1 += u64::from(node == self.0 && level == canbaud::wire::Level::Dominant);
    }
}

fn bus(reports: ErrorReports) -> Bus {
    let mut sim = Simulation::new(1);
    let talkers = [0, 1].map(|_| sim.add_node(NodeConfig::at("t", 250_000).unwrap()).unwrap());
    let config = node("adapter").with_data_bitrate(2_000_000).unwrap();
    let id = sim.add_node(config.clone().with_mode(Mode::Disabled)).unwrap();
    sim.watch(id);
    Bus { sim, adapter: Adapter::new(id, config, Dialect::Lawicel, reports), talkers, dominant: 0 }
}

impl Bus {
    /// Commands separated by blanks; what the adapter answers, CR as `;` and BELL as `!`.
    fn says(&mut self, commands: &str) -> String {
        for command in commands.split(' ') {
            self.adapter.command(format!("{command}\r").as_bytes(), &mut self.sim);
        }
        self.output()
    }

    fn output(&mut self) -> String {
        String::from_utf8(self.adapter.take_output())
            .unwrap()
            .replace('\r', ";")
            .replace('\x07', "!")
    }

    fn run_ms(&mut self, ms: u64) -> String {
        let until = self.sim.now() + Span::from_ms(ms);
        loop {
            let mut observer = Dominant(self.adapter.node(), &mut self.dominant);
            let stop = self.sim.run(until, &mut observer);
            for (at, _, event) in self.sim.take_news() {
                self.adapter.notice(at, &event, &self.sim);
            }
            if stop == Stop::Reached {
                return self.output();
            }
        }
    }

    fn talk(&mut self, count: u64) {
        for n in 0..count {
            let at = self.sim.now() + Span::from_us(500 + 1_000 * n);
            self.sim.send_at(at, self.talkers[0], data(0x123, &[0xDE, 0xAD, n as u8]));
        }
    }
}

#[test]
fn commands_of_the_can232_manual_get_its_answers() {
    let mut bus = bus(ErrorReports::Records);
    assert_eq!(bus.says("V v N"), "V1013;vcanbaud;NCB01;");
    // Nothing opens without a rate; F, P, t and C need an open channel.
    assert_eq!(bus.says("O F P t1230 C"), "!!!!!");
    assert_eq!(bus.says("S5 O"), ";;");
    // Settings are refused while it is open, opening twice is, too; python-can does not care.
    assert_eq!(bus.says("S5 s031C O L X1 Z1 M00000000"), "!!!!!!!");
    assert_eq!(bus.says("F"), "F00;");
    assert_eq!(bus.says("C C"), ";!");
    assert_eq!(bus.says("S S10 S9 s12 sZZZZ Y3 t tXYZ Q Zx q"), "!!!!!!!!!!!");
    assert_eq!(bus.says(" s031C Y2 Z1 X1 W0 Q1 U1"), ";;;;;;;;");
    bus.adapter.command(&[b'T'; 5_000], &mut bus.sim);
    assert_eq!(bus.says(""), "!");
    bus.adapter.command(&[0xFF, 0xFE, b'\r'], &mut bus.sim);
    assert_eq!(bus.output(), "!");
}

#[test]
fn open_channel_sends_and_receives() {
    let mut bus = bus(ErrorReports::Records);
    assert_eq!(bus.says("S5 O"), ";;");
    bus.run_ms(1);
    assert_eq!(bus.says("t12332A2B2C T1ABCDEF00 r1234"), "z;Z;z;");
    bus.talk(1);
    assert_eq!(bus.run_ms(5), "t1233DEAD00;");
    assert_eq!(bus.sim.node(bus.adapter.node()).pending(), 0);
}

#[test]
fn can_fd_frames_go_both_ways() {
    let mut sim = Simulation::new(1);
    let config = || node("n").with_data_bitrate(2_000_000).unwrap();
    let peer = sim.add_node(config()).unwrap();
    let id = sim.add_node(config().with_mode(Mode::Disabled)).unwrap();
    sim.watch(id);
    let adapter = Adapter::new(id, config(), Dialect::Lawicel, ErrorReports::Records);
    let mut bus = Bus { sim, adapter, talkers: [peer, peer], dominant: 0 };
    assert_eq!(bus.says("S6 Y2 O"), ";;;");
    bus.run_ms(1);
    assert_eq!(bus.says("d1239000102030405060708090A0B B000000011AA"), "z;Z;");
    let frame = Frame::new(Id::Base(1), FrameKind::Fd { brs: true, esi: false }, 1, &[7]).unwrap();
    bus.sim.send_at(bus.sim.now(), peer, frame);
    assert_eq!(bus.run_ms(5), "b001107;");
    assert_eq!(bus.sim.node(id).pending(), 0);
}

#[test]
fn listen_only_is_honoured_and_refuses_to_send() {
    for rate in ["S5", "S6", "S8", "S4"] {
        let mut bus = bus(ErrorReports::Records);
        assert_eq!(bus.says(&format!("{rate} L t1230")), ";;!");
        bus.talk(30);
        bus.run_ms(40);
        assert_eq!(bus.dominant, 0, "{rate}");
        assert_eq!(bus.sim.node(bus.talkers[0]).fault().tec(), 0);
    }
}

#[test]
fn time_stamps_count_milliseconds_of_a_minute() {
    let mut bus = bus(ErrorReports::Silent);
    bus.sim.run(Time::ZERO + Span::from_ms(59_998), &mut Blind);
    assert_eq!(bus.says("S5 Z1 L"), ";;;");
    bus.talk(3);
    // 59.998 s + 0.5 ms + 68 bits of 4 us, then one and two ms later.
    assert_eq!(bus.run_ms(5), "t1233DEAD00EA5E;t1233DEAD01EA5F;t1233DEAD020000;");
}

#[test]
fn polling_hands_out_one_or_all() {
    let mut bus = bus(ErrorReports::Silent);
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
    let mut bus = bus(ErrorReports::Silent);
    assert_eq!(bus.says("S5 M24800000 m001FFFFF L"), ";;;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "");
    assert_eq!(bus.says("C M24600000 L"), ";;;");
    bus.talk(1);
    assert_eq!(bus.run_ms(3), "t1233DEAD00;");
}

#[test]
fn wrong_rate_with_records_gives_error_records_and_the_bus_error_flag() {
    let mut bus = bus(ErrorReports::Records);
    bus.says("S6 L");
    bus.talk(10);
    let output = bus.run_ms(15);
    let records: Vec<_> = output.split_terminator(';').collect();
    assert!(records.len() >= 10, "{output}");
    assert!(records.iter().all(|r| ["e1s", "e1f", "e1B", "e1b", "e1c"].contains(r)), "{output}");
    assert_eq!(bus.says("F F"), "F80;F00;");
}

#[test]
fn wrong_rate_with_flags_moves_the_flag_alone() {
    let mut bus = bus(ErrorReports::Flags);
    bus.says("S6 L");
    bus.talk(10);
    assert_eq!(bus.run_ms(15), "");
    assert_eq!(bus.says("F F"), "F80;F00;");
}

#[test]
fn wrong_rate_in_silence_looks_like_an_idle_bus() {
    let mut bus = bus(ErrorReports::Silent);
    bus.says("S6 L");
    bus.talk(10);
    assert_eq!(bus.run_ms(15), "");
    assert_eq!(bus.says("F"), "F00;");
}

#[test]
fn normal_mode_at_a_wrong_rate_disturbs_and_ends_error_passive() {
    let mut bus = bus(ErrorReports::Records);
    bus.says("S6 O");
    bus.talk(40);
    let output = bus.run_ms(60);
    assert!(output.contains("sp128"), "{output}");
    assert!(bus.dominant > 10);
}
