//! Tektronix waveform files, `.isf`: a text preamble and 8- or 16-bit samples.
//!
//! volts = (raw - YOFF) * YMULT + YZERO.

use std::io::BufReader;

use crate::Format;
use crate::analogue::{Blocks, Job, Segment, TICKS_PER_SAMPLE};
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt, Place};
use crate::input::{Fields, Input};
use crate::number::{Decimal, period_timebase};
use crate::sink::Output;
use crate::sr;

const FORMAT: Format = Format::TekIsf;
/// Bytes of the head that the preamble may take.
const HEAD: usize = 16 * 1024;
/// Samples read at once.
const BLOCK: usize = 16 * 1024;

/// Whether a head is a preamble.
pub(crate) fn sniff(head: &[u8]) -> bool {
    let starts = [":WFMP", "WFMP", ":WFMO", "WFMO", ":CURV"];
    let upper = head.get(..6).unwrap_or_default().to_ascii_uppercase();
    starts.iter().any(|start| upper.starts_with(start.as_bytes()))
}

#[derive(Debug, Clone, Copy)]
struct Scale {
    bytes: usize,
    big_endian: bool,
    signed: bool,
    offset: f64,
    factor: f64,
    zero: f64,
}

impl Scale {
    fn volts(&self, raw: &[u8]) -> f32 {
        let raw = match (raw, self.big_endian, self.signed) {
            (&[byte], _, true) => f64::from(byte as i8),
            (&[byte], _, false) => f64::from(byte),
            (&[a, b], true, true) => f64::from(i16::from_be_bytes([a, b])),
            (&[a, b], true, false) => f64::from(u16::from_be_bytes([a, b])),
            (&[a, b], false, true) => f64::from(i16::from_le_bytes([a, b])),
            (&[a, b], false, false) => f64::from(u16::from_le_bytes([a, b])),
            _ => f64::NAN,
        };
        ((raw - self.offset) * self.factor + self.zero) as f32
    }
}

struct Isf {
    input: Input,
    options: OpenOptions,
    scale: Scale,
    at: u64,
    bytes: u64,
    signal: Option<Signal>,
}

/// The value of a key in its long or short form: `XINCR 20E-9`, `:WFMO:XIN 2.0E-8`.
fn value<'a>(preamble: &'a str, keys: &[&str]) -> Option<&'a str> {
    preamble.split(';').find_map(|field| {
        let (key, value) = field.trim().split_once(char::is_whitespace)?;
        let key = key.rsplit(':').next()?;
        keys.iter().any(|k| k.eq_ignore_ascii_case(key)).then(|| value.trim().trim_matches('"'))
    })
}

pub(crate) fn open(input: &Input, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let head = input.bytes(0, HEAD)?;
    let bad = |reason: &str| CaptureError::damaged(Place::Byte(0), reason);
    let upper = head.to_ascii_uppercase();
    let curve = memchr::memmem::find(&upper, b":CURV")
        .ok_or_else(|| bad("no :CURVE in the first 16 KiB"))?;
    let preamble = String::from_utf8_lossy(head.get(..curve).unwrap_or_default()).into_owned();
    let number = |keys: &[&str]| value(&preamble, keys).and_then(|v| Decimal::parse(v.as_bytes()));
    // `#6200000`: the number of digits, and the number of bytes.
    let block = upper.get(curve..).unwrap_or_default();
    let hash = memchr::memchr(b'#', block).ok_or_else(|| bad("no # after :CURVE"))?;
    let digits =
        block.get(hash + 1).filter(|d| (b'1'..=b'9').contains(d)).map(|d| usize::from(d - b'0'));
    let digits = digits.ok_or_else(|| bad("no number of bytes after :CURVE"))?;
    let length = block.get(hash + 2..hash + 2 + digits).and_then(|d| core::str::from_utf8(d).ok());
    let length = length.and_then(|d| d.parse::<u64>().ok());
    let length = length.ok_or_else(|| bad("no number of bytes after :CURVE"))?;
    let bytes = match value(&preamble, &["BYT_NR", "BYT_N", "BYT"]) {
        Some("1") => 1,
        Some("2") => 2,
        other => return Err(bad(&format!("BYT_NR {other:?} is neither 1 nor 2"))),
    };
    let scale = Scale {
        bytes,
        big_endian: value(&preamble, &["BYT_OR", "BYT_O"])
            .is_none_or(|o| !o.eq_ignore_ascii_case("LSB")),
        signed: value(&preamble, &["BN_FMT", "BN_F"]).is_none_or(|f| !f.eq_ignore_ascii_case("RP")),
        offset: number(&["YOFF", "YOF"]).map_or(0.0, Decimal::to_f64),
        factor: number(&["YMULT", "YMU"]).map_or(1.0, Decimal::to_f64),
        zero: number(&["YZERO", "YZE"]).map_or(0.0, Decimal::to_f64),
    };
    let (timebase, samplerate) = match options.samplerate {
        Some(rate) => (sr::timebase(rate, true).0, rate),
        None => number(&["XINCR", "XIN"])
            .and_then(|period| period_timebase(period, TICKS_PER_SAMPLE))
            .ok_or_else(|| bad("XINCR, the sample period, is missing or out of range"))?,
    };
    let name =
        value(&preamble, &["WFID", "WFI"]).and_then(|w| w.split(',').next()).unwrap_or("CH1");
    let channels = vec![Channel::new(name.trim(), ChannelKind::Analogue, 1)];
    let at = (curve + hash + 2 + digits) as u64;
    let reader =
        Isf { input: input.clone(), options: *options, scale, at, bytes: length, signal: None };
    Ok(Capture::new(FORMAT, timebase, Some(samplerate), channels, reader))
}

struct Samples {
    fields: Fields<BufReader<Input>>,
    scale: Scale,
    left: u64,
}

impl Blocks for Samples {
    fn next(&mut self, samples: &mut Vec<f32>) -> Result<(), CaptureError> {
        samples.clear();
        let want = usize::try_from(self.left).unwrap_or(usize::MAX).min(BLOCK * self.scale.bytes);
        let mut raw = vec![0; want - want % self.scale.bytes];
        let n = self.fields.block(&mut raw)?;
        let whole = raw.get(..n).unwrap_or_default().chunks_exact(self.scale.bytes);
        samples.extend(whole.map(|raw| self.scale.volts(raw)));
        if samples.is_empty() && !raw.is_empty() {
            let reason = format!("the file ends {} bytes before its last sample", self.left);
            return Err(CaptureError::damaged(self.fields.place(), reason));
        }
        self.left -= n as u64;
        Ok(())
    }
}

impl Reader for Isf {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        if !out.wants(0) {
            return Ok(());
        }
        let open = |number: usize| -> Result<Option<Segment<'_>>, CaptureError> {
            let reader = BufReader::with_capacity(64 * 1024, self.input.at(self.at));
            let fields = Fields::new(reader, self.at);
            let samples = Samples { fields, scale: self.scale, left: self.bytes };
            Ok((number == 0).then(|| (0, Box::new(samples) as Box<dyn Blocks>)))
        };
        let job = Job {
            channel: 0,
            step: TICKS_PER_SAMPLE,
            threshold: self.options.threshold,
            progress: (self.at, self.input.len()),
            open: &open,
        };
        job.stream(&mut self.signal, out, report)?;
        out.progress(self.input.len(), self.input.len());
        Ok(())
    }
}
