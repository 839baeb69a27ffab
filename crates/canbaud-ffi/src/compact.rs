//! The rate from the edges of one classic frame, in little memory.

use crate::pulse::{canbaud_verdict, level_from_c, to_c};
use crate::status::{canbaud_status, status_of};
use crate::storage;
use canbaud::detect::CompactDetector;
use core::mem::MaybeUninit;

/// Words of a canbaud_compact_detector, of eight bytes each.
pub const CANBAUD_COMPACT_DETECTOR_WORDS: usize = 80;

/// Finds and proves the bit rate from one classic frame, with three ticks a bit or more, for the
/// smallest controllers: a fifth of the code and a third of the memory of canbaud_pulse_detector. The
/// line is RXD: high is recessive. Its content is private. Zeros are storage that is not initialized.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct canbaud_compact_detector {
    /// Private.
    pub opaque: [MaybeUninit<u64>; CANBAUD_COMPACT_DETECTOR_WORDS],
}

type Detector = CompactDetector<128>;

/// Sets up a detector before its first edge.
///
/// # Safety
/// `detector` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_compact_detector_init(
    detector: *mut canbaud_compact_detector,
) -> canbaud_status {
    // SAFETY: as the caller says; the struct is its words.
    status_of(|| unsafe {
        storage::init(detector.cast::<[u64; CANBAUD_COMPACT_DETECTOR_WORDS]>(), Detector::new())
    })
}

/// Unbroken recording begins at tick `at` with the line at `level`, a canbaud_level; also after a
/// pause or a lost edge.
///
/// # Safety
/// `detector` must be valid or NULL, and nothing else may use it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_compact_detector_begin(
    detector: *mut canbaud_compact_detector,
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
/// Mostly some hundred instructions; the edge that ends the gap behind a frame pays for the proof.
///
/// # Safety
/// `detector` must be valid or NULL, and nothing else may use it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_compact_detector_push(
    detector: *mut canbaud_compact_detector,
    at: u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(detector) }?.push(at);
        Ok(())
    })
}

/// The line has not changed from the last edge to tick `at`, and the recording ends or pauses:
/// canbaud_compact_detector_begin comes before the next edge.
///
/// # Safety
/// `detector` must be valid or NULL, and nothing else may use it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_compact_detector_finish(
    detector: *mut canbaud_compact_detector,
    at: u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(detector) }?.finish(at);
        Ok(())
    })
}

/// What is known so far. Once a rate is found, further edges do not change it.
///
/// # Safety
/// `detector` and `verdict` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_compact_detector_verdict(
    detector: *mut canbaud_compact_detector,
    verdict: *mut canbaud_verdict,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let found = unsafe { of(detector) }?.verdict();
        // SAFETY: as the caller says.
        unsafe { storage::write(verdict, to_c(&found)) }
    })
}

/// # Safety
/// As for [`storage::get`].
unsafe fn of<'a>(
    detector: *mut canbaud_compact_detector,
) -> Result<&'a mut Detector, canbaud_status> {
    // SAFETY: the struct is its words.
    unsafe { storage::get::<Detector, CANBAUD_COMPACT_DETECTOR_WORDS>(detector.cast()) }
}
