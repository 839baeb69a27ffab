//! The slave against `vectors/lss`: the conformance table, behaviour by hand, random sessions.
//! `vectors/README.md` says how a script reads.

use canbaud::lss::{
    Automatic, Configuration, LssAddress, LssState, NodeId, RateSet, RateSetting, Slave,
    SlaveAction, SlaveOptions, Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};
use serde::Deserialize;

#[derive(Deserialize)]
struct File {
    vendor_id: u32,
    product_code: u32,
    revision_number: u32,
    serial_number: u32,
    case: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    name: String,
    #[serde(default = "unconfigured")]
    node_id: u8,
    rates: Option<Vec<u8>>,
    #[serde(default = "yes")]
    automatic: bool,
    #[serde(default = "works")]
    storage: String,
    script: Vec<String>,
}

fn unconfigured() -> u8 {
    255
}

fn yes() -> bool {
    true
}

fn works() -> String {
    "works".into()
}

struct Medium {
    result: Result<(), StoreError>,
    stored: Option<Configuration>,
}

impl Storage for Medium {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        if self.result.is_ok() {
            self.stored = Some(configuration);
        }
        self.result
    }
}

/// A slave that plays a script.
struct Player {
    slave: Slave,
    storage: Medium,
    now: Micros,
}

impl Player {
    fn new(address: LssAddress, case: &Case) -> Self {
        let rates = match &case.rates {
            None => RateSet::ALL,
            Some(indices) => indices.iter().fold(RateSet::NONE, |set, index| {
                set.with(RateSetting::from_index(*index).unwrap().bitrate().unwrap())
            }),
        };
        let automatic = if case.automatic { Automatic::Offered } else { Automatic::Refused };
        let stored = Configuration {
            node_id: NodeId::new(case.node_id).unwrap(),
            rate: RateSetting::Fixed(Bitrate::new(250_000).unwrap()),
        };
        let result = match case.storage.as_str() {
            "works" => Ok(()),
            "none" => Err(StoreError::NotSupported),
            "broken" => Err(StoreError::Access),
            "manufacturer" => Err(StoreError::Manufacturer(42)),
            other => panic!("no storage {other}"),
        };
        Self {
            slave: Slave::new(SlaveOptions { address, rates, automatic }, stored),
            storage: Medium { result, stored: None },
            now: Micros(0),
        }
    }

    /// What the slave does, as lines of a script.
    fn drain(&mut self) -> Vec<String> {
        let mut lines = Vec::new();
        while let Some(action) = self.slave.poll(self.now) {
            lines.push(match action {
                SlaveAction::Send(frame) => format!("< {}", print(&frame)),
                SlaveAction::StopSending => "! stop".into(),
                SlaveAction::SwitchBitRate(RateSetting::Automatic) => "! switch automatic".into(),
                SlaveAction::SwitchBitRate(RateSetting::Fixed(rate)) => {
                    format!("! switch {}", rate.bits_per_second())
                }
                SlaveAction::ResumeSending => "! resume".into(),
                SlaveAction::ResetCommunication(node_id) => format!("! reset {}", node_id.get()),
            });
            assert!(lines.len() < 10, "it never wants nothing: {lines:?}");
        }
        assert!(self.slave.deadline() > self.now, "a deadline that has passed");
        lines
    }

    fn status(&self) -> String {
        let state = match self.slave.state() {
            LssState::Waiting => "waiting",
            LssState::Configuration => "configuration",
        };
        let pending = self.slave.pending();
        let index = pending.rate.index().unwrap();
        format!("= {state} node {} rate {index}", pending.node_id.get())
    }

    /// The script with what the slave does in place of what it is expected to do.
    fn play(&mut self, script: &[String]) -> Vec<String> {
        let mut lines = Vec::new();
        for line in script {
            match line.split_once(' ').unwrap() {
                (">", frame) => {
                    self.slave.handle(self.now, &parse(frame), &mut self.storage);
                    lines.push(line.clone());
                }
                ("@", ms) => {
                    self.now = Micros::from_ms(ms.parse().unwrap());
                    let due = self.slave.deadline() <= self.now;
                    lines.push(line.clone());
                    let done = self.drain();
                    assert_eq!(due, !done.is_empty(), "the deadline was wrong at {line}");
                    lines.extend(done);
                }
                ("?", "found") => {
                    self.slave.rate_found();
                    lines.push(line.clone());
                }
                ("?", "reset") => {
                    self.slave.reset_communication();
                    lines.push(line.clone());
                }
                ("=", _) => lines.push(self.status()),
                ("<" | "!", _) => continue,
                _ => panic!("no such line: {line}"),
            }
            lines.extend(self.drain());
        }
        lines
    }
}

