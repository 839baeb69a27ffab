//! rtnetlink as bytes: messages built by hand from the kernel's layouts, and hostile ones.
#![cfg(all(target_os = "linux", target_endian = "little"))]

use canbaud_link::socketcan::netlink::{
    Attributes, Change, Link, LinkChange, Message, Messages, TdcInfo, TimingInfo, XStats, ctrlmode,
    dump_links, get_link,
};
use proptest::prelude::*;

/// `struct rtattr` and its payload, by hand: length, type, payload, padding.
fn attribute(kind: u16, payload: &[u8]) -> Vec<u8> {
    let mut bytes = (4 + payload.len() as u16).to_le_bytes().to_vec();
    bytes.extend(kind.to_le_bytes());
    bytes.extend(payload);
    while !bytes.len().is_multiple_of(4) {
        bytes.push(0);
    }
    bytes
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// `struct nlmsghdr` before `body`.
fn message(kind: u16, flags: u16, sequence: u32, body: &[u8]) -> Vec<u8> {
    let mut bytes = (16 + body.len() as u32).to_le_bytes().to_vec();
    bytes.extend(kind.to_le_bytes());
    bytes.extend(flags.to_le_bytes());
    bytes.extend(sequence.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(body);
    bytes
}

/// What Linux 6.12 says of a gs_usb interface that is up at 250 kbit/s, listening.
fn gs_usb() -> Vec<u8> {
    let mut constants = b"gs_usb".to_vec();
    constants.resize(16, 0);
    constants.extend(words(&[1, 16, 1, 8, 4, 1, 1024, 1]));
    let data = [
        attribute(1, &words(&[250_000, 875, 250, 6, 7, 2, 1, 12])),
        attribute(2, &constants),
        attribute(3, &words(&[48_000_000])),
        attribute(4, &words(&[0])),
        attribute(5, &words(&[0, 0x12])),
        attribute(6, &words(&[100])),
        attribute(8, &[7, 0, 9, 0]),
        // NLA_F_NESTED.
        attribute(0x8011, &attribute(1, &words(&[0x1B]))),
    ];
    let info = [
        attribute(1, b"can\0"),
        attribute(3, &words(&[1, 2, 3, 4, 5, 6])),
        attribute(0x8002, &data.concat()),
    ];
    // AF_UNSPEC, ARPHRD_CAN, index 5, IFF_UP | IFF_RUNNING | IFF_NOARP | IFF_ECHO.
    let mut body = vec![0, 0, 0x18, 0x01];
    body.extend(words(&[5, 0x0004_00C1, 0]));
    body.extend(attribute(3, b"can0\0"));
    body.extend(attribute(13, &words(&[10])));
    body.extend(attribute(4, &words(&[16])));
    body.extend(attribute(18, &info.concat()));
    body
}

#[test]
fn an_interface_is_read_as_the_kernel_tells_it() {
    let link = Link::parse(&gs_usb()).unwrap();
    assert_eq!((link.index, link.name.as_str(), link.mtu, link.txqueuelen), (5, "can0", 16, 10));
    assert!(link.is_can() && link.flags.is_up() && link.flags.driver_echoes());
    let can = link.can.unwrap();
    let timing = can.set_timing().unwrap();
    assert_eq!(
        (timing.bitrate, timing.sample_point, timing.tq, timing.brp),
        (250_000, 875, 250, 12)
    );
    assert_eq!(timing.quanta(), 16);
    let limits = can.timing_const.clone().unwrap();
    assert_eq!((limits.name.as_str(), limits.tseg1, limits.brp), ("gs_usb", (1, 16), (1, 1024)));
    assert_eq!(can.clock, Some(48_000_000));
    assert_eq!(can.ctrlmode, ctrlmode::LISTEN_ONLY | ctrlmode::BERR_REPORTING);
    assert_eq!(can.supports(ctrlmode::LISTEN_ONLY), Some(true));
    assert_eq!(can.supports(ctrlmode::FD), Some(false));
    assert_eq!(can.restart_ms, Some(100));
    assert_eq!(can.counters.map(|c| (c.transmit, c.receive)), Some((7, 9)));
    assert_eq!(
        can.xstats,
        Some(XStats {
            bus_error: 1,
            error_warning: 2,
            error_passive: 3,
            bus_off: 4,
            arbitration_lost: 5,
            restarts: 6,
        })
    );
}

/// A name is anybody's choice: `ip link set can0 name vcan0`.
#[test]
fn an_interface_is_virtual_by_its_kind() {
    for (name, kind, is_virtual) in [
        (&b"vcan0\0"[..], &b"can\0"[..], false),
        (b"bus\0", b"vcan\0", true),
        (b"bus\0", b"vxcan\0", true),
        (b"bus\0", b"can\0", false),
    ] {
        let mut body = vec![0, 0, 0x18, 0x01];
        body.extend(words(&[6, 0, 0]));
        body.extend(attribute(3, name));
        body.extend(attribute(18, &attribute(1, kind)));
        assert_eq!(Link::parse(&body).unwrap().is_virtual(), is_virtual, "{kind:?}");
    }
}

/// As slcan gave it: 36 bytes of fixed rates, no limits, no bit timing.
#[test]
fn fixed_rates_are_read() {
    let rates = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
    let data = [attribute(13, &words(&rates)), attribute(5, &words(&[0, 0]))].concat();
    let info = [attribute(1, b"can\0"), attribute(2, &data)].concat();
    let mut body = vec![0, 0, 0x18, 0x01];
    body.extend(words(&[6, 0, 0]));
    body.extend(attribute(18, &info));
    let can = Link::parse(&body).unwrap().can.unwrap();
    assert_eq!(can.bitrates, rates);
    assert_eq!((can.set_timing(), can.timing_const, can.ctrlmode_supported), (None, None, None));
}

#[test]
fn a_change_has_the_bytes_that_ip_link_sends() {
    // ip link set can0 type can bitrate 500000 listen-only on
    let change = LinkChange {
        timing: Some(TimingInfo { bitrate: 500_000, ..TimingInfo::default() }),
        ctrlmode: Some((2, 2)),
        ..LinkChange::default()
    };
    let data =
        [attribute(1, &words(&[500_000, 0, 0, 0, 0, 0, 0, 0])), attribute(5, &words(&[2, 2]))]
            .concat();
    let info = [attribute(1, b"can"), attribute(2, &data)].concat();
    let mut body = vec![0; 4];
    body.extend(words(&[5, 0, 0]));
    body.extend(attribute(18, &info));
    // RTM_NEWLINK, NLM_F_REQUEST | NLM_F_ACK.
    assert_eq!(change.encode(9, 5), message(16, 0x05, 9, &body));
    // ip link set can0 up: no link information at all.
    let mut body = vec![0; 4];
    body.extend(words(&[5, 1, 1]));
    assert_eq!(LinkChange::only(Change::Up).encode(10, 5), message(16, 0x05, 10, &body));
    let mut body = vec![0; 4];
    body.extend(words(&[5, 0, 1]));
    assert_eq!(LinkChange::only(Change::Down).encode(11, 5), message(16, 0x05, 11, &body));
}

#[test]
fn data_phase_delay_compensation_and_restart_are_said() {
    let tdc = TdcInfo { tdcv: None, tdco: Some(13), tdcf: None };
    let change = LinkChange {
        data_timing: Some(TimingInfo { bitrate: 2_000_000, ..TimingInfo::default() }),
        tdc: Some(tdc),
        restart_ms: Some(100),
        ..LinkChange::default()
    };
    let bytes = change.encode(1, 2);
    let info = Attributes::new(&bytes[32..]).find(18).unwrap();
    let data = info.nested().find(2).unwrap().nested();
    assert_eq!(data.find(9).unwrap().u32(), Some(2_000_000));
    assert_eq!(data.find(16).unwrap().payload, attribute(8, &words(&[13])));
    assert_eq!(data.find(6).unwrap().u32(), Some(100));
    assert_eq!(data.find(1), None);
}

#[test]
fn requests_ask_for_one_or_all() {
    let mut body = vec![0; 4];
    body.extend(words(&[0, 0, 0]));
    // RTM_GETLINK, NLM_F_REQUEST | NLM_F_ROOT | NLM_F_MATCH.
    assert_eq!(dump_links(3), message(18, 0x301, 3, &body));
    let mut body = vec![0; 4];
    body.extend(words(&[7, 0, 0]));
    assert_eq!(get_link(4, 7), message(18, 0x01, 4, &body));
}

#[test]
fn answers_are_told_apart() {
    let request = message(16, 5, 9, &[0; 16]);
    let denied = [(-1_i32).to_le_bytes().to_vec(), request.clone()].concat();
    // -EOPNOTSUPP with an explanation behind the capped request.
    let mut explained = (-95_i32).to_le_bytes().to_vec();
    explained.extend(&request[..16]);
    explained.extend(attribute(1, b"control mode is not supported\0"));
    let datagram = [
        message(16, 2, 9, &gs_usb()),
        message(2, 0, 9, &denied),
        message(2, 0x300, 10, &explained),
        message(2, 0x100, 11, &[0, 0, 0, 0, 1, 2, 3, 4]),
        message(3, 2, 12, &[0; 4]),
        message(99, 0, 13, &[]),
    ]
    .concat();
    let all: Vec<_> = Messages::new(&datagram).collect();
    assert_eq!(all.iter().map(|one| one.0).collect::<Vec<_>>(), [9, 9, 10, 11, 12, 13]);
    assert!(matches!(all[0].1, Message::Link(body) if Link::parse(body).is_some()));
    let Message::Error(denied) = &all[1].1 else { panic!("{all:?}") };
    assert_eq!((denied.errno, denied.message.as_deref()), (1, None));
    let Message::Error(explained) = &all[2].1 else { panic!("{all:?}") };
    assert_eq!(explained.message.as_deref(), Some("control mode is not supported"));
    assert_eq!(all[3].1, Message::Done);
    assert_eq!(all[4].1, Message::Done);
    assert_eq!(all[5].1, Message::Other(99));
}

fn read_everything(bytes: &[u8]) {
    for (_, message) in Messages::new(bytes) {
        if let Message::Link(body) = message {
            let _ = Link::parse(body);
        }
    }
    let _ = Link::parse(bytes);
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        read_everything(&bytes);
    }

    #[test]
    fn damaged_messages_are_read_without_panic(
        at in any::<prop::sample::Index>(),
        with in any::<[u8; 2]>(),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = message(16, 2, 9, &gs_usb());
        let place = at.index(bytes.len() - 1);
        bytes[place..place + 2].copy_from_slice(&with);
        read_everything(&bytes);
        bytes.truncate(cut.index(bytes.len()));
        read_everything(&bytes);
    }
}
