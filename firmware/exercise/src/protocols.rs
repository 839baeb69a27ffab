//! LSS: slave and master.

use crate::{Sink, Source};
use canbaud::lss::{
    Activation, Automatic, Configuration, Exchange, ExchangeAction, Fastscan, FastscanAction,
    FastscanOptions, IdRange, LssAddress, LssState, NodeId, Pace, Part, RateSet, RateSetting,
    Request, Response, Service, Slave, SlaveAction, SlaveOptions, Storage, StoreError,
};
use canbaud::units::Micros;
use canbaud::wire::Frame;

pub(crate) fn exercise(source: &mut Source<'_>, sink: &mut Sink) {
    slave(source, sink);
    exchange(source, sink);
    fastscan(source, sink);
    let mut activation = Activation::new(source.word() as u16);
    for _ in 0..8 {
        sink.take(u32::from(activation.poll(source.time()).is_some()));
        sink.take_long(activation.deadline().0);
    }
}

struct Eeprom(u32);

impl Storage for Eeprom {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        self.0 += 1;
        match configuration.node_id.is_configured() {
            true => Ok(()),
            false => Err(StoreError::Access),
        }
    }
}

fn address(source: &mut Source<'_>) -> LssAddress {
    LssAddress::new(source.word(), source.word(), source.word(), source.word())
}

/// A command of a master, or its answer, or anything.
fn frame(source: &mut Source<'_>) -> Option<Frame> {
    let bytes = [(); 8].map(|()| source.byte());
    match source.byte() % 3 {
        0 => Request::from_bytes(bytes).map(Request::to_frame),
        1 => Response::from_bytes(bytes).map(Response::to_frame),
        _ => source.frame(),
    }
}

fn slave(source: &mut Source<'_>, sink: &mut Sink) {
    let options = SlaveOptions {
        address: address(source),
        rates: RateSet::ALL,
        automatic: Automatic::Offered,
    };
    let stored = Configuration { node_id: NodeId::UNCONFIGURED, rate: RateSetting::Automatic };
    let mut slave = Slave::new(options, stored);
    let mut eeprom = Eeprom(0);
    for _ in 0..source.word() & 0xFFFF {
        let now = source.time();
        if let Some(frame) = frame(source) {
            slave.handle(now, &frame, &mut eeprom);
        }
        while let Some(action) = slave.poll(now) {
            match action {
                SlaveAction::Send(frame) => sink.take(u32::from(frame.dlc())),
                SlaveAction::SwitchBitRate(rate) => sink.take(u32::from(rate.index().unwrap_or(0))),
                SlaveAction::ResetCommunication(_) => slave.reset_communication(),
                SlaveAction::StopSending | SlaveAction::ResumeSending => slave.rate_found(),
            }
        }
        sink.take_long(slave.deadline().0);
    }
    sink.take(eeprom.0);
}

fn service(source: &mut Source<'_>) -> Service {
    match source.byte() % 9 {
        0 => Service::SwitchStateGlobal(LssState::Configuration),
        1 => Service::SwitchStateSelective(address(source)),
        2 => Service::ConfigureNodeId(NodeId::UNCONFIGURED),
        3 => Service::ConfigureBitTiming { table_selector: 0, table_index: source.byte() },
        4 => Service::StoreConfiguration,
        5 => Service::InquireIdentity(Part::VendorId),
        6 => Service::InquireNodeId,
        7 => {
            let (low, high) = (source.word(), source.word());
            Service::IdentifyRemoteSlave(IdRange {
                vendor_id: source.word(),
                product_code: source.word(),
                revision_number: (low, high),
                serial_number: (low, high),
            })
        }
        _ => Service::IdentifyNonConfiguredRemoteSlave,
    }
}

fn exchange(source: &mut Source<'_>, sink: &mut Sink) {
    let mut exchange = Exchange::new(service(source), Pace::default(), Micros(0));
    for _ in 0..source.word() & 0xFF {
        let now = source.time();
        if let Some(frame) = frame(source) {
            exchange.handle(now, &frame);
        }
        if let Some(ExchangeAction::Send(frame)) = exchange.poll(now) {
            sink.take(u32::from(frame.dlc()));
        }
        sink.take_long(exchange.deadline().0);
    }
}

fn fastscan(source: &mut Source<'_>, sink: &mut Sink) {
    let known = [address(source)];
    let options = FastscanOptions { known: &known, ..FastscanOptions::default() };
    let mut scan = Fastscan::new(options, Micros(0));
    for _ in 0..source.word() & 0xFFFF {
        let now = source.time();
        if let Some(frame) = frame(source) {
            scan.handle(now, &frame);
        }
        if let Some(FastscanAction::Send(frame)) = scan.poll(now) {
            sink.take(u32::from(frame.dlc()));
        }
        sink.take_long(scan.deadline().0);
    }
    sink.take(scan.statistics().requests);
}
