use super::*;
use crate::socketcan::netlink::{ErrorCounters, LinkFlags, TimingConst};

fn link(can: CanInfo) -> Link {
    Link {
        index: 5,
        name: "can0".to_owned(),
        flags: LinkFlags(0),
        hardware: 280,
        mtu: 16,
        txqueuelen: 10,
        kind: Some("can".to_owned()),
        can: Some(can),
    }
}

/// A controller with these control modes.
fn controller(supported: u32) -> CanInfo {
    CanInfo {
        timing_const: Some(TimingConst {
            name: "test".to_owned(),
            tseg1: (1, 16),
            tseg2: (1, 8),
            sjw_max: 4,
            brp: (1, 64),
            brp_inc: 1,
        }),
        clock: Some(8_000_000),
        ctrlmode_supported: Some(supported),
        ..CanInfo::default()
    }
}

fn device(driver: &str) -> Device {
    Device { driver: Some(driver.to_owned()), usb: None }
}

const LISTEN: u32 = ctrlmode::LISTEN_ONLY;
const REPORT: u32 = ctrlmode::LISTEN_ONLY | ctrlmode::BERR_REPORTING;

/// Trap: an adapter keeps frames in a queue of its own over a change of rate.
#[test]
fn what_has_a_queue_of_its_own_is_given_time_to_empty_it() {
    let settle = |device| Profile::of(&link(controller(LISTEN)), &device).unwrap().settle;
    let candle = Device { driver: Some("gs_usb".to_owned()), usb: Some((0x606F, 0x0100)) };
    assert!(settle(candle) > Duration::from_millis(4));
    assert!(settle(device("slcan")) > Duration::from_millis(4));
    assert_eq!(settle(device("flexcan")), Duration::ZERO);
}

#[test]
fn drivers_without_listen_only_are_refused_with_the_reason() {
    let error = Profile::of(&link(controller(0)), &device("ems_usb")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "can0 cannot listen without disturbing the bus: its driver (ems_usb) has no listen-only mode"
    );
    // A kernel that does not say what is supported: what is known of the driver says it.
    let silent = CanInfo { ctrlmode_supported: None, ..controller(0) };
    assert!(Profile::of(&link(silent.clone()), &device("mcba_usb")).is_err());
    assert!(Profile::of(&link(silent), &device("sja1000_isa")).is_ok());
}

/// Trap: PCAN-USB up to revision 3 offers listen-only and stays active.
#[test]
fn a_pcan_usb_that_only_claims_to_be_silent_is_refused() {
    let peak = |usb| Device { driver: Some("peak_usb".to_owned()), usb };
    let can = || CanInfo {
        counters: Some(ErrorCounters { transmit: 0, receive: 0 }),
        ..controller(LISTEN)
    };
    for revision in [0x0000, 0x0300, 0x03FF] {
        let error = Profile::of(&link(can()), &peak(Some((0x000C, revision)))).unwrap_err();
        assert!(error.to_string().contains("no silent mode"), "{error}");
    }
    assert!(Profile::of(&link(can()), &peak(None)).is_err());
    let profile = Profile::of(&link(can()), &peak(Some((0x000C, 0x0400)))).unwrap();
    assert_eq!(profile.evidence, Evidence::Counter);
    // PCAN-USB Pro has another driver part, where the revision says nothing.
    assert!(Profile::of(&link(can()), &peak(Some((0x000D, 0x0100)))).is_ok());
}

#[test]
fn what_a_driver_tells_of_a_wrong_rate() {
    let counters = Some(ErrorCounters { transmit: 0, receive: 0 });
    for (driver, supported, counters, want) in [
        ("kvaser_pci", REPORT, None, Evidence::Errors),
        ("m_can_platform", REPORT, counters, Evidence::Errors),
        ("gs_usb", REPORT, counters, Evidence::Errors),
        // Linux 6.1: no error reporting.
        ("gs_usb", LISTEN, None, Evidence::FramesOnly),
        ("kvaser_usb", LISTEN, counters, Evidence::Errors),
        ("mcp251x", LISTEN, None, Evidence::FramesOnly),
        ("slcan", LISTEN, None, Evidence::FramesOnly),
        ("some_new_driver", REPORT, None, Evidence::Errors),
        ("some_new_driver", LISTEN, counters, Evidence::Counter),
        ("some_new_driver", LISTEN, None, Evidence::FramesOnly),
    ] {
        let can = CanInfo { counters, ..controller(supported) };
        let profile = Profile::of(&link(can), &device(driver)).unwrap();
        assert_eq!(profile.evidence, want, "{driver}");
    }
}

#[test]
fn interfaces_without_a_bit_rate_are_no_use() {
    let virtual_can = Link { kind: Some("vcan".to_owned()), can: None, ..link(controller(0)) };
    assert!(matches!(
        Profile::of(&virtual_can, &Device::default()),
        Err(LinkError::Virtual { .. })
    ));
    let ethernet = Link { hardware: 1, kind: None, can: None, ..link(controller(0)) };
    assert!(matches!(Profile::of(&ethernet, &Device::default()), Err(LinkError::NotCan { .. })));
}

#[test]
fn rates_follow_from_clock_and_limits() {
    let profile = Profile::of(&link(controller(LISTEN)), &device("sja1000_isa")).unwrap();
    // 8 MHz / 64 / 25.
    assert_eq!(profile.range.0.bits_per_second(), 5_000);
    assert_eq!(profile.range.1.bits_per_second(), 1_000_000);
    let slcan = CanInfo {
        bitrates: SLCAN.to_vec(),
        ctrlmode_supported: Some(LISTEN),
        ..CanInfo::default()
    };
    let slcan = link(slcan);
    let device = Device::read(Path::new("/nonexistent"), &slcan);
    assert_eq!(device.driver.as_deref(), Some("slcan"));
    let profile = Profile::of(&slcan, &device).unwrap();
    assert_eq!(profile.rates.len(), 9);
}
