//! One source, any number of independent positions in it.

use std::io::{self, Read, Seek, SeekFrom};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{CaptureError, Place};

/// Bytes that can be read from any place.
pub(crate) trait Source: Read + Seek + Send {}
impl<T: Read + Seek + Send> Source for T {}

/// A position of its own in a shared source: CAN_H and CAN_L lie in different members of one zip
/// and are read side by side.
#[derive(Clone)]
pub(crate) struct Input {
    source: Arc<Mutex<Box<dyn Source>>>,
    at: u64,
    len: u64,
}

impl Input {
    pub(crate) fn new(mut source: Box<dyn Source>) -> Result<Self, CaptureError> {
        let len = source.seek(SeekFrom::End(0)).map_err(CaptureError::Open)?;
        if len == 0 {
            return Err(CaptureError::Empty);
        }
        Ok(Self { source: Arc::new(Mutex::new(source)), at: 0, len })
    }

    /// Bytes in the source.
    pub(crate) const fn len(&self) -> u64 {
        self.len
    }

    /// The same source, read from byte `at` on.
    pub(crate) fn at(&self, at: u64) -> Self {
        Self { at, ..self.clone() }
    }

    /// Up to `max` bytes from byte `at` on; fewer only at the end of the source.
    pub(crate) fn bytes(&self, at: u64, max: usize) -> Result<Vec<u8>, CaptureError> {
        let mut bytes = vec![0; max];
        let n = fill(&mut self.at(at), &mut bytes).map_err(|e| CaptureError::io(at, e))?;
        bytes.truncate(n);
        Ok(bytes)
    }
}

impl Read for Input {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        let mut source = self.source.lock().unwrap_or_else(PoisonError::into_inner);
        source.seek(SeekFrom::Start(self.at))?;
        let n = source.read(buf)?;
        self.at = self.at.saturating_add(n as u64);
        Ok(n)
    }
}

/// Bytes whose reader knows where it is when something goes wrong.
pub(crate) trait Bytes {
    /// Reads at least one byte; 0 is the end.
    fn read_some(&mut self, buf: &mut [u8]) -> Result<usize, CaptureError>;
}

/// Reads until `buf` is full or the reader ends; the bytes read.
pub(crate) fn fill(reader: &mut impl Read, buf: &mut [u8]) -> io::Result<usize> {
    let mut n = 0;
    while let Some(rest) = buf.get_mut(n..).filter(|rest| !rest.is_empty()) {
        match reader.read(rest) {
            Ok(0) => break,
            Ok(read) => n += read,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(n)
}

/// Little-endian fields of a binary file, read one after the other, with the place for errors.
pub(crate) struct Fields<R> {
    reader: R,
    at: u64,
}

impl<R: Read> Fields<R> {
    pub(crate) const fn new(reader: R, at: u64) -> Self {
        Self { reader, at }
    }

    /// Byte offset of the next field.
    pub(crate) const fn at(&self) -> u64 {
        self.at
    }

    pub(crate) const fn place(&self) -> Place {
        Place::Byte(self.at)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], CaptureError> {
        let mut bytes = [0; N];
        let n = fill(&mut self.reader, &mut bytes).map_err(|e| CaptureError::io(self.at, e))?;
        if n < N {
            return Err(CaptureError::damaged(
                Place::Byte(self.at.saturating_add(n as u64)),
                "the file ends too early",
            ));
        }
        self.at = self.at.saturating_add(N as u64);
        Ok(bytes)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, CaptureError> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, CaptureError> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, CaptureError> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Result<f64, CaptureError> {
        self.array().map(f64::from_le_bytes)
    }

    /// Fills as much of `buf` as there is; the bytes read.
    pub(crate) fn block(&mut self, buf: &mut [u8]) -> Result<usize, CaptureError> {
        let n = fill(&mut self.reader, buf).map_err(|e| CaptureError::io(self.at, e))?;
        self.at = self.at.saturating_add(n as u64);
        Ok(n)
    }
}

impl<R: Read> Bytes for Fields<R> {
    fn read_some(&mut self, buf: &mut [u8]) -> Result<usize, CaptureError> {
        self.block(buf)
    }
}
