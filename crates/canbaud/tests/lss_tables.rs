//! Bit timing tables of the manufacturer: selectors 128 to 255 of "configure bit timing" [CiA 305].

use canbaud::lss::{
    Automatic, Configuration, LssAddress, NodeId, RateSet, RateSetting, Slave, SlaveAction,
    SlaveOptions, Storage, StoreError, TableEntry, Tables,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};

fn fixed(bits_per_second: u32) -> RateSetting {
    RateSetting::Fixed(Bitrate::new(bits_per_second).unwrap())
}

const fn entry(table_selector: u8, table_index: u8, setting: RateSetting) -> TableEntry {
    TableEntry { table_selector, table_index, setting }
}

fn entries() -> [TableEntry; 5] {
    [
        entry(128, 0, fixed(83_333)),
        entry(128, 9, RateSetting::Automatic),
        // The manufacturer's numbers are his own: 3 is no 250 kbit/s here.
        entry(255, 3, fixed(33_333)),
        entry(255, 255, fixed(615_385)),
        // Reserved selectors are never looked up.
        entry(127, 0, fixed(100_000)),
    ]
}

#[derive(Default)]
struct Medium(Option<Configuration>);

impl Storage for Medium {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        self.0 = Some(configuration);
        Ok(())
    }
}

fn options(automatic: Automatic) -> SlaveOptions {
    // Of table 0 it can 250 kbit/s alone.
    let rates = RateSet::NONE.with(Bitrate::new(250_000).unwrap());
    SlaveOptions { address: LssAddress::new(1, 2, 3, 4), rates, automatic }
}

fn stored() -> Configuration {
    Configuration { node_id: NodeId::new(5).unwrap(), rate: fixed(250_000) }
}

fn command(bytes: [u8; 8]) -> Frame {
    Frame::new(Id::Base(0x7E5), FrameKind::Data, 8, &bytes).unwrap()
}

/// The error code to "configure bit timing".
fn configure<T: Tables>(slave: &mut Slave<T>, selector: u8, index: u8) -> u8 {
    let now = Micros(0);
    slave.handle(now, &command([0x04, 1, 0, 0, 0, 0, 0, 0]), &mut Medium::default());
    let request = command([0x13, selector, index, 0, 0, 0, 0, 0]);
    slave.handle(now, &request, &mut Medium::default());
    let Some(SlaveAction::Send(answer)) = slave.poll(now) else { panic!("no answer") };
    assert_eq!(answer.id(), Id::Base(0x7E4));
    assert_eq!((answer.data()[0], answer.data().len()), (0x13, 8));
    assert_eq!(slave.poll(now), None);
    answer.data()[1]
}

#[test]
fn every_selector_and_index_is_answered_by_what_the_device_has() {
    let entries = entries();
    for selector in 0..=255 {
        for index in 0..=255 {
            let mut slave =
                Slave::with_tables(options(Automatic::Offered), stored(), entries.as_slice());
            let wanted = match (selector, index) {
                (0, 3) => Some(fixed(250_000)),
                (0 | 128, 9) => Some(RateSetting::Automatic),
                (128, 0) => Some(fixed(83_333)),
                (255, 3) => Some(fixed(33_333)),
                (255, 255) => Some(fixed(615_385)),
                _ => None,
            };
            let code = configure(&mut slave, selector, index);
            assert_eq!(code, u8::from(wanted.is_none()), "table {selector}, index {index}");
            let pending = wanted.unwrap_or(stored().rate);
            assert_eq!(slave.pending().rate, pending, "table {selector}, index {index}");
            assert_eq!(slave.active(), stored());
        }
    }
}

#[test]
fn a_device_without_tables_refuses_them_and_pays_nothing() {
    let mut slave = Slave::new(options(Automatic::Offered), stored());
    for selector in 128..=255 {
        assert_eq!(configure(&mut slave, selector, 0), 1, "table {selector}");
    }
    let entries = entries();
    let with = Slave::with_tables(options(Automatic::Offered), stored(), entries.as_slice());
    assert!(size_of_val(&slave) < size_of_val(&with));
}

/// K9: a mini-master refuses automatic detection by whatever number.
#[test]
fn k9_automatic_detection_by_a_table_of_the_manufacturer_is_refused_as_well() {
    let entries = entries();
    let mut slave = Slave::with_tables(options(Automatic::Refused), stored(), entries.as_slice());
    assert_eq!(configure(&mut slave, 128, 9), 1);
    assert_eq!(configure(&mut slave, 128, 0), 0);
}

#[test]
fn a_rate_of_the_manufacturer_is_stored_and_activated() {
    let entries = entries();
    let mut slave = Slave::with_tables(options(Automatic::Offered), stored(), entries.as_slice());
    assert_eq!(configure(&mut slave, 128, 0), 0);
    let mut medium = Medium::default();
    slave.handle(Micros(0), &command([0x17, 0, 0, 0, 0, 0, 0, 0]), &mut medium);
    assert!(matches!(slave.poll(Micros(0)), Some(SlaveAction::Send(_))));
    assert_eq!(medium.0.unwrap().rate, fixed(83_333));
    slave.handle(Micros(0), &command([0x15, 10, 0, 0, 0, 0, 0, 0]), &mut medium);
    assert_eq!(slave.poll(Micros(0)), Some(SlaveAction::StopSending));
    assert_eq!(slave.poll(Micros(9_999)), None);
    assert_eq!(slave.poll(Micros(10_000)), Some(SlaveAction::SwitchBitRate(fixed(83_333))));
}
