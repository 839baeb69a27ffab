//! Binary export of Logic 2, versions 0 and 1, one channel per file.
//!
//! Source: Saleae support, "Binary and CSV export formats".

use std::io::BufReader;

use canbaud::units::{Hertz, Timebase};
use canbaud::wire::Logic;

use crate::Format;
use crate::analogue::{Floats, Job, Segment, TICKS_PER_SAMPLE};
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt, Place};
use crate::grid;
use crate::input::{Fields, Input};
use crate::number::{Decimal, period_timebase};
use crate::sink::Output;

const FORMAT: Format = Format::SaleaeBinary;
pub(crate) const MAGIC: [u8; 8] = *b"<SALEAE>";
/// Digital times are rounded to a picosecond; what doubles hold of an hour is no finer.
const TICKS_PER_SECOND: u64 = 1_000_000_000_000;
/// 58 days, in seconds.
const MAX_SECONDS: f64 = 5e6;
/// Edges that the sample period is looked for in.
const GRID_EDGES: u64 = 1024;
/// Stretches of recording that may be kept.
const MAX_WAVEFORMS: u64 = 4096;

pub(crate) fn open(input: &Input, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let mut fields = fields(input, 0);
    if fields.array::<8>()? != MAGIC {
        return Err(CaptureError::damaged(Place::Byte(0), "no <SALEAE> here"));
    }
    let version = fields.u32()?;
    let kind = fields.u32()?;
    match (version, kind) {
        (0 | 1, 0) => open_digital(input, fields, version, options),
        (0 | 1, 1) => open_analogue(input, fields, version, options),
        (0 | 1, kind) => {
            let reason = format!("type {kind} is neither 0 (digital) nor 1 (analogue)");
            Err(CaptureError::damaged(Place::Byte(12), reason))
        }
        (version, _) => {
            Err(CaptureError::unsupported(FORMAT, format!("version {version} (0 and 1 are read)")))
        }
    }
}

type Reading = Fields<BufReader<Input>>;

fn fields(input: &Input, at: u64) -> Reading {
    Fields::new(BufReader::with_capacity(64 * 1024, input.at(at)), at)
}

/// One unbroken stretch of a digital file.
struct Chunk {
    high: bool,
    begin: f64,
    end: f64,
    edges: u64,
    samplerate: Option<f64>,
}

impl Chunk {
    fn read(fields: &mut Reading, version: u32) -> Result<Self, CaptureError> {
        let place = fields.place();
        let initial = fields.u32()?;
        if initial > 1 {
            let reason = format!("an initial state of {initial} is neither 0 nor 1");
            return Err(CaptureError::damaged(place, reason));
        }
        let samplerate = if version == 1 { Some(fields.f64()?) } else { None };
        let place = fields.place();
        let (begin, end) = (fields.f64()?, fields.f64()?);
        if !(begin.abs() <= MAX_SECONDS && end.abs() <= MAX_SECONDS && begin <= end) {
            let reason = format!("times from {begin:e} s to {end:e} s make no recording");
            return Err(CaptureError::damaged(place, reason));
        }
        let edges = fields.u64()?;
        Ok(Self { high: initial == 1, begin, end, edges, samplerate })
    }
}

/// `seconds` after `origin` in ticks.
fn ticks(seconds: f64, origin: f64) -> Option<u64> {
    let ticks = ((seconds - origin) * TICKS_PER_SECOND as f64).round();
    (0.0..=2.0 * MAX_SECONDS * TICKS_PER_SECOND as f64).contains(&ticks).then_some(ticks as u64)
}

struct Digital {
    input: Input,
    version: u32,
    /// Where the first chunk starts, and how many there are.
    at: u64,
    chunks: u64,
}

