//! What went wrong, in one line that names the file, the place and the reason.

use std::io;
use std::path::Path;

use canbaud_capture::CaptureError;

use crate::exit::Exit;
use crate::printable::printable;
use crate::tell::tell;

/// The name of a source as the user sees it, without characters that could steer a terminal.
pub(super) fn source_name(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

/// The line, and where there is one, a line with a hint.
pub(super) fn unreadable(source: &str, error: &CaptureError) -> String {
    let line = format!("canbaud: {source}: {}", printable(&error.to_string()));
    match hint(error) {
        Some(hint) => format!("{line}\n  hint: {hint}\n"),
        None => format!("{line}\n"),
    }
}

fn hint(error: &CaptureError) -> Option<&'static str> {
    match error {
        CaptureError::NoSamplerate(_) => Some("--samplerate 24M"),
        CaptureError::Unrecognised(_) => {
            Some("--input-format NAME reads it as that format; --help lists what is known")
        }
        CaptureError::Directory => Some("name the files in it: canbaud detect DIRECTORY/*"),
        _ => None,
    }
}

/// What becomes of a run whose output cannot be written: a reader that went away is no error.
pub(super) fn unwritable(target: &str, error: &io::Error) -> Exit {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return Exit::Found;
    }
    tell!("canbaud: {target}: cannot write: {error}");
    Exit::Unreadable
}
