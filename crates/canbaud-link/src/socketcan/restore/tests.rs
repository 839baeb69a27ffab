use super::*;
use crate::socketcan::netlink::{LinkFlags, TimingConst};

const TIMING: TimingInfo = TimingInfo {
    bitrate: 500_000,
    sample_point: 875,
    tq: 125,
    prop_seg: 6,
    phase_seg1: 7,
    phase_seg2: 2,
    sjw: 1,
    brp: 6,
};

fn link(ctrlmode: u32, timing: Option<TimingInfo>) -> Link {
    Link {
        index: 5,
        name: "can0".to_owned(),
        flags: LinkFlags(1),
        hardware: 280,
        mtu: 16,
        txqueuelen: 10,
        kind: Some("can".to_owned()),
        can: Some(CanInfo {
            timing,
            timing_const: Some(TimingConst::default()),
            ctrlmode,
            ..CanInfo::default()
        }),
    }
}

#[test]
fn what_was_set_is_said_again_segment_by_segment() {
    let saved = Saved::of(&link(ctrlmode::LOOPBACK, Some(TIMING)));
    let now = link(ctrlmode::LISTEN_ONLY | ctrlmode::BERR_REPORTING, None);
    let change = saved.change(&now, Form::Segments);
    // With both, the kernel refuses: either rate or TQ.
    let timing = change.timing.unwrap();
    assert_eq!((timing.bitrate, timing.tq, timing.phase_seg2, timing.sjw), (0, 125, 2, 1));
    let all = ctrlmode::LOOPBACK | ctrlmode::LISTEN_ONLY | ctrlmode::BERR_REPORTING;
    assert_eq!(change.ctrlmode, Some((all, ctrlmode::LOOPBACK)));
    let timing = saved.change(&now, Form::Bitrate).timing.unwrap();
    assert_eq!((timing.bitrate, timing.sample_point, timing.tq), (500_000, 875, 0));
}

#[test]
fn a_state_that_is_not_reached_is_named() {
    let saved = Saved::of(&link(0, Some(TIMING)));
    assert_eq!(saved.difference(&link(0, Some(TIMING))), None);
    let mode = saved.difference(&link(ctrlmode::LISTEN_ONLY, Some(TIMING))).unwrap();
    assert_eq!(mode, "its control mode is 0x2, it was 0x0");
    let rate = TimingInfo { bitrate: 250_000, ..TIMING };
    let rate = saved.difference(&link(0, Some(rate))).unwrap();
    assert_eq!(rate, "its bit rate is 250000 bit/s, it was 500000 bit/s");
    // Linux cannot take a bit rate away.
    let never_set = Saved::of(&link(0, None));
    assert_eq!(never_set.difference(&link(0, Some(TIMING))), None);
}

#[test]
fn delay_compensation_goes_with_can_fd_only() {
    let mut link = link(ctrlmode::FD | ctrlmode::TDC_AUTO, Some(TIMING));
    let tdc = TdcInfo { tdcv: Some(9), tdco: Some(13), tdcf: None };
    let data = TimingInfo { bitrate: 2_000_000, ..TIMING };
    if let Some(can) = &mut link.can {
        can.tdc = Some(tdc);
        can.data_timing = Some(data);
    }
    let change = Saved::of(&link).change(&link, Form::Segments);
    // The kernel measures the delay itself in this mode, and takes none.
    assert_eq!(change.tdc, Some(TdcInfo { tdcv: None, ..tdc }));
    assert_eq!(change.ctrlmode, Some((0x220, 0x220)));
    if let Some(can) = &mut link.can {
        can.ctrlmode = 0;
    }
    let change = Saved::of(&link).change(&link, Form::Segments);
    assert_eq!((change.tdc, change.data_timing), (None, None));
}

#[test]
fn the_way_back_by_hand_is_what_ip_link_takes() {
    let mut found = link(ctrlmode::LOOPBACK, Some(TimingInfo { sjw: 3, ..TIMING }));
    if let Some(can) = &mut found.can {
        can.ctrlmode_supported = Some(ctrlmode::LOOPBACK | ctrlmode::LISTEN_ONLY);
    }
    assert_eq!(
        Saved::of(&found).by_hand("can0"),
        "ip link set can0 down; ip link set can0 type can bitrate 500000 sample-point 0.875 sjw 3 \
         listen-only off loopback on; ip link set can0 up"
    );
    let mut down = link(ctrlmode::FD, None);
    down.flags = LinkFlags(0);
    if let Some(can) = &mut down.can {
        can.data_timing = Some(TimingInfo { bitrate: 2_000_000, sample_point: 750, ..TIMING });
    }
    assert_eq!(
        Saved::of(&down).by_hand("can1"),
        "ip link set can1 down; ip link set can1 type can dbitrate 2000000 dsample-point 0.750 \
         dsjw 1 listen-only off fd on"
    );
}
