//! A device of CANopen without a timer: the listen-only scan, the bit timing of one controller
//! with its register, and the LSS slave.
#![no_std]
#![no_main]

use canbaud::detect::scan::{
    Action, Candidates, Capabilities, Configured, Evidence, FdSupport, FrameSeen, Observation,
    Origin, RateChoice, Scan, Settings,
};
use canbaud::lss::{
    Automatic, Configuration, LssAddress, NodeId, RateSet, RateSetting, Slave, SlaveAction,
    SlaveOptions, Storage, StoreError,
};
use canbaud::timing::controllers::{Configuration as Timing, bxcan};
use canbaud::timing::{Request, solve};
use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_firmware::board::port;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    let now = || Micros(u64::from(port::read()));
    if let (Some(low), Some(high)) = (Bitrate::new(10_000), Bitrate::new(1_000_000)) {
        let capabilities = Capabilities {
            rates: RateChoice::Between(low, high),
            evidence: Evidence::Errors,
            fd: FdSupport::Classic,
            reconfiguration: Micros(500),
            latency: Micros(0),
        };
        let candidates = Candidates::<8>::canopen().unwrap_or_default();
        let mut scan = Scan::new(&candidates, &capabilities, Settings::default());
        while scan.outcome().is_none() {
            match scan.poll(now()) {
                Some(Action::Listen(candidate)) => {
                    set(candidate.nominal);
                    let configured = Configured { nominal: candidate.nominal, data: None };
                    scan.handle_listening(now(), configured);
                }
                Some(Action::Stop) => {}
                None => {
                    let seen = FrameSeen { frame: frame(), origin: Origin::Bus, received: None };
                    scan.handle(now(), &Observation::Frame(seen));
                }
            }
        }
    }
    slave(now)
}

fn slave(now: impl Fn() -> Micros) -> ! {
    let address = LssAddress::new(0x29C, 1, 1, port::read());
    let options = SlaveOptions { address, rates: RateSet::ALL, automatic: Automatic::Offered };
    let stored = Configuration { node_id: NodeId::UNCONFIGURED, rate: RateSetting::Automatic };
    let mut slave = Slave::new(options, stored);
    loop {
        slave.handle(now(), &frame(), &mut Port);
        while let Some(action) = slave.poll(now()) {
            match action {
                SlaveAction::Send(frame) => {
                    frame.data().iter().for_each(|byte| port::write(u32::from(*byte)));
                }
                SlaveAction::SwitchBitRate(rate) => {
                    if let Some(rate) = rate.bitrate() {
                        set(rate);
                    }
                }
                SlaveAction::StopSending | SlaveAction::ResumeSending => port::write(0),
                SlaveAction::ResetCommunication(_) => slave.reset_communication(),
            }
        }
    }
}

/// The register of bxCAN for a rate, from a clock of 36 MHz.
fn set(rate: Bitrate) {
    let Some(clock) = Hertz::new(36_000_000) else { return };
    if let Ok(solution) = solve(&Request::new(clock, rate), &bxcan::NOMINAL)
        && let Ok(word) = bxcan::BTR.pack(&Timing::classic(solution.timing))
    {
        port::write(word);
    }
}

fn frame() -> Frame {
    let data = [(); 8].map(|()| port::read() as u8);
    let id = Id::base(port::read() as u16 & 0x7FF).unwrap_or(Id::Base(0));
    loop {
        if let Ok(frame) = Frame::new(id, FrameKind::Data, 8, &data) {
            return frame;
        }
    }
}

/// Memory that takes what it is given.
struct Port;

impl Storage for Port {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        port::write(u32::from(configuration.node_id.get()));
        Ok(())
    }
}
