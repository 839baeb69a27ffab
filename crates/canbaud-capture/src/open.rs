//! Opening: what is this file, and who reads it.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

use crate::Format;
use crate::capture::{Capture, OpenOptions};
use crate::error::CaptureError;
use crate::input::Input;
use crate::{csv, dsview, isf, logicdata, saleae, sniff, sr, vcd};

/// Opens a capture file; the format is found from the content, never from the name.
///
/// # Errors
/// If the file cannot be read, no format fits, or its head is damaged.
///
/// ```no_run
/// use canbaud_capture::{OpenOptions, open};
/// let capture = open("bus.sr".as_ref(), &OpenOptions::default())?;
/// println!("{}: {} channels", capture.format(), capture.channels().len());
/// # Ok::<(), canbaud_capture::CaptureError>(())
/// ```
pub fn open(path: &Path, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let metadata = path.metadata().map_err(CaptureError::Open)?;
    if metadata.is_dir() {
        return Err(CaptureError::Directory);
    }
    if !metadata.is_file() {
        // Opening a pipe would wait for its writer, and nothing but a file can be read twice.
        return Err(CaptureError::Open(io::Error::other("not a regular file")));
    }
    let file = File::open(path).map_err(CaptureError::Open)?;
    from_reader(file, options)
}

/// Opens a capture that is not a file: anything that can be read from any place.
///
/// # Errors
/// As [`open`].
pub fn from_reader<R: Read + Seek + Send + 'static>(
    source: R,
    options: &OpenOptions,
) -> Result<Capture, CaptureError> {
    let input = Input::new(Box::new(source))?;
    let format = match options.format {
        Some(format) => format,
        None => sniff::sniff(&input)?,
    };
    match format {
        Format::SigrokSr => sr::open(&input, options),
        Format::SigrokCsv | Format::SaleaeCsv | Format::ScopeCsv => {
            csv::open(&input, options.format, options)
        }
        Format::Vcd => vcd::open(&input, options),
        Format::SaleaeBinary => saleae::binary::open(&input, options),
        Format::Logic1Samples(_) | Format::Logic1Changes(_) => {
            saleae::logic1::open(&input, format, options)
        }
        Format::DsView => dsview::open(&input, options),
        Format::LogicData => logicdata::open(&input, options),
        Format::TekIsf => isf::open(&input, options),
    }
}
