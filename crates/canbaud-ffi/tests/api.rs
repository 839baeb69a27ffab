//! The functions as C calls them, in Rust: small enough for Miri.
//!
//! `cargo +nightly miri test -p canbaud-ffi --test api`

use canbaud_ffi::*;
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

fn zeroed_detector() -> canbaud_pulse_detector {
    canbaud_pulse_detector { opaque: [MaybeUninit::new(0); CANBAUD_PULSE_DETECTOR_WORDS] }
}

#[test]
fn storage_that_is_not_initialized_is_refused() {
    let mut detector = zeroed_detector();
    // SAFETY: the pointers are valid or NULL.
    unsafe {
        assert_eq!(canbaud_pulse_detector_push(&mut detector, 1), canbaud_status::NOT_INITIALIZED);
        assert_eq!(canbaud_pulse_detector_push(null_mut(), 1), canbaud_status::NULL_POINTER);
        assert_eq!(canbaud_pulse_detector_init(null_mut()), canbaud_status::NULL_POINTER);
        assert_eq!(canbaud_pulse_detector_init(&mut detector), canbaud_status::OK);
        assert_eq!(canbaud_pulse_detector_push(&mut detector, 1), canbaud_status::OK);
    }
}

#[test]
fn storage_may_move_and_be_copied() {
    let mut detector = zeroed_detector();
    let mut verdict = None;
    // SAFETY: the pointers are valid.
    unsafe {
        assert_eq!(canbaud_pulse_detector_init(&mut detector), canbaud_status::OK);
        assert_eq!(canbaud_pulse_detector_begin(&mut detector, 0, 1), canbaud_status::OK);
        let mut moved = Box::new(detector);
        for at in 1..40 {
            assert_eq!(canbaud_pulse_detector_push(&mut *moved, at * 16), canbaud_status::OK);
        }
        let mut room = core::mem::MaybeUninit::uninit();
        let status = canbaud_pulse_detector_verdict(&mut *moved, room.as_mut_ptr());
        if status == canbaud_status::OK {
            verdict = Some(room.assume_init());
        }
    }
    assert_eq!(verdict.map(|v| v.proven_frames), Some(0));
}

#[test]
fn every_controller_solves_or_says_why() {
    let request = canbaud_timing_request {
        clock_hz: 8_000_000,
        bitrate: 125_000,
        sample_point_permille: 0,
        tolerance_ppm: 0,
    };
    for name in [c"bxcan", c"mcp2515", c"FDCAN", c"sja1000", c"no such controller"] {
        let mut controller = null();
        // SAFETY: the name ends with a zero, the pointers are valid.
        let found = unsafe { canbaud_controller_find(name.as_ptr(), &mut controller) };
        if name == c"no such controller" {
            assert_eq!(found, canbaud_status::UNKNOWN_CONTROLLER);
            continue;
        }
        assert_eq!(found, canbaud_status::OK);
        let mut solution = core::mem::MaybeUninit::uninit();
        let mut words = [canbaud_register_word { name: [0; 24], word: 0 }; CANBAUD_REGISTERS_MAX];
        let mut count = 0;
        // SAFETY: all pointers are valid, and there is the room that is said.
        unsafe {
            let status = canbaud_timing_solve(controller, 0, &request, solution.as_mut_ptr());
            assert_eq!(status, canbaud_status::OK, "{name:?}");
            let timing = solution.assume_init().timing;
            let room = words.len();
            let words = words.as_mut_ptr();
            let status =
                canbaud_timing_registers(controller, &timing, null(), words, room, &mut count);
            assert_eq!(status, canbaud_status::OK, "{name:?}");
        }
        assert!((1..=CANBAUD_REGISTERS_MAX).contains(&count), "{name:?}");
    }
}

unsafe extern "C" fn store(
    context: *mut core::ffi::c_void,
    configuration: canbaud_lss_configuration,
) -> u8 {
    // SAFETY: the test gives a configuration as context.
    unsafe { context.cast::<canbaud_lss_configuration>().write(configuration) };
    0
}

#[test]
fn lss_slave_stores_by_the_callback() {
    let mut slave = canbaud_lss_slave { opaque: [MaybeUninit::new(0); CANBAUD_LSS_SLAVE_WORDS] };
    let address =
        canbaud_lss_address { vendor_id: 1, product_code: 2, revision_number: 3, serial_number: 4 };
    let delivered = canbaud_lss_configuration { node_id: 255, bitrate: 500_000 };
    let mut kept = canbaud_lss_configuration { node_id: 0, bitrate: 1 };
    let command = |bytes: [u8; 2]| {
        let mut data = [0; 64];
        data[..2].copy_from_slice(&bytes);
        canbaud_frame { id: 0x7E5, extended: 0, kind: 0, dlc: 8, esi: 0, data }
    };
    // SAFETY: all pointers are valid, and the callback writes to its context only.
    unsafe {
        assert_eq!(canbaud_lss_slave_init(&mut slave, &address, &delivered, 0), canbaud_status::OK);
        // Switch state global to configuration, configure node-ID 7, store.
        for bytes in [[4, 1], [17, 7], [23, 0]] {
            let context = (&raw mut kept).cast();
            let status =
                canbaud_lss_slave_handle(&mut slave, 0, &command(bytes), Some(store), context);
            assert_eq!(status, canbaud_status::OK);
        }
        let status = canbaud_lss_slave_handle(&mut slave, 0, null(), None, null_mut());
        assert_eq!(status, canbaud_status::NULL_POINTER);
    }
    assert_eq!(kept, canbaud_lss_configuration { node_id: 7, bitrate: 500_000 });
}

#[test]
fn scan_takes_a_list_of_candidates() {
    let mut scan = canbaud_scan { opaque: [MaybeUninit::new(0); CANBAUD_SCAN_WORDS] };
    let capabilities = canbaud_capabilities {
        bitrate_min: 10_000,
        bitrate_max: 1_000_000,
        evidence: 0,
        fd: 0,
        reconfiguration_us: 100,
        latency_us: 0,
    };
    let candidates =
        [250_000, 500_000].map(|nominal| canbaud_candidate { nominal, data: 0, wide: 0 });
    let mut action = canbaud_scan_action {
        kind: canbaud_scan_action_kind::NONE,
        candidate: canbaud_candidate::default(),
    };
    // SAFETY: all pointers are valid, and there are two candidates.
    unsafe {
        let list = candidates.as_ptr();
        let status = canbaud_scan_init(&mut scan, list, 2, &capabilities, null());
        assert_eq!(status, canbaud_status::OK);
        assert_eq!(canbaud_scan_poll(&mut scan, 0, &mut action), canbaud_status::OK);
    }
    assert_eq!(action.kind, canbaud_scan_action_kind::LISTEN);
    assert_eq!(action.candidate.nominal, 500_000);
}
