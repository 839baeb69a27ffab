//! The services and the activation of the master, against slaves in virtual time.

mod lss_bus;

use canbaud::lss::{
    Activation, ActivationAction, Exchange, ExchangeAction, IdRange, LssAddress, LssState, NodeId,
    Outcome, Pace, Part, RateSetting, Reply, Request, Response, Service, ServiceError, SlaveAction,
};
use canbaud::units::{Bitrate, Micros};
use lss_bus::{Bus, Memory, Way, slave};

const FIRST: LssAddress = LssAddress::new(0x29C, 1, 0x1_0002, 4711);
const SECOND: LssAddress = LssAddress::new(0x29C, 1, 0x1_0002, 4712);

fn bus() -> Bus {
    let mut bus = Bus::new(&[FIRST, SECOND], Way::STEADY, 1);
    bus.slaves[1] = slave(SECOND, 20);
    bus
}

#[test]
fn one_device_is_configured_from_selecting_to_storing() {
    let mut bus = bus();
    assert_eq!(bus.exchange(Service::SwitchStateSelective(FIRST)), Ok(Reply::Done));
    assert_eq!(bus.slaves[1].state(), LssState::Waiting);
    let product = bus.exchange(Service::InquireIdentity(Part::ProductCode));
    assert_eq!(product, Ok(Reply::Number(1)));
    assert_eq!(bus.exchange(Service::InquireNodeId), Ok(Reply::NodeId(255)));
    let node_id = NodeId::new(33).unwrap();
    assert_eq!(bus.exchange(Service::ConfigureNodeId(node_id)), Ok(Reply::Done));
    let automatic = Service::configure_rate(RateSetting::Automatic).unwrap();
    assert_eq!(bus.exchange(automatic), Ok(Reply::Done));
    assert_eq!(bus.exchange(Service::StoreConfiguration), Ok(Reply::Done));
    let stored = bus.memories[0].0.unwrap();
    assert_eq!((stored.node_id, stored.rate), (node_id, RateSetting::Automatic));
    assert_eq!(bus.exchange(Service::SwitchStateGlobal(LssState::Waiting)), Ok(Reply::Done));
    assert_eq!(bus.slaves[0].active().node_id, node_id);
}

#[test]
fn refusals_and_silence_are_told_apart() {
    let mut bus = bus();
    let absent = LssAddress { serial_number: 1, ..FIRST };
    let timeout = Err(ServiceError::NoAnswer(Micros::from_ms(500)));
    assert_eq!(bus.exchange(Service::SwitchStateSelective(absent)), timeout);
    assert_eq!(bus.exchange(Service::StoreConfiguration), timeout);
    assert_eq!(bus.exchange(Service::SwitchStateSelective(FIRST)), Ok(Reply::Done));
    let reserved = Service::ConfigureBitTiming { table_selector: 0, table_index: 5 };
    assert_eq!(bus.exchange(reserved), Err(ServiceError::Refused(Outcome::REFUSED)));
    let own_table = Service::ConfigureBitTiming { table_selector: 200, table_index: 0 };
    assert_eq!(bus.exchange(own_table), Err(ServiceError::Refused(Outcome::REFUSED)));
}

#[test]
fn two_devices_in_configuration_are_noticed() {
    let mut bus = bus();
    bus.exchange(Service::SwitchStateGlobal(LssState::Configuration)).unwrap();
    let serial = bus.exchange(Service::InquireIdentity(Part::SerialNumber));
    assert_eq!(serial, Err(ServiceError::SeveralAnswers));
    // What they have in common cannot tell them apart.
    let vendor = bus.exchange(Service::InquireIdentity(Part::VendorId));
    assert_eq!(vendor, Ok(Reply::Number(0x29C)));
}

#[test]
fn devices_are_identified_in_any_state() {
    let mut bus = bus();
    let range = |serial_number| {
        Service::IdentifyRemoteSlave(IdRange {
            vendor_id: 0x29C,
            product_code: 1,
            revision_number: (0, u32::MAX),
            serial_number,
        })
    };
    assert_eq!(bus.exchange(range((4712, 5000))), Ok(Reply::Done));
    let timeout = Err(ServiceError::NoAnswer(Micros::from_ms(500)));
    assert_eq!(bus.exchange(range((4713, 5000))), timeout);
    let unconfigured = Service::IdentifyNonConfiguredRemoteSlave;
    assert_eq!(bus.exchange(unconfigured), Ok(Reply::Done));
    bus.slaves.remove(0);
    assert_eq!(bus.exchange(unconfigured), timeout);
}