/// A frame in the form of candump.
fn parse(text: &str) -> Frame {
    let (head, body) = text.split_once('#').unwrap();
    let raw = u32::from_str_radix(head, 16).unwrap();
    let id = if head.len() == 8 { Id::Extended(raw) } else { Id::Base(raw as u16) };
    let (kind, dlc, hex) = match body.as_bytes() {
        [b'R', dlc] => (FrameKind::Remote, dlc - b'0', ""),
        [b'#', _flags, ..] => {
            (FrameKind::Fd { brs: false, esi: false }, (body.len() as u8 - 2) / 2, &body[2..])
        }
        _ => (FrameKind::Data, body.len() as u8 / 2, body),
    };
    let bytes: Vec<u8> = (0..hex.len() / 2)
        .map(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).unwrap())
        .collect();
    Frame::new(id, kind, dlc, &bytes).unwrap()
}

fn print(frame: &Frame) -> String {
    assert_eq!((frame.kind(), frame.dlc()), (FrameKind::Data, 8), "{frame:?}");
    let bytes: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    format!("{}#{bytes}", frame.id())
}

/// Plays all cases of a file; at least so many.
fn play_all(text: &str, least: usize) {
    let file: File = toml::from_str(text).expect("a sound vector file");
    let address = LssAddress::new(
        file.vendor_id,
        file.product_code,
        file.revision_number,
        file.serial_number,
    );
    let mut wrong = Vec::new();
    for case in &file.case {
        let done = Player::new(address, case).play(&case.script);
        if let Some(at) =
            (0..done.len().max(case.script.len())).find(|at| done.get(*at) != case.script.get(*at))
        {
            let [wanted, done] = [&case.script, &done].map(|lines| lines.get(at));
            wrong.push(format!("{}, line {at}: {done:?} instead of {wanted:?}", case.name));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), file.case.len(), wrong.join("\n"));
    assert!(file.case.len() >= least, "only {} cases", file.case.len());
}

#[test]
fn every_service_in_every_state_is_as_the_table_says() {
    play_all(include_str!("../../../vectors/lss/services.toml"), 390);
}

#[test]
fn activation_index_9_reset_and_foreign_frames_are_as_written() {
    play_all(include_str!("../../../vectors/lss/behaviour.toml"), 30);
}

#[test]
fn random_sessions_go_as_in_the_reference() {
    play_all(include_str!("../../../vectors/lss/sessions.toml"), 40);
}

fn case(automatic: bool) -> Case {
    let (name, storage) = (String::new(), works());
    Case { name, node_id: 255, rates: None, automatic, storage, script: Vec::new() }
}

#[test]
fn what_is_pending_is_stored_also_automatic() {
    let mut player = Player::new(LssAddress::new(1, 2, 3, 4), &case(true));
    let script = ["> 7E5#0401000000000000", "> 7E5#110C000000000000", "> 7E5#1300090000000000"];
    player.play(&script.map(String::from));
    assert_eq!(player.storage.stored, None);
    player.play(&["> 7E5#1700000000000000".into()]);
    let stored = Configuration { node_id: NodeId::new(12).unwrap(), rate: RateSetting::Automatic };
    assert_eq!(player.storage.stored, Some(stored));
    // It is active at the next power-on, as the persistent bit rate always is.
    let address = LssAddress::new(1, 2, 3, 4);
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic: Automatic::Offered };
    assert_eq!(Slave::new(options, stored).active(), stored);
}

#[test]
fn a_device_that_becomes_mini_master_refuses_automatic_from_then_on() {
    let mut player = Player::new(LssAddress::new(1, 2, 3, 4), &case(true));
    let ask = ["> 7E5#0401000000000000", "> 7E5#1300090000000000"].map(String::from);
    assert_eq!(player.play(&ask).last().unwrap(), "< 7E4#1300000000000000");
    player.slave.set_automatic(Automatic::Refused);
    assert_eq!(player.play(&ask).last().unwrap(), "< 7E4#1301000000000000");
}
