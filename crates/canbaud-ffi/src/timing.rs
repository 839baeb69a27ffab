//! Bit timing and registers.

use crate::controllers::canbaud_controller;
use crate::status::{canbaud_status, status_of};
use crate::storage::{optional, read, write};
use canbaud::timing::controllers::{Configuration, Phase};
use canbaud::timing::tdc::Tdc;
use canbaud::timing::{BitTiming, Request, SamplePointPolicy, SolveError, solve};
use canbaud::units::{Bitrate, Hertz, Permille};
use core::ffi::c_char;

/// Parts of a frame that have a bit timing of their own.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_phase {
    /// Arbitration phase; the only one of classic CAN.
    NOMINAL = 0,
    /// Data phase of CAN FD.
    DATA = 1,
}

/// What is asked of a bit timing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_timing_request {
    /// The clock that the controller's data sheet starts from, in Hz.
    pub clock_hz: u32,
    /// Bit rate in bit/s.
    pub bitrate: u32,
    /// Sample point in thousandths of a bit, 1 to 999; 0: what CiA recommends for the bit rate.
    pub sample_point_permille: u16,
    /// Largest accepted bit rate error in 10^-6; 0: 5000.
    pub tolerance_ppm: u32,
}

/// A bit timing in real values: a prescaler of 1 divides by 1, whatever the register holds for it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_bit_timing {
    /// Clock periods per time quantum.
    pub prescaler: u16,
    /// PROP_SEG in time quanta.
    pub prop_seg: u16,
    /// PHASE_SEG1 in time quanta.
    pub phase_seg1: u16,
    /// PHASE_SEG2 in time quanta.
    pub phase_seg2: u16,
    /// Synchronization jump width in time quanta.
    pub sjw: u16,
}

/// A bit timing and what it makes of the request.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_timing_solution {
    /// The bit timing.
    pub timing: canbaud_bit_timing,
    /// Sample point in thousandths of a bit, rounded.
    pub sample_point_permille: u16,
    /// The bit rate that comes out, in thousandths of a bit/s.
    pub millibits_per_second: u64,
    /// Bit rate error in 10^-9, positive if too fast.
    pub error_ppb: i64,
}

/// A word for a register.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_register_word {
    /// Name of the register as the data sheet has it, cut to 23 characters.
    pub name: [c_char; 24],
    /// What to write.
    pub word: u32,
}

/// Most registers that a controller has for its bit timing.
pub const CANBAUD_REGISTERS_MAX: usize = 8;

/// Finds the best bit timing: smallest bit rate error, then smallest sample point error.
/// `phase` is a canbaud_phase.
///
/// CANBAUD_STATUS_NO_SOLUTION: the controller cannot make the bit rate from that clock.
///
/// # Safety
/// `controller` must come from this library; `request` and `solution` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_timing_solve(
    controller: *const canbaud_controller,
    phase: u8,
    request: *const canbaud_timing_request,
    solution: *mut canbaud_timing_solution,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let (controller, request) = unsafe { (read(controller)?.get(), read(request)?) };
        let clock = Hertz::new(request.clock_hz.into()).ok_or(canbaud_status::OUT_OF_RANGE)?;
        let bitrate = Bitrate::new(request.bitrate).ok_or(canbaud_status::OUT_OF_RANGE)?;
        let mut wish = Request::new(clock, bitrate);
        if request.sample_point_permille != 0 {
            let point = Permille::new(request.sample_point_permille);
            let point = point.ok_or(canbaud_status::OUT_OF_RANGE)?;
            wish = wish.with_sample_point(point, SamplePointPolicy::Nearest);
        }
        if request.tolerance_ppm != 0 {
            wish = wish.with_tolerance_ppm(request.tolerance_ppm);
        }
        let phase = phase_of(phase)?;
        let limits = controller.limits(phase).ok_or(canbaud_status::NO_PHASE)?;
        let solved = solve(&wish, limits).map_err(|error| match error {
            SolveError::Clock { .. } => canbaud_status::OUT_OF_RANGE,
            _ => canbaud_status::NO_SOLUTION,
        })?;
        let found = canbaud_timing_solution {
            timing: to_c(&solved.timing),
            sample_point_permille: solved.timing.sample_point().permille() as u16,
            millibits_per_second: solved.rate.millibits_per_second(),
            error_ppb: solved.bitrate_error_ppb(),
        };
        // SAFETY: as the caller says.
        unsafe { write(solution, found) }
    })
}

/// The words for the registers of a controller. `data` is the bit timing of the CAN FD data phase,
/// with transmitter delay compensation on if that is advisable, or NULL for classic CAN.
///
/// `words` has room for `room` words; `count` becomes how many there are. With CANBAUD_REGISTERS_MAX
/// there is always room.
///
/// # Safety
/// `controller` must come from this library; `words` must have room for `room` words; all others
/// must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_timing_registers(
    controller: *const canbaud_controller,
    nominal: *const canbaud_bit_timing,
    data: *const canbaud_bit_timing,
    words: *mut canbaud_register_word,
    room: usize,
    count: *mut usize,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let (controller, nominal) = unsafe { (read(controller)?.get(), read(nominal)?) };
        let mut configuration = Configuration::classic(from_c(nominal));
        // SAFETY: as the caller says.
        if let Some(data) = unsafe { optional(data) } {
            let data = from_c(data);
            let tdc = Tdc::of(&data, controller.tdc_offset_max).offset();
            configuration = configuration.with_data(data, tdc);
        }
        let packed = controller.pack(&configuration).map_err(|_| canbaud_status::NO_SOLUTION)?;
        let mut needed = 0;
        for (register, word) in packed {
            let word = word.map_err(|_| canbaud_status::NO_SOLUTION)?;
            if needed < room {
                if words.is_null() {
                    return Err(canbaud_status::NULL_POINTER);
                }
                let word = canbaud_register_word { name: name(register.name), word };
                // SAFETY: the caller says that there is room for `room` words.
                unsafe { words.add(needed).write(word) };
            }
            needed += 1;
        }
        // SAFETY: as the caller says.
        unsafe { write(count, needed) }?;
        if needed > room { Err(canbaud_status::NO_ROOM) } else { Ok(()) }
    })
}

fn name(text: &str) -> [c_char; 24] {
    let mut name = [0; 24];
    // The last one stays the zero that ends it.
    name.iter_mut().take(23).zip(text.bytes()).for_each(|(to, from)| *to = from as c_char);
    name
}

fn phase_of(phase: u8) -> Result<Phase, canbaud_status> {
    match phase {
        0 => Ok(Phase::Nominal),
        1 => Ok(Phase::Data),
        _ => Err(canbaud_status::OUT_OF_RANGE),
    }
}

fn from_c(timing: &canbaud_bit_timing) -> BitTiming {
    BitTiming {
        prescaler: timing.prescaler,
        prop_seg: timing.prop_seg,
        phase_seg1: timing.phase_seg1,
        phase_seg2: timing.phase_seg2,
        sjw: timing.sjw,
    }
}

fn to_c(timing: &BitTiming) -> canbaud_bit_timing {
    canbaud_bit_timing {
        prescaler: timing.prescaler,
        prop_seg: timing.prop_seg,
        phase_seg1: timing.phase_seg1,
        phase_seg2: timing.phase_seg2,
        sjw: timing.sjw,
    }
}
