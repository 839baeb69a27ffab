use super::*;
use crate::socketcan::mock::{CHOSEN, Mock};
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

/// What is said of an interface that a driver with `trouble` puts back.
fn said_of(trouble: fn(&Mock)) -> Option<String> {
    let mut kernel = Mock::up(CHOSEN);
    let found = kernel.now();
    trouble(&kernel);
    let restored = Saved::of(&found).restore(&mut kernel, &found);
    // In the right state it is up again, in no other.
    assert_eq!(kernel.now().flags.is_up(), restored.is_ok());
    restored.err().map(|error| error.to_string())
}

#[test]
fn another_sample_point_or_sjw_is_not_what_was_found() {
    let lead = "can0 could not be put back as it was found: its";
    assert_eq!(said_of(|_| ()), None);
    let said = said_of(Mock::take_rates_only).unwrap();
    assert_eq!(said, format!("{lead} sample point is 87.5 %, it was 75.0 %"));
    let said = said_of(Mock::take_no_sjw).unwrap();
    assert_eq!(said, format!("{lead} SJW is 1 TQ of 250 ns, it was 3 TQ of 250 ns"));
}

#[test]
fn the_same_times_in_other_quanta_are_what_was_found() {
    let found = Saved::of(&link(0, Some(CHOSEN)));
    // 8 TQ of 500 ns cannot have the SJW of 750 ns; one of 16 TQ in another split can.
    let split = TimingInfo { prop_seg: 5, phase_seg1: 6, ..CHOSEN };
    assert_eq!(found.difference(&link(0, Some(split))), None);
    let halved =
        TimingInfo { tq: 500, prop_seg: 3, phase_seg1: 2, phase_seg2: 2, brp: 4, ..CHOSEN };
    let said = found.difference(&link(0, Some(halved))).unwrap();
    assert_eq!(said, "its SJW is 3 TQ of 500 ns, it was 3 TQ of 250 ns");
    let finer = TimingInfo { tq: 125, prop_seg: 12, phase_seg1: 11, brp: 1, ..CHOSEN };
    let finer = TimingInfo { phase_seg2: 8, sjw: 6, ..finer };
    assert_eq!(found.difference(&link(0, Some(finer))), None);
}
