//! A sigrok session (`.sr`): the bus as a logic analyser samples it; high is recessive.

use std::io::{self, Seek, Write};

use canbaud::units::Hertz;
use canbaud::wire::Level;
use zip::write::{SimpleFileOptions, ZipWriter};

use crate::time::Time;

/// Samples in one member of the archive.
const CHUNK: usize = 4 << 20;
/// Samples that a session may have.
const SAMPLES_MAX: u64 = 1 << 32;

/// Why a session cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum SrError {
    /// More samples than a session may have.
    #[error("{0} samples, allowed are up to {SAMPLES_MAX}: choose a lower sample rate")]
    Samples(u128),
    /// The archive.
    #[error(transparent)]
    Zip(#[from] zip::result::ZipError),
    /// The file.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Writes the levels of `edges` up to `end`, sampled at `rate`, as channel `name`.
///
/// # Errors
/// [`SrError`] if there are too many samples, or writing fails.
pub fn write_sr(
    out: impl Write + Seek,
    edges: &[(Time, Level)],
    name: &str,
    rate: Hertz,
    end: Time,
) -> Result<(), SrError> {
    let sample_of = |time: Time| {
        // The first sample at or after `time`.
        (u128::from(time.femtoseconds()) * u128::from(rate.hertz())).div_ceil(10_u128.pow(15))
    };
    let count = sample_of(end);
    if count > u128::from(SAMPLES_MAX) {
        return Err(SrError::Samples(count));
    }
    let mut zip = ZipWriter::new(out);
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    zip.start_file("version", options)?;
    zip.write_all(b"2")?;
    zip.start_file("metadata", options)?;
    let metadata = format!(
        "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\ntotal probes=1\n\
         samplerate={} Hz\ntotal analog=0\nprobe1={name}\nunitsize=1\n",
        rate.hertz()
    );
    zip.write_all(metadata.as_bytes())?;
    let mut samples = Samples { edges: edges.iter().peekable(), level: Level::Recessive, at: 0 };
    let mut left = count as u64;
    let mut member = 1;
    while left > 0 {
        let size = left.min(CHUNK as u64) as usize;
        let bytes = samples.take(size, &sample_of);
        zip.start_file(format!("logic-1-{member}"), options)?;
        zip.write_all(&bytes)?;
        left -= size as u64;
        member += 1;
    }
    zip.finish()?.flush()?;
    Ok(())
}

struct Samples<'a> {
    edges: std::iter::Peekable<std::slice::Iter<'a, (Time, Level)>>,
    level: Level,
    at: u128,
}

impl Samples<'_> {
    fn take(&mut self, size: usize, sample_of: &impl Fn(Time) -> u128) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(size);
        while bytes.len() < size {
            while let Some((_, level)) = self.edges.next_if(|(at, _)| sample_of(*at) <= self.at) {
                self.level = *level;
            }
            let until = self.edges.peek().map_or(u128::MAX, |(at, _)| sample_of(*at));
            let run = (until - self.at).min((size - bytes.len()) as u128) as usize;
            bytes.resize(bytes.len() + run, u8::from(self.level == Level::Recessive));
            self.at += run as u128;
        }
        bytes
    }
}
