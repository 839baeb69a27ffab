//! The listen-only scan.

use crate::frame::{canbaud_frame, from_c};
use crate::status::{canbaud_status, status_of};
use crate::storage::{self, optional, read, write};
use canbaud::detect::scan::{
    Acknowledgement, Action, Candidate, Candidates, Capabilities, Capture, Configured, End,
    ErrorClass, ErrorPlace, ErrorSeen, Evidence, FdSeen, FdSupport, FrameSeen, Observation, Origin,
    Outcome, Policy, RateChoice, Scan, Settings,
};
use canbaud::units::{Bitrate, Micros, Permille};
use core::mem::MaybeUninit;

/// Most candidates of a scan.
pub const CANBAUD_SCAN_CANDIDATES_MAX: usize = 16;

/// Words of a canbaud_scan, of eight bytes each.
pub const CANBAUD_SCAN_WORDS: usize = 352;

/// No time stamp; as a deadline: never.
pub const CANBAUD_NEVER: u64 = u64::MAX;

type Machine = Scan<CANBAUD_SCAN_CANDIDATES_MAX>;

/// The scan machine: told what was heard, says what to do next. It does no I/O and has no clock:
/// times are microseconds of a clock of the caller that never goes back. Its content is private.
/// Zeros are storage that is not initialized.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct canbaud_scan {
    /// Private.
    pub opaque: [MaybeUninit<u64>; CANBAUD_SCAN_WORDS],
}

/// What a controller tells about a wrong rate.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_evidence {
    /// Protocol errors, one by one.
    ERRORS = 0,
    /// An error counter only.
    COUNTER = 1,
    /// Good frames only.
    FRAMES_ONLY = 2,
}

/// What the controller can do.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_capabilities {
    /// Lowest nominal bit rate in bit/s.
    pub bitrate_min: u32,
    /// Highest nominal bit rate in bit/s.
    pub bitrate_max: u32,
    /// What it tells about a wrong rate: a canbaud_evidence.
    pub evidence: u8,
    /// 1 if it receives CAN FD frames.
    pub fd: u8,
    /// Longest time that a change of the rate takes, in microseconds.
    pub reconfiguration_us: u32,
    /// Longest time until something that was heard is told, in microseconds.
    pub latency_us: u32,
}

/// A rate to listen at.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct canbaud_candidate {
    /// Nominal bit rate in bit/s.
    pub nominal: u32,
    /// Data bit rate in bit/s; 0: classic frames.
    pub data: u32,
    /// 1: with the widest capture that the bit timing offers (large SJW, long PHASE_SEG2).
    pub wide: u8,
}

/// Policies of a scan.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_scan_policy {
    /// Weighs evidence.
    WEIGHING = 0,
    /// The procedure of Koppe's paper.
    KOPPE = 1,
    /// Each candidate for a fixed time.
    FIXED_DWELL = 2,
}

/// Settings of a scan; a 0 stands for the default.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_scan_settings {
    /// A canbaud_scan_policy.
    pub policy: u8,
    /// 1: never gives up; 0: at its bound.
    pub endless: u8,
    /// Share of frames that may be destroyed at the right rate, in thousandths, up to 1000.
    pub destroyed_permille: u16,
    /// The bit rate of the last time, which is tried first; 0: none.
    pub last_known: u32,
    /// Longest pause between frames to sit out, in microseconds; 0: 1 s.
    pub pause_us: u32,
    /// How often each candidate may be given that long; 0: 3.
    pub rounds: u32,
    /// How long the fixed dwell is, in microseconds; 0: 600 ms.
    pub dwell_us: u32,
}

/// What a scan wants done.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_scan_action_kind {
    /// Nothing: sleep until the deadline or until something is heard.
    NONE = 0,
    /// Set the controller to the candidate and listen without transmitting, then call
    /// canbaud_scan_listening; or canbaud_scan_refused if the controller cannot.
    LISTEN = 1,
    /// Stop listening: there is an outcome.
    STOP = 2,
}

/// What a scan wants done, and with what.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_scan_action {
    /// What.
    pub kind: canbaud_scan_action_kind,
    /// The candidate to listen at.
    pub candidate: canbaud_candidate,
}

/// Kinds of protocol errors.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_error_class {
    /// Six equal bits.
    STUFF = 0,
    /// A bit of fixed form has the wrong level.
    FORM = 1,
    /// The CRC does not match.
    CRC = 2,
    /// A bit error.
    BIT = 3,
    /// Nobody acknowledged.
    ACKNOWLEDGE = 4,
    /// The controller does not tell.
    UNKNOWN = 5,
}

