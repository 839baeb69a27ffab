//! The rate from edges.

use crate::status::{canbaud_status, status_of};
use crate::storage;
use canbaud::detect::{BitTime, DataPhase, Need, Phase, PulseDetector, Verdict};
use canbaud::units::Timebase;
use canbaud::wire::{Logic, Polarity};
use core::mem::MaybeUninit;

/// Words of a canbaud_pulse_detector, of eight bytes each.
pub const CANBAUD_PULSE_DETECTOR_WORDS: usize = 192;

/// Finds and proves the bit rate of a bus from its edges; holds any classic frame and short CAN FD
/// frames. Its content is private. Zeros are storage that is not initialized.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct canbaud_pulse_detector {
    /// Private.
    pub opaque: [MaybeUninit<u64>; CANBAUD_PULSE_DETECTOR_WORDS],
}

/// Levels of a line.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_level {
    /// Below the threshold: dominant on RXD.
    LOW = 0,
    /// Above the threshold: recessive on RXD.
    HIGH = 1,
}

/// What a detector says.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_verdict_kind {
    /// There is no activity.
    NO_TRAFFIC = 0,
    /// There were edges, but no complete frame between two stretches of idle yet.
    NEEDS_COMPLETE_FRAME = 1,
    /// The edges fit no bit time: noise, another bus, or too coarse a clock.
    NEEDS_CLEAN_FRAME = 2,
    /// A bit has fewer ticks than the detector can resolve.
    NEEDS_FINER_CLOCK = 3,
    /// A rate fits, but the proof is too weak; another, different frame decides.
    NEEDS_ANOTHER_FRAME = 4,
    /// The rate is proven.
    FOUND = 5,
    /// Two nominal rates are proven on one line: `nominal` and `other`.
    CONFLICT = 6,
    /// Two data rates are proven on one line: `data` and `other`.
    DATA_CONFLICT = 7,
}

/// What is known about the data phase of CAN FD.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_data_phase {
    /// No CAN FD frame was proven.
    NO_FD = 0,
    /// CAN FD frames were proven, none switched its bit rate.
    NEVER_SWITCHED = 1,
    /// `data` is the bit time of the data phase.
    SWITCHED = 2,
}

/// A bit time with its uncertainty.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct canbaud_bit_time {
    /// Timer ticks per bit, times 2^20.
    pub ticks_q20: u64,
    /// One standard deviation in 10^-9.
    pub uncertainty_ppb: u32,
}

/// A verdict. What the kind does not speak of is 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_verdict {
    /// What the detector says.
    pub kind: canbaud_verdict_kind,
    /// Bit time of the arbitration phase.
    pub nominal: canbaud_bit_time,
    /// What is known about the data phase.
    pub data_phase: canbaud_data_phase,
    /// Bit time of the data phase.
    pub data: canbaud_bit_time,
    /// The second bit time of a conflict.
    pub other: canbaud_bit_time,
    /// Frames whose CRC and form were right at this rate.
    pub proven_frames: u32,
    /// The probability that the rate is wrong is at most 2 to the power of minus this.
    pub proof_bits: u32,
    /// 1 if the line is inverted: high is dominant.
    pub inverted: u8,
}

type Detector = PulseDetector<160>;

/// Sets up a detector before its first edge.
///
/// # Safety
/// `detector` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_pulse_detector_init(
    detector: *mut canbaud_pulse_detector,
) -> canbaud_status {
    // SAFETY: as the caller says; the struct is its words.
    status_of(|| unsafe {
        storage::init(detector.cast::<[u64; CANBAUD_PULSE_DETECTOR_WORDS]>(), Detector::new())
    })
}

/// Unbroken recording begins at tick `at` with the line at `level`, a canbaud_level; also after a
/// pause or a lost edge.
///
/// # Safety
/// `detector` must be valid or NULL, and nothing else may use it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_pulse_detector_begin(
    detector: *mut canbaud_pulse_detector,
    at: u64,
    level: u8,
) -> canbaud_status {
    status_of(|| {
        let level = level_from_c(level)?;
        // SAFETY: as the caller says.
        unsafe { of(detector) }?.begin(at, level);
        Ok(())
    })
}

/// An edge at tick `at`, later than the one before; the level toggles.
///
/// Mostly a few hundred instructions; the edge that ends a frame pays for the proof.
///
/// # Safety
/// `detector` must be valid or NULL, and nothing else may use it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_pulse_detector_push(
    detector: *mut canbaud_pulse_detector,
    at: u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(detector) }?.push(at);
        Ok(())
    })
}

