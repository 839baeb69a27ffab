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

/// As in a container: no sysfs, or one with an interface of the same name outside.
mod where_sysfs_is_hidden {
    use super::*;

    fn named(name: &str) -> Link {
        let mut can = controller(LISTEN);
        can.counters = Some(ErrorCounters { transmit: 0, receive: 0 });
        if let Some(limits) = &mut can.timing_const {
            limits.name = name.to_owned();
        }
        link(can)
    }

    fn hidden(name: &str) -> (Device, Result<Profile, LinkError>) {
        let link = named(name);
        let device = Device::read(Path::new("/nonexistent"), &link);
        let profile = Profile::of(&link, &device);
        (device, profile)
    }

    /// Trap: without its driver's name, PCAN-USB would pass for one that listens.
    #[test]
    fn a_pcan_usb_is_refused_by_what_its_controller_is_called() {
        let (device, profile) = hidden("pcan_usb");
        assert_eq!(device.driver.as_deref(), Some("peak_usb"));
        let error = profile.unwrap_err().to_string();
        assert!(error.contains("hardware revision of this PEAK adapter cannot be read"), "{error}");
    }

    /// Later ones are silent in every revision; their state changes look like frames, too.
    #[test]
    fn later_pcan_adapters_are_known_with_their_traps() {
        for name in
            ["pcan_usb_pro", "pcan_usb_fd", "pcan_usb_pro_fd", "pcan_usb_x6", "pcan_chip_usb"]
        {
            let profile = hidden(name).1.unwrap();
            assert_eq!(profile.driver.as_deref(), Some("peak_usb"), "{name}");
            assert_eq!(profile.evidence, Evidence::Counter, "{name}");
            assert!(profile.settle > Duration::ZERO, "{name}");
        }
    }

    #[test]
    fn what_others_tell_of_a_wrong_rate_is_known() {
        for (name, driver, evidence) in [
            ("kvaser_usb_leaf", "kvaser_usb", Evidence::Errors),
            ("usb_8dev", "usb_8dev", Evidence::Errors),
            ("mcp251x", "mcp251x", Evidence::FramesOnly),
            ("gs_usb", "gs_usb", Evidence::FramesOnly),
        ] {
            let profile = hidden(name).1.unwrap();
            assert_eq!((profile.driver.as_deref(), profile.evidence), (Some(driver), evidence));
        }
    }

    /// sysfs as the kernel lays it out, with the interface `can0`.
    fn sysfs(index: u32, driver: &str, usb: (&str, &str)) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        let at = |path: &str| root.path().join(path);
        for directory in ["class/net/can0", "devices/1-1/1-1:1.0", "drivers"] {
            fs::create_dir_all(at(directory)).unwrap();
        }
        let link = std::os::unix::fs::symlink::<std::path::PathBuf, std::path::PathBuf>;
        link(at("devices/1-1/1-1:1.0"), at("class/net/can0/device")).unwrap();
        link(at("drivers").join(driver), at("devices/1-1/1-1:1.0/driver")).unwrap();
        fs::write(at("class/net/can0/ifindex"), format!("{index}\n")).unwrap();
        fs::write(at("devices/1-1/idProduct"), usb.0).unwrap();
        fs::write(at("devices/1-1/bcdDevice"), usb.1).unwrap();
        root
    }

    #[test]
    fn an_interface_of_the_same_name_outside_is_not_taken_for_this_one() {
        let link = named("pcan_usb");
        let read = |sys: &tempfile::TempDir| Device::read(sys.path(), &link);
        let revision_8 = sysfs(5, "peak_usb", ("000c\n", "0800\n"));
        assert_eq!(read(&revision_8).usb, Some((0x000C, 0x0800)));
        assert!(Profile::of(&link, &read(&revision_8)).is_ok());
        // Another number, or another driver than that of the controller: it is another interface.
        for other in
            [sysfs(6, "peak_usb", ("000c\n", "0800\n")), sysfs(5, "gs_usb", ("606f\n", "0800\n"))]
        {
            assert_eq!(read(&other), device("peak_usb"));
            assert!(Profile::of(&link, &read(&other)).is_err());
        }
        // A family shares the controller: the driver is the one that is seen.
        let card = sysfs(5, "kvaser_pci", ("", ""));
        let device = Device::read(card.path(), &named("sja1000"));
        assert_eq!(device.driver.as_deref(), Some("kvaser_pci"));
    }
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
