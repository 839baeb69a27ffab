//! Between what C has and what the library has.

use super::*;
use crate::status::canbaud_status;
use canbaud::detect::scan::{
    Acknowledgement, Candidate, Candidates, Capabilities, Capture, End, ErrorClass, ErrorPlace,
    ErrorSeen, Evidence, FdSeen, FdSupport, Outcome, Policy, RateChoice, Settings,
};
use canbaud::units::{Bitrate, Micros, Permille};

/// # Safety
/// `candidates` must point to `count` candidates, or be NULL.
pub(super) unsafe fn list(
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

pub(super) fn stamp(received_us: u64) -> Option<Micros> {
    (received_us != CANBAUD_NEVER).then_some(Micros(received_us))
}

pub(super) fn capabilities_from_c(
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

pub(super) fn settings_from_c(given: &canbaud_scan_settings) -> Result<Settings, canbaud_status> {
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

pub(super) fn candidate_to_c(candidate: &Candidate) -> canbaud_candidate {
    canbaud_candidate {
        nominal: candidate.nominal.bits_per_second(),
        data: candidate.data.map_or(0, Bitrate::bits_per_second),
        wide: u8::from(candidate.capture == Capture::Wide),
    }
}

pub(super) fn outcome_to_c(outcome: &Outcome) -> canbaud_scan_outcome {
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

pub(super) fn error_from_c(
    class: u8,
    place: u8,
    received_us: u64,
) -> Result<ErrorSeen, canbaud_status> {
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
    Ok(ErrorSeen { class, place, received: stamp(received_us) })
}
