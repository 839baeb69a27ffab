//! What the listen-only scan takes and says, as C has it.

use core::mem::MaybeUninit;

/// Most candidates of a scan.
pub const CANBAUD_SCAN_CANDIDATES_MAX: usize = 16;

/// Words of a canbaud_scan, of eight bytes each.
pub const CANBAUD_SCAN_WORDS: usize = 352;

/// No time stamp; as a deadline: never.
pub const CANBAUD_NEVER: u64 = u64::MAX;

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