#[test]
fn frames_of_a_sequence_keep_the_inhibit_time_and_answers_to_others_do_not_count() {
    let pace = Pace { inhibit: Micros::from_ms(7), ..Pace::default() };
    let mut exchange = Exchange::new(Service::SwitchStateSelective(FIRST), pace, Micros(0));
    let mut sent = Vec::new();
    while sent.len() < 4 {
        let now = exchange.deadline();
        match exchange.poll(now) {
            Some(ExchangeAction::Send(frame)) => sent.push((now.ms(), frame)),
            other => panic!("{other:?}"),
        }
        // A late answer from before, while the address is still going out.
        if sent.len() < 4 {
            exchange.handle(now, &Response::SwitchStateSelective.to_frame());
        }
    }
    assert_eq!(sent.iter().map(|(at, _)| *at).collect::<Vec<_>>(), [0, 7, 14, 21]);
    assert_eq!(sent[3].1.data(), [0x43, 0x67, 0x12, 0, 0, 0, 0, 0]);
    exchange.handle(Micros::from_ms(22), &Response::IdentifySlave.to_frame());
    exchange.handle(Micros::from_ms(23), &Request::InquireNodeId.to_frame());
    assert_eq!(exchange.deadline(), Micros::from_ms(521));
    exchange.handle(Micros::from_ms(24), &Response::SwitchStateSelective.to_frame());
    assert_eq!(exchange.poll(Micros::from_ms(34)), Some(ExchangeAction::Done(Ok(Reply::Done))));
    assert_eq!((exchange.poll(Micros::MAX), exchange.deadline()), (None, Micros::MAX));
}

/// Master and slave through an activation: nobody sends while rates may differ, and both are at the
/// new one when it is over, for every way of the command and any delay.
#[test]
fn an_activation_has_all_at_the_new_rate_before_anybody_sends() {
    for delay in [0_u16, 1, 20, 100, 1000, 65_535] {
        // The command may take a while, though less than what the master has to spare.
        for travel in [Micros(0), Micros(300), Micros::from_ms(4)] {
            let mut slave = slave(FIRST, 5);
            let mut memory = Memory(None);
            let start = Micros::from_ms(1000);
            for request in [
                Request::SwitchStateGlobal { mode: 1 },
                Request::ConfigureBitTiming { table_selector: 0, table_index: 2 },
            ] {
                slave.handle(start, &request.to_frame(), &mut memory);
                while slave.poll(start).is_some() {}
            }
            let mut master = Activation::new(delay);
            // The master's turn counts from its first poll.
            let mut log = Vec::new();
            let mut arrives = Micros::MAX;
            let mut now = start;
            while log.len() < 6 {
                now = now.max(master.deadline().min(slave.deadline()).min(arrives));
                if now >= arrives {
                    let command = Request::ActivateBitTiming { switch_delay_ms: delay };
                    slave.handle(now, &command.to_frame(), &mut memory);
                    arrives = Micros::MAX;
                }
                while let Some(action) = slave.poll(now) {
                    log.push((now - start, format!("slave {action:?}")));
                    assert!(!matches!(action, SlaveAction::Send(_)), "delay {delay}: {log:?}");
                }
                while let Some(action) = master.poll(now) {
                    match action {
                        ActivationAction::Send(_) => arrives = now + travel,
                        ActivationAction::SwitchBitRate { .. } => {
                            log.push((now - start, "master switches".into()));
                        }
                        ActivationAction::Done => log.push((now - start, "master done".into())),
                    }
                }
                if master.deadline() == Micros::MAX && slave.deadline() == Micros::MAX {
                    break;
                }
            }
            let at = |what: &str| log.iter().find(|(_, done)| done.contains(what)).unwrap().0;
            let delay = Micros::from_ms(u64::from(delay));
            assert_eq!(at("StopSending"), travel);
            assert_eq!(at("SwitchBitRate"), travel + delay);
            assert_eq!(at("ResumeSending"), travel + delay + delay);
            assert!(at("master switches") >= at("SwitchBitRate"), "{log:?}");
            assert!(at("master done") >= at("ResumeSending"), "{log:?}");
            let rate = RateSetting::Fixed(Bitrate::new(500_000).unwrap());
            assert_eq!(slave.active().rate, rate);
        }
    }
}
