//! The LSS slave: a master in memory finds the device by fastscan, gives it a node-ID and a bit
//! rate, has it store both and activates the rate.
#![no_std]
#![no_main]

use canbaud::lss::{
    Automatic, Configuration, Exchange, ExchangeAction, Fastscan, FastscanAction, FastscanOptions,
    LssAddress, NodeId, Pace, RateSet, RateSetting, Request, Service, Slave, SlaveAction,
    SlaveOptions, Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::Frame;
use canbaud_firmware::board::Counter;
use canbaud_firmware::console::{self, Status, print, print_pair};
use cortex_m_rt::entry;

/// A device: the slave, what it stored, and the time.
struct Device {
    slave: Slave,
    stored: Option<Configuration>,
    now: Micros,
    most: u64,
}

struct Eeprom<'a>(&'a mut Option<Configuration>);

impl Storage for Eeprom<'_> {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        *self.0 = Some(configuration);
        Ok(())
    }
}

#[entry]
fn main() -> ! {
    let counter = Counter::new();
    print_pair("lss_slave_ram_bytes", size_of::<Slave>() as u64);
    let status = match configure(&counter) {
        Some(most) => {
            print_pair("lss_slave_step_max", most);
            Status::Ok
        }
        None => {
            print("the device was not configured\n");
            Status::Failed
        }
    };
    console::exit(status)
}

/// All steps; the most instructions that a frame cost the slave.
fn configure(counter: &Counter) -> Option<u64> {
    let address = LssAddress::new(0x29C, 0x0815, 0x10002, 4711);
    let rates = RateSet::ALL;
    let options = SlaveOptions { address, rates, automatic: Automatic::Offered };
    let delivered = Configuration { node_id: NodeId::UNCONFIGURED, rate: RateSetting::Automatic };
    let slave = Slave::new(options, delivered);
    let mut device = Device { slave, stored: None, now: Micros(0), most: 0 };

    if find(&mut device, counter)? != address {
        return None;
    }
    let (node_id, rate) = (NodeId::new(42)?, RateSetting::Fixed(Bitrate::new(250_000)?));
    for service in [
        Service::ConfigureNodeId(node_id),
        Service::configure_rate(rate)?,
        Service::StoreConfiguration,
    ] {
        ask(&mut device, service, counter)?;
    }
    (device.stored == Some(Configuration { node_id, rate })).then_some(())?;
    // The activation: two delays of 10 ms, the switch between them.
    let command = Request::ActivateBitTiming { switch_delay_ms: 10 }.to_frame();
    device.receive(&command, counter);
    let mut switched = false;
    while device.now < Micros(u64::MAX >> 1) {
        let deadline = device.slave.deadline();
        if deadline == Micros::MAX {
            break;
        }
        device.now = deadline.max(device.now);
        while let Some(action) = device.slave.poll(device.now) {
            switched |= action == SlaveAction::SwitchBitRate(rate);
        }
    }
    switched.then_some(device.most)
}

impl Device {
    /// The slave takes a frame; its answer.
    fn receive(&mut self, frame: &Frame, counter: &Counter) -> Option<Frame> {
        self.now = self.now + Micros(500);
        let ((), handled) = counter.count(|| {
            self.slave.handle(self.now, frame, &mut Eeprom(&mut self.stored));
        });
        let (action, polled) = counter.count(|| self.slave.poll(self.now));
        self.most = self.most.max(handled + polled);
        match action {
            Some(SlaveAction::Send(frame)) => Some(frame),
            _ => None,
        }
    }
}

fn find(device: &mut Device, counter: &Counter) -> Option<LssAddress> {
    let mut scan = Fastscan::new(FastscanOptions::default(), device.now);
    for _ in 0..10_000 {
        match scan.poll(device.now) {
            Some(FastscanAction::Send(frame)) => {
                if let Some(answer) = device.receive(&frame, counter) {
                    scan.handle(device.now, &answer);
                }
            }
            Some(FastscanAction::Done(found)) => return found.ok()?.map(|found| found.address),
            None => device.now = scan.deadline().max(device.now),
        }
    }
    None
}

fn ask(device: &mut Device, service: Service, counter: &Counter) -> Option<()> {
    let mut exchange = Exchange::new(service, Pace::default(), device.now);
    for _ in 0..1_000 {
        match exchange.poll(device.now) {
            Some(ExchangeAction::Send(frame)) => {
                if let Some(answer) = device.receive(&frame, counter) {
                    exchange.handle(device.now, &answer);
                }
            }
            Some(ExchangeAction::Done(reply)) => return reply.ok().map(|_| ()),
            None => device.now = exchange.deadline().max(device.now),
        }
    }
    None
}