fn open_digital(
    input: &Input,
    mut fields: Reading,
    version: u32,
    options: &OpenOptions,
) -> Result<Capture, CaptureError> {
    let chunks = if version == 1 { fields.u64()? } else { 1 };
    if chunks == 0 {
        return Err(CaptureError::damaged(Place::Byte(16), "no recording is in the file"));
    }
    let at = fields.at();
    let first = Chunk::read(&mut fields, version)?;
    let timebase = Timebase::from_frequency(Hertz::new(TICKS_PER_SECOND).unwrap_or(Hertz::MAX));
    let stated = first.samplerate.and_then(rate);
    let samplerate = options.samplerate.or(stated);
    let resolution = match samplerate {
        Some(rate) => (TICKS_PER_SECOND / rate.hertz()).max(1),
        None => {
            let mut times = Vec::new();
            for _ in 0..first.edges.min(GRID_EDGES) {
                // Damage is reported when the edges are streamed.
                let Ok(time) = fields.f64() else { break };
                times.extend(ticks(time, first.begin));
            }
            grid::step(&times, timebase)
        }
    };
    let channels = vec![Channel::new("D0", ChannelKind::Digital, resolution)];
    let reader = Digital { input: input.clone(), version, at, chunks };
    Ok(Capture::new(FORMAT, timebase, samplerate, channels, reader))
}

fn rate(rate: f64) -> Option<Hertz> {
    // Out of range saturates, and is then refused.
    Hertz::new(rate.round() as u64)
}

impl Reader for Digital {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        if !out.wants(0) {
            return Ok(());
        }
        report.signals.iter_mut().for_each(|signal| *signal = Signal::Digital);
        let mut fields = fields(&self.input, self.at);
        let mut origin = None;
        let mut last = 0;
        for _ in 0..self.chunks {
            let place = fields.place();
            let chunk = Chunk::read(&mut fields, self.version)?;
            let origin = *origin.get_or_insert(chunk.begin);
            let begin =
                ticks(chunk.begin, origin).filter(|begin| *begin >= last).ok_or_else(|| {
                    CaptureError::damaged(place, "a chunk begins before the one above ends")
                })?;
            out.level(0, begin, if chunk.high { Logic::High } else { Logic::Low })?;
            last = begin;
            for _ in 0..chunk.edges {
                let place = fields.place();
                let time = fields.f64()?;
                let Some(at) = ticks(time, origin).filter(|at| *at >= last) else {
                    let reason = format!("an edge at {time:e} s is not after the one before");
                    return Err(CaptureError::damaged(place, reason).into());
                };
                out.edge(0, at)?;
                last = at;
            }
            last = last.max(ticks(chunk.end, origin).unwrap_or(last));
            out.end(0, last)?;
            out.progress(fields.at(), self.input.len());
        }
        Ok(())
    }
}

/// One unbroken stretch of an analogue file.
#[derive(Clone, Copy)]
struct Waveform {
    begin: f64,
    /// After down-sampling.
    samplerate: f64,
    samples: u64,
    /// Where the samples are in the file.
    at: u64,
}

impl Waveform {
    fn read(fields: &mut Reading, version: u32) -> Result<Self, CaptureError> {
        let place = fields.place();
        let begin = fields.f64()?;
        let rate = if version == 1 {
            fields.f64()?;
            fields.f64()?
        } else {
            fields.u64()? as f64
        };
        let downsample = fields.u64()?;
        let samples = fields.u64()?;
        let samplerate = rate / downsample as f64;
        if !(1e-3..=1e15).contains(&samplerate) || begin.is_nan() || begin.abs() > MAX_SECONDS {
            let reason = format!(
                "{rate:e} samples/s divided by {downsample} from {begin:e} s make no recording"
            );
            return Err(CaptureError::damaged(place, reason));
        }
        Ok(Self { begin, samplerate, samples, at: fields.at() })
    }
}

struct Analogue {
    input: Input,
    options: OpenOptions,
    waveforms: Vec<Waveform>,
    signal: Option<Signal>,
}

