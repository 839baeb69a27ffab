//! The LSS slave of a device, as its firmware would run it: one loop, no clock and no driver of its
//! own. Here a script plays controller, flash and time.
//!
//! cargo run -p canbaud --example lss_slave

use canbaud::lss::{
    Automatic, Configuration, LssAddress, NodeId, RateSet, RateSetting, Request, Slave,
    SlaveAction, SlaveOptions, Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};

/// Flash that keeps the configuration.
struct Flash(Configuration);

impl Storage for Flash {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        println!("            stored: node-ID {}, {}", configuration.node_id, configuration.rate);
        self.0 = configuration;
        Ok(())
    }
}

fn stamp(now: Micros) -> String {
    format!("{:>10}", now.to_string())
}

/// What the node does with its controller.
fn carry_out(slave: &mut Slave, now: Micros) {
    let at = stamp(now);
    while let Some(action) = slave.poll(now) {
        match action {
            SlaveAction::Send(frame) => {
                println!("{at}  sends {} {:02X?}", frame.id(), frame.data());
            }
            SlaveAction::StopSending => println!("{at}  falls silent"),
            SlaveAction::SwitchBitRate(RateSetting::Fixed(rate)) => {
                println!("{at}  sets its controller to {rate}bit/s");
            }
            SlaveAction::SwitchBitRate(RateSetting::Automatic) => {
                println!(
                    "{at}  listens until it has found the bit rate, and sets its controller to it"
                );
                slave.rate_found();
            }
            SlaveAction::ResumeSending => println!("{at}  may send again"),
            SlaveAction::ResetCommunication(node_id) => {
                slave.reset_communication();
                println!("{at}  boots up as {:03X}h", 0x700 + u16::from(node_id.get()));
            }
        }
    }
}

fn main() {
    let options = SlaveOptions {
        address: LssAddress::new(0x29C, 1, 0x0001_0002, 4711),
        rates: RateSet::ALL,
        automatic: Automatic::Offered,
    };
    let rate = RateSetting::Fixed(Bitrate::new(125_000).expect("not 0"));
    let mut flash = Flash(Configuration { node_id: NodeId::UNCONFIGURED, rate });
    let mut slave = Slave::new(options, flash.0);

    // A master gives it node-ID 7 and automatic detection of the bit rate, and activates it.
    let mut now = Micros(0);
    for request in [
        Request::SwitchStateGlobal { mode: 1 },
        Request::ConfigureNodeId { node_id: 7 },
        Request::ConfigureBitTiming { table_selector: 0, table_index: 9 },
        Request::StoreConfiguration,
        Request::ActivateBitTiming { switch_delay_ms: 100 },
        Request::SwitchStateGlobal { mode: 0 },
    ] {
        println!("{}  receives {request:?}", stamp(now));
        slave.handle(now, &request.to_frame(), &mut flash);
        carry_out(&mut slave, now);
        now = now + Micros::from_ms(1);
    }
    // No more frames: the time alone goes on.
    while slave.deadline() < Micros::MAX {
        now = now.max(slave.deadline());
        carry_out(&mut slave, now);
    }
}
