//! Checked conversion of C pointers to slices and strings.

use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;

/// Checks that a pointer and a length describe an array.
///
/// # Errors
/// The array is NULL, misaligned or longer than the address space.
#[inline]
fn check_array<T>(pointer: *const T, length: usize, what: &str) -> Result<(), String> {
    let fits = length <= isize::MAX as usize / size_of::<T>().max(1);
    if !pointer.is_null() && pointer.is_aligned() && fits {
        Ok(())
    } else {
        Err(invalid_array(pointer.is_null(), fits, what))
    }
}

#[cold]
fn invalid_array(null: bool, fits: bool, what: &str) -> String {
    let problem = match (null, fits) {
        (true, _) => "is NULL",
        (_, false) => "is longer than the memory",
        _ => "is not aligned",
    };
    format!("the array of {what} {problem}")
}

/// The elements at a pointer; with length 0 the pointer is not used.
///
/// # Safety
/// A pointer that is not null points to that many initialized elements, which do not change during the call.
#[inline]
pub(crate) unsafe fn array<'a, T>(
    pointer: *const T,
    length: usize,
    what: &str,
) -> Result<&'a [T], String> {
    if length == 0 {
        return Ok(&[]);
    }
    check_array(pointer, length, what)?;
    // SAFETY: not null, aligned and no longer than the memory (above); the rest is the contract.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// The slots to write at a pointer; with length 0 the pointer is not used.
///
/// # Safety
/// A pointer that is not null points to that many writable slots, which nothing else uses during the call.
#[inline]
pub(crate) unsafe fn slots<'a, T>(
    pointer: *mut T,
    length: usize,
    what: &str,
) -> Result<&'a mut [MaybeUninit<T>], String> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_array(pointer, length, what)?;
    // SAFETY: as in `array`; the slots need not be initialized.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer.cast(), length) })
}

/// The string at a pointer.
///
/// # Safety
/// A pointer that is not null points to a NUL-terminated string, which does not change during the call.
pub(crate) unsafe fn string<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: not null; the rest is the contract.
    Some(unsafe { CStr::from_ptr(pointer) })
}

/// The strings at a pointer to pointers.
///
/// # Safety
/// As for [`array`], and for each pointer as for [`string`].
pub(crate) unsafe fn strings<'a>(
    pointer: *const *const c_char,
    length: usize,
    what: &str,
) -> Result<Vec<Option<&'a CStr>>, String> {
    // SAFETY: the contract.
    let pointers = unsafe { array(pointer, length, what)? };
    // SAFETY: the contract.
    Ok(pointers.iter().map(|pointer| unsafe { string(*pointer) }).collect())
}

/// A flag that must be 0 or 1.
pub(crate) fn flag(value: i32, what: &str) -> Result<bool, String> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(format!("{what} is {value}: a Boolean is 0 or 1")),
    }
}
