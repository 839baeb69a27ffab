//! What a function says.

/// What a function says. Everything but CANBAUD_STATUS_OK is a mistake of the caller or an impossible
/// request; trouble on the bus is no error.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_status {
    /// Done.
    OK = 0,
    /// A pointer that must not be is NULL.
    NULL_POINTER = 1,
    /// The storage was not set up by its init function.
    NOT_INITIALIZED = 2,
    /// A value is outside its documented range.
    OUT_OF_RANGE = 3,
    /// No controller has that name.
    UNKNOWN_CONTROLLER = 4,
    /// The controller cannot do it: no bit timing is near enough, or none fits its registers.
    NO_SOLUTION = 5,
    /// The controller does not have this phase.
    NO_PHASE = 6,
    /// The array has too little room; the count says how much is needed.
    NO_ROOM = 7,
    /// There is no such thing at the moment: no outcome yet, nothing to do.
    NOTHING = 8,
}

/// The text of a status, one short English line. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_status_text(status: u32) -> *const core::ffi::c_char {
    let text = match status {
        0 => c"done",
        1 => c"a pointer is NULL",
        2 => c"the storage was not initialized",
        3 => c"a value is out of range",
        4 => c"no such controller",
        5 => c"the controller cannot do it",
        6 => c"the controller does not have this phase",
        7 => c"too little room",
        8 => c"nothing at the moment",
        _ => c"no such status",
    };
    text.as_ptr()
}

/// Turns early returns with a status into the status.
pub(crate) fn status_of(run: impl FnOnce() -> Result<(), canbaud_status>) -> canbaud_status {
    match run() {
        Ok(()) => canbaud_status::OK,
        Err(status) => status,
    }
}