/// Places of protocol errors.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_error_place {
    /// Before or in the CRC sequence.
    BEFORE_CRC_END = 0,
    /// The CRC delimiter.
    CRC_DELIMITER = 1,
    /// The ACK slot.
    ACK_SLOT = 2,
    /// The ACK delimiter.
    ACK_DELIMITER = 3,
    /// End of frame.
    END_OF_FRAME = 4,
    /// Flags, delimiters, intermission.
    BETWEEN = 5,
    /// The controller does not tell.
    UNKNOWN = 6,
    /// The identifier and the bits up to RTR.
    ARBITRATION = 7,
}

/// Outcomes of a scan.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_scan_outcome_kind {
    /// This is the rate.
    FOUND = 0,
    /// Nobody sends.
    SILENT = 1,
    /// There is traffic, at none of the rates.
    NO_CANDIDATE_FITS = 2,
    /// Nothing was heard, and this controller cannot tell a wrong rate from a silent bus.
    STILL_OPEN = 3,
    /// The controller can be set to none of the candidates.
    REFUSED = 4,
}

/// What is known about CAN FD on the bus.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_fd_seen {
    /// No CAN FD frame was received.
    NO = 0,
    /// CAN FD frames without a bit rate switch.
    NEVER_SWITCHED = 1,
    /// CAN FD frames with a bit rate switch.
    SWITCHED = 2,
    /// Frames that a classic controller cannot read behind the arbitration field.
    SUSPECTED = 3,
}

/// The outcome of a scan. What the kind does not speak of is 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_scan_outcome {
    /// What came of it.
    pub kind: canbaud_scan_outcome_kind,
    /// What is known about CAN FD.
    pub fd: canbaud_fd_seen,
    /// The candidate that was found; where none fits, one that may be the nominal rate of a CAN FD
    /// bus.
    pub candidate: canbaud_candidate,
    /// The nominal bit rate that the controller was really set to.
    pub nominal: u32,
    /// Frames received at this rate.
    pub frames: u32,
    /// Bursts of protocol errors met at this rate.
    pub errors: u32,
    /// Candidates listened to.
    pub visits: u32,
    /// From the first poll to the verdict, in microseconds.
    pub elapsed_us: u64,
    /// 1 if frames were destroyed at the ACK delimiter: nobody acknowledges.
    pub unacknowledged: u8,
}

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
        let class = match class {
            0 => ErrorClass::Stuff,
            1 => ErrorClass::Form,
            2 => ErrorClass::Crc,
            3 => ErrorClass::Bit,
            4 => ErrorClass::Acknowledge,
            5 => ErrorClass::Unknown,
            _ => return Err(canbaud_status::OUT_OF_RANGE),
        };
        let place = match place {
            0 => ErrorPlace::BeforeCrcEnd,
            1 => ErrorPlace::CrcDelimiter,
            2 => ErrorPlace::AckSlot,
            3 => ErrorPlace::AckDelimiter,
            4 => ErrorPlace::EndOfFrame,
            5 => ErrorPlace::Between,
            6 => ErrorPlace::Unknown,
            7 => ErrorPlace::Arbitration,
            _ => return Err(canbaud_status::OUT_OF_RANGE),
        };
        let seen = ErrorSeen { class, place, received: stamp(received_us) };
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

/// # Safety
/// `candidates` must point to `count` candidates, or be NULL.
unsafe fn list(
    candidates: *const canbaud_candidate,
    count: usize,
) -> Result<Candidates<CANBAUD_SCAN_CANDIDATES_MAX>, canbaud_status> {
    if count == 0 {
        return Candidates::canopen().map_err(|_| canbaud_status::OUT_OF_RANGE);
    }
    if candidates.is_null() {
        return Err(canbaud_status::NULL_POINTER);
    }
    if count > CANBAUD_SCAN_CANDIDATES_MAX {
        return Err(canbaud_status::OUT_OF_RANGE);
    }
    // SAFETY: not NULL, and the caller says that there are so many.
    let given = unsafe { core::slice::from_raw_parts(candidates, count) };
    let mut list = Candidates::new();
    for candidate in given {
        let nominal = Bitrate::new(candidate.nominal).ok_or(canbaud_status::OUT_OF_RANGE)?;
        let capture = if candidate.wide == 0 { Capture::Usual } else { Capture::Wide };
        let candidate = Candidate { nominal, data: Bitrate::new(candidate.data), capture };
        list.push(candidate).map_err(|_| canbaud_status::OUT_OF_RANGE)?;
    }
    Ok(list)
}

