//! Storage that the caller owns, and pointers.

use crate::canbaud_status;
use core::mem::MaybeUninit;

/// Marks storage that an init function has filled.
const MAGIC: u32 = 0xCB4D_5EED;

/// What lies in the storage.
#[repr(C)]
struct Slot<T> {
    magic: u32,
    value: MaybeUninit<T>,
}

/// Words of eight bytes that a `T` needs in storage.
pub(crate) const fn words<T>() -> usize {
    size_of::<Slot<T>>().div_ceil(8)
}

/// Puts `value` into storage of `N` words.
///
/// # Safety
/// `storage` must be NULL or point to `N` writable words of eight bytes, aligned to eight.
pub(crate) unsafe fn init<T, const N: usize>(
    storage: *mut [u64; N],
    value: T,
) -> Result<(), canbaud_status> {
    const { assert!(words::<T>() <= N && align_of::<Slot<T>>() <= 8) };
    if storage.is_null() {
        return Err(canbaud_status::NULL_POINTER);
    }
    let slot = Slot { magic: MAGIC, value: MaybeUninit::new(value) };
    // SAFETY: not NULL, so the caller says that it is large enough; size and alignment are checked.
    unsafe { storage.cast::<Slot<T>>().write(slot) };
    Ok(())
}

/// The value in storage.
///
/// # Safety
/// As for [`init`]; the storage must hold zeros or what [`init`] put there with the same `T`, and
/// nothing else may use it meanwhile.
pub(crate) unsafe fn get<'a, T, const N: usize>(
    storage: *mut [u64; N],
) -> Result<&'a mut T, canbaud_status> {
    const { assert!(words::<T>() <= N && align_of::<Slot<T>>() <= 8) };
    if storage.is_null() {
        return Err(canbaud_status::NULL_POINTER);
    }
    // SAFETY: not NULL; any bytes are a `Slot`, whose value is asked for only behind the mark.
    let slot = unsafe { &mut *storage.cast::<Slot<T>>() };
    match slot.magic {
        // SAFETY: only `init` writes the mark, together with a value.
        MAGIC => Ok(unsafe { slot.value.assume_init_mut() }),
        _ => Err(canbaud_status::NOT_INITIALIZED),
    }
}

/// What an optional pointer points to.
///
/// # Safety
/// `pointer` must be NULL or point to a readable `T`.
pub(crate) unsafe fn optional<'a, T>(pointer: *const T) -> Option<&'a T> {
    // SAFETY: the caller says so.
    unsafe { pointer.as_ref() }
}

/// What a pointer points to.
///
/// # Safety
/// `pointer` must be NULL or point to a readable `T`.
pub(crate) unsafe fn read<'a, T>(pointer: *const T) -> Result<&'a T, canbaud_status> {
    // SAFETY: the caller says so.
    unsafe { pointer.as_ref() }.ok_or(canbaud_status::NULL_POINTER)
}

/// Puts `value` where `pointer` points to.
///
/// # Safety
/// `pointer` must be NULL or point to room for a `T`.
pub(crate) unsafe fn write<T>(pointer: *mut T, value: T) -> Result<(), canbaud_status> {
    if pointer.is_null() {
        return Err(canbaud_status::NULL_POINTER);
    }
    // SAFETY: not NULL, and what was there before needs no drop.
    unsafe { pointer.write(value) };
    Ok(())
}