/// The line has not changed from the last edge to tick `at`, and the recording ends or pauses:
/// canbaud_pulse_detector_begin comes before the next edge.
///
/// # Safety
/// `detector` must be valid or NULL, and nothing else may use it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_pulse_detector_finish(
    detector: *mut canbaud_pulse_detector,
    at: u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(detector) }?.finish(at);
        Ok(())
    })
}

/// What is known so far.
///
/// # Safety
/// `detector` and `verdict` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_pulse_detector_verdict(
    detector: *mut canbaud_pulse_detector,
    verdict: *mut canbaud_verdict,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let found = unsafe { of(detector) }?.verdict();
        // SAFETY: as the caller says.
        unsafe { storage::write(verdict, to_c(&found)) }
    })
}

/// The bit rate of a bit time in thousandths of a bit/s, for a timer of `ticks` ticks in `seconds`
/// seconds; 0 if it cannot be said.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_bit_time_millibits(
    bit: canbaud_bit_time,
    ticks: u64,
    seconds: u64,
) -> u64 {
    let bit = BitTime { ticks_q20: bit.ticks_q20, uncertainty_ppb: bit.uncertainty_ppb };
    let timer = Timebase::new(ticks, seconds);
    timer.and_then(|timer| bit.millibits_per_second(timer)).unwrap_or(0)
}

/// # Safety
/// As for [`storage::get`].
unsafe fn of<'a>(
    detector: *mut canbaud_pulse_detector,
) -> Result<&'a mut Detector, canbaud_status> {
    // SAFETY: the struct is its words.
    unsafe { storage::get::<Detector, CANBAUD_PULSE_DETECTOR_WORDS>(detector.cast()) }
}

pub(crate) fn level_from_c(level: u8) -> Result<Logic, canbaud_status> {
    match level {
        0 => Ok(Logic::Low),
        1 => Ok(Logic::High),
        _ => Err(canbaud_status::OUT_OF_RANGE),
    }
}

fn bit(bit: BitTime) -> canbaud_bit_time {
    canbaud_bit_time { ticks_q20: bit.ticks_q20, uncertainty_ppb: bit.uncertainty_ppb }
}

pub(crate) fn to_c(verdict: &Verdict) -> canbaud_verdict {
    let mut said = canbaud_verdict {
        kind: canbaud_verdict_kind::NO_TRAFFIC,
        nominal: canbaud_bit_time::default(),
        data_phase: canbaud_data_phase::NO_FD,
        data: canbaud_bit_time::default(),
        other: canbaud_bit_time::default(),
        proven_frames: 0,
        proof_bits: 0,
        inverted: 0,
    };
    match verdict {
        Verdict::NoTraffic => {}
        Verdict::Undecided(need) => {
            said.kind = match need {
                Need::CompleteFrame => canbaud_verdict_kind::NEEDS_COMPLETE_FRAME,
                Need::FinerClock => canbaud_verdict_kind::NEEDS_FINER_CLOCK,
                Need::AnotherFrame => canbaud_verdict_kind::NEEDS_ANOTHER_FRAME,
                // What a later version of the library may add is said as the most general need.
                _ => canbaud_verdict_kind::NEEDS_CLEAN_FRAME,
            };
        }
        Verdict::Found(found) => {
            said.kind = canbaud_verdict_kind::FOUND;
            said.nominal = bit(found.nominal);
            (said.data_phase, said.data) = match found.data {
                DataPhase::NoFd => (canbaud_data_phase::NO_FD, canbaud_bit_time::default()),
                DataPhase::NeverSwitched => {
                    (canbaud_data_phase::NEVER_SWITCHED, canbaud_bit_time::default())
                }
                DataPhase::Switched(data) => (canbaud_data_phase::SWITCHED, bit(data)),
            };
            said.proven_frames = found.proven_frames;
            said.proof_bits = found.proof_bits;
            said.inverted = u8::from(found.polarity == Polarity::Inverted);
        }
        Verdict::Conflict { phase: Phase::Nominal, first, second } => {
            said.kind = canbaud_verdict_kind::CONFLICT;
            (said.nominal, said.other) = (bit(*first), bit(*second));
        }
        Verdict::Conflict { phase: Phase::Data, first, second } => {
            said.kind = canbaud_verdict_kind::DATA_CONFLICT;
            (said.data, said.other) = (bit(*first), bit(*second));
        }
    }
    said
}