fn stamp(received_us: u64) -> Option<Micros> {
    (received_us != CANBAUD_NEVER).then_some(Micros(received_us))
}

fn capabilities_from_c(
    capabilities: &canbaud_capabilities,
) -> Result<Capabilities<'static>, canbaud_status> {
    let rate = |rate| Bitrate::new(rate).ok_or(canbaud_status::OUT_OF_RANGE);
    let (low, high) = (rate(capabilities.bitrate_min)?, rate(capabilities.bitrate_max)?);
    Ok(Capabilities {
        rates: RateChoice::Between(low, high),
        evidence: match capabilities.evidence {
            0 => Evidence::Errors,
            1 => Evidence::Counter,
            2 => Evidence::FramesOnly,
            _ => return Err(canbaud_status::OUT_OF_RANGE),
        },
        fd: if capabilities.fd == 0 { FdSupport::Classic } else { FdSupport::Fd },
        reconfiguration: Micros(capabilities.reconfiguration_us.into()),
        latency: Micros(capabilities.latency_us.into()),
    })
}

fn settings_from_c(given: &canbaud_scan_settings) -> Result<Settings, canbaud_status> {
    let mut settings = Settings {
        policy: match given.policy {
            0 => Policy::Weighing,
            1 => Policy::Koppe,
            2 => Policy::FixedDwell,
            _ => return Err(canbaud_status::OUT_OF_RANGE),
        },
        last_known: Bitrate::new(given.last_known),
        end: if given.endless == 0 { End::AtBound } else { End::Never },
        ..Settings::default()
    };
    if given.destroyed_permille != 0 {
        let share = Permille::new(given.destroyed_permille);
        settings.destroyed = share.ok_or(canbaud_status::OUT_OF_RANGE)?;
    }
    if given.pause_us != 0 {
        settings.pause = Micros(given.pause_us.into());
    }
    if given.rounds != 0 {
        settings.rounds = given.rounds;
    }
    if given.dwell_us != 0 {
        settings.dwell = Micros(given.dwell_us.into());
    }
    Ok(settings)
}

fn candidate_to_c(candidate: &Candidate) -> canbaud_candidate {
    canbaud_candidate {
        nominal: candidate.nominal.bits_per_second(),
        data: candidate.data.map_or(0, Bitrate::bits_per_second),
        wide: u8::from(candidate.capture == Capture::Wide),
    }
}

fn outcome_to_c(outcome: &Outcome) -> canbaud_scan_outcome {
    let mut said = canbaud_scan_outcome {
        kind: canbaud_scan_outcome_kind::FOUND,
        fd: canbaud_fd_seen::NO,
        candidate: canbaud_candidate::default(),
        nominal: 0,
        frames: 0,
        errors: 0,
        visits: 0,
        elapsed_us: 0,
        unacknowledged: 0,
    };
    match outcome {
        Outcome::Found(found) => {
            said.fd = match found.fd {
                FdSeen::No => canbaud_fd_seen::NO,
                FdSeen::NeverSwitched => canbaud_fd_seen::NEVER_SWITCHED,
                FdSeen::Switched => canbaud_fd_seen::SWITCHED,
                FdSeen::Suspected => canbaud_fd_seen::SUSPECTED,
            };
            said.candidate = candidate_to_c(&found.candidate);
            said.nominal = found.nominal().bits_per_second();
            said.frames = found.frames;
            said.errors = found.errors;
            said.visits = found.visits;
            said.elapsed_us = found.elapsed.0;
            said.unacknowledged = u8::from(found.acknowledgement == Acknowledgement::Missing);
        }
        Outcome::Silent => said.kind = canbaud_scan_outcome_kind::SILENT,
        Outcome::NoCandidateFits(misfit) => {
            said.kind = canbaud_scan_outcome_kind::NO_CANDIDATE_FITS;
            if let Some(candidate) = &misfit.perhaps_fd {
                said.fd = canbaud_fd_seen::SUSPECTED;
                said.candidate = candidate_to_c(candidate);
            }
        }
        Outcome::StillOpen => said.kind = canbaud_scan_outcome_kind::STILL_OPEN,
        Outcome::Refused => said.kind = canbaud_scan_outcome_kind::REFUSED,
    }
    said
}