fn open_analogue(
    input: &Input,
    mut fields: Reading,
    version: u32,
    options: &OpenOptions,
) -> Result<Capture, CaptureError> {
    let count = if version == 1 { fields.u64()? } else { 1 };
    if count > MAX_WAVEFORMS {
        return Err(CaptureError::Limit {
            what: "the number of waveforms",
            value: count,
            max: MAX_WAVEFORMS,
        });
    }
    let mut waveforms: Vec<Waveform> = Vec::new();
    let mut at = fields.at();
    for _ in 0..count {
        if at >= input.len() && !waveforms.is_empty() {
            // The stream reports where the file ends.
            break;
        }
        let waveform = Waveform::read(&mut self::fields(input, at), version)?;
        at = waveform.samples.checked_mul(4).and_then(|n| n.checked_add(waveform.at)).ok_or_else(
            || CaptureError::damaged(Place::Byte(at), "more samples than any file holds"),
        )?;
        waveforms.push(waveform);
    }
    let first = *waveforms
        .first()
        .ok_or_else(|| CaptureError::damaged(Place::Byte(16), "no recording is in the file"))?;
    if waveforms.iter().any(|w| w.samplerate != first.samplerate) {
        return Err(CaptureError::unsupported(FORMAT, "waveforms of different sample rates"));
    }
    let (timebase, samplerate) = match options.samplerate {
        Some(rate) => Hertz::new(rate.hertz().saturating_mul(TICKS_PER_SAMPLE))
            .map(|fine| (Timebase::from_frequency(fine), rate)),
        None => {
            let period = format!("{:.14e}", 1.0 / first.samplerate);
            Decimal::parse(period.as_bytes()).and_then(|p| period_timebase(p, TICKS_PER_SAMPLE))
        }
    }
    .ok_or_else(|| CaptureError::damaged(Place::Byte(16), "the sample rate is out of range"))?;
    let channels = vec![Channel::new("A0", ChannelKind::Analogue, 1)];
    let reader = Analogue { input: input.clone(), options: *options, waveforms, signal: None };
    Ok(Capture::new(FORMAT, timebase, Some(samplerate), channels, reader))
}

impl Reader for Analogue {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        if !out.wants(0) {
            return Ok(());
        }
        let (input, waveforms) = (&self.input, &self.waveforms);
        let origin = waveforms.first().map_or(0.0, |w| w.begin);
        let open = |number: usize| -> Result<Option<Segment<'_>>, CaptureError> {
            let Some(waveform) = waveforms.get(number) else { return Ok(None) };
            let samples = (waveform.begin - origin) * waveform.samplerate;
            let begin = (samples * TICKS_PER_SAMPLE as f64).round().max(0.0) as u64;
            let bytes = Exactly { fields: fields(input, waveform.at), left: 4 * waveform.samples };
            Ok(Some((begin, Box::new(Floats::new(bytes)))))
        };
        let job = Job {
            channel: 0,
            step: TICKS_PER_SAMPLE,
            threshold: self.options.threshold,
            progress: (0, self.input.len()),
            open: &open,
        };
        job.stream(&mut self.signal, out, report)?;
        out.progress(self.input.len(), self.input.len());
        Ok(())
    }
}

/// So many bytes; fewer are damage.
struct Exactly {
    fields: Reading,
    left: u64,
}

impl crate::input::Bytes for Exactly {
    fn read_some(&mut self, buf: &mut [u8]) -> Result<usize, CaptureError> {
        if self.left == 0 {
            return Ok(0);
        }
        let want = usize::try_from(self.left).unwrap_or(usize::MAX).min(buf.len());
        let n = self.fields.read_some(buf.get_mut(..want).unwrap_or_default())?;
        if n == 0 {
            let reason = format!("the file ends {} bytes before its last sample", self.left);
            return Err(CaptureError::damaged(self.fields.place(), reason));
        }
        self.left -= n as u64;
        Ok(n)
    }
}
