//! The functions of the listen-only scan.

use super::convert::{
    candidate_to_c, capabilities_from_c, error_from_c, list, outcome_to_c, settings_from_c, stamp,
};
use super::*;
use crate::frame::{canbaud_frame, from_c};
use crate::status::{canbaud_status, status_of};
use crate::storage::{self, optional, read, write};
use canbaud::detect::scan::{Action, Configured, FrameSeen, Observation, Origin, Scan, Settings};
use canbaud::units::{Bitrate, Micros};

type Machine = Scan<CANBAUD_SCAN_CANDIDATES_MAX>;

/// Sets up a scan. `candidates` are `count` rates to try; with NULL and 0 those of CANopen.
/// `settings` may be NULL for the defaults.
///
/// # Safety
/// `candidates` must point to `count` candidates; the others must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_init(
    scan: *mut canbaud_scan,
    candidates: *const canbaud_candidate,
    count: usize,
    capabilities: *const canbaud_capabilities,
    settings: *const canbaud_scan_settings,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let (capabilities, settings) = unsafe { (read(capabilities)?, optional(settings)) };
        // SAFETY: as the caller says.
        let list = unsafe { list(candidates, count) }?;
        let settings = settings.map_or(Ok(Settings::default()), settings_from_c)?;
        let machine = Scan::new(&list, &capabilities_from_c(capabilities)?, settings);
        // SAFETY: the struct is its words.
        unsafe { storage::init(scan.cast::<[u64; CANBAUD_SCAN_WORDS]>(), machine) }
    })
}

/// What to do now. To be called again until it wants nothing, after everything that was told, and
/// when the deadline has come.
///
/// # Safety
/// `scan` and `action` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_poll(
    scan: *mut canbaud_scan,
    now_us: u64,
    action: *mut canbaud_scan_action,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let wanted = unsafe { of(scan) }?.poll(Micros(now_us));
        let (kind, candidate) = match wanted {
            None => (canbaud_scan_action_kind::NONE, canbaud_candidate::default()),
            Some(Action::Listen(to)) => (canbaud_scan_action_kind::LISTEN, candidate_to_c(&to)),
            Some(Action::Stop) => (canbaud_scan_action_kind::STOP, canbaud_candidate::default()),
        };
        // SAFETY: as the caller says.
        unsafe { write(action, canbaud_scan_action { kind, candidate }) }
    })
}

/// When canbaud_scan_poll has to be called at the latest; CANBAUD_NEVER: only when something is
/// heard.
///
/// # Safety
/// `scan` and `deadline_us` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_deadline(
    scan: *mut canbaud_scan,
    deadline_us: *mut u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let deadline = unsafe { of(scan) }?.deadline().map_or(CANBAUD_NEVER, |at| at.0);
        // SAFETY: as the caller says.
        unsafe { write(deadline_us, deadline) }
    })
}

/// The controller listens since `now_us`, set to these bit rates in bit/s (`data` is 0 for classic
/// CAN).
///
/// # Safety
/// `scan` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_listening(
    scan: *mut canbaud_scan,
    now_us: u64,
    nominal: u32,
    data: u32,
) -> canbaud_status {
    status_of(|| {
        let nominal = Bitrate::new(nominal).ok_or(canbaud_status::OUT_OF_RANGE)?;
        let configured = Configured { nominal, data: Bitrate::new(data) };
        // SAFETY: as the caller says.
        unsafe { of(scan) }?.handle_listening(Micros(now_us), configured);
        Ok(())
    })
}

/// The controller cannot be set to the candidate.
///
/// # Safety
/// `scan` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_refused(
    scan: *mut canbaud_scan,
    now_us: u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(scan) }?.handle_refused(Micros(now_us));
        Ok(())
    })
}

/// A frame was received from the bus, at `received_us` or, with CANBAUD_NEVER, some time before
/// now.
///
/// # Safety
/// `scan` and `frame` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_frame(
    scan: *mut canbaud_scan,
    now_us: u64,
    frame: *const canbaud_frame,
    received_us: u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let frame = from_c(unsafe { read(frame) }?)?;
        let seen = FrameSeen { frame, origin: Origin::Bus, received: stamp(received_us) };
        // SAFETY: as the caller says.
        unsafe { tell(scan, now_us, &Observation::Frame(seen)) }
    })
}

/// The controller reported a protocol error: a canbaud_error_class at a canbaud_error_place, at
/// `received_us` or, with CANBAUD_NEVER, some time before now.
///
/// # Safety
/// `scan` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_error(
    scan: *mut canbaud_scan,
    now_us: u64,
    class: u8,
    place: u8,
    received_us: u64,
) -> canbaud_status {
    status_of(|| {
        let seen = error_from_c(class, place, received_us)?;
        // SAFETY: as the caller says.
        unsafe { tell(scan, now_us, &Observation::Error(seen)) }
    })
}

/// The receive error counter, of a controller that counts but does not report errors.
///
/// # Safety
/// `scan` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_receive_errors(
    scan: *mut canbaud_scan,
    now_us: u64,
    counter: u16,
) -> canbaud_status {
    // SAFETY: as the caller says.
    status_of(|| unsafe { tell(scan, now_us, &Observation::ReceiveErrors(counter)) })
}

/// Edges on the line since the last call, where they are counted.
///
/// # Safety
/// `scan` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_edges(
    scan: *mut canbaud_scan,
    now_us: u64,
    edges: u32,
) -> canbaud_status {
    // SAFETY: as the caller says.
    status_of(|| unsafe { tell(scan, now_us, &Observation::Edges(edges)) })
}

/// Frames or errors were lost: the FIFO overran.
///
/// # Safety
/// `scan` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_lost(scan: *mut canbaud_scan, now_us: u64) -> canbaud_status {
    // SAFETY: as the caller says.
    status_of(|| unsafe { tell(scan, now_us, &Observation::Lost) })
}

/// What came of the scan; CANBAUD_STATUS_NOTHING before its end.
///
/// # Safety
/// `scan` and `outcome` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_scan_outcome_get(
    scan: *mut canbaud_scan,
    outcome: *mut canbaud_scan_outcome,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let found = unsafe { of(scan) }?.outcome().ok_or(canbaud_status::NOTHING)?;
        // SAFETY: as the caller says.
        unsafe { write(outcome, outcome_to_c(found)) }
    })
}

/// # Safety
/// As for [`storage::get`].
unsafe fn of<'a>(scan: *mut canbaud_scan) -> Result<&'a mut Machine, canbaud_status> {
    // SAFETY: the struct is its words.
    unsafe { storage::get::<Machine, CANBAUD_SCAN_WORDS>(scan.cast()) }
}

/// # Safety
/// As for [`storage::get`].
unsafe fn tell(
    scan: *mut canbaud_scan,
    now_us: u64,
    heard: &Observation,
) -> Result<(), canbaud_status> {
    // SAFETY: as the caller says.
    unsafe { of(scan) }?.handle(Micros(now_us), heard);
    Ok(())
}
