//! sigrok session files, `.sr`, versions 1 and 2.
//!
//! Source: sigrok wiki, File format: Sigrok/v2; libsigrok `session_file.c` and `output/srzip.c`.

use std::collections::BTreeMap;

use canbaud::units::{Hertz, Timebase};

use crate::Format;
use crate::analogue::{self, Difference, Floats, Job, Segment, TICKS_PER_SAMPLE};
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt, Place};
use crate::ini::Ini;
use crate::input::Input;
use crate::packed::{Packed, Packing};
use crate::sink::Output;
use crate::zip::{Archive, Entry};

const FORMAT: Format = Format::SigrokSr;
const DEVICE: &str = "device 1";
/// More analogue channels than any instrument has.
const MAX_ANALOGUE: usize = 64;

struct Sr {
    archive: Archive,
    options: OpenOptions,
    total: u64,
    logic: Vec<Entry>,
    unit: usize,
    lines: Vec<(u32, usize)>,
    ticks_per_sample: u64,
    /// Kind and members of each channel that is not logic, with what is known of its levels.
    analogue: Vec<Wave>,
}

struct Wave {
    channel: usize,
    source: WaveSource,
    signal: Option<Signal>,
}

enum WaveSource {
    Members(Vec<Entry>),
    Difference(Vec<Entry>, Vec<Entry>),
}

fn is_wanted(name: &str) -> bool {
    matches!(name, "version" | "metadata")
        || name.starts_with("logic-1")
        || name.starts_with("analog-1-")
}

/// Whether a zip with these members is a sigrok session.
pub(crate) fn is_sr(names: &[&str]) -> bool {
    names.contains(&"metadata") && names.contains(&"version")
}

pub(crate) fn open(input: &Input, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let archive = Archive::open(input, FORMAT, is_wanted)?;
    check_version(&archive)?;
    let metadata = archive.text("metadata")?.ok_or_else(|| missing("metadata"))?;
    let ini = Ini::parse(&metadata);
    if !ini.has_section(DEVICE) {
        return Err(in_metadata("no section [device 1]"));
    }
    let samplerate = match options.samplerate {
        Some(rate) => rate,
        None => samplerate(&ini)?,
    };
    let unit = unit_size(&ini)?;
    let logic = match ini.get(DEVICE, "capturefile") {
        Some(name) => chunks(&archive, name)?,
        None => Vec::new(),
    };
    let mut channels = Vec::new();
    let lines =
        if logic.is_empty() { Vec::new() } else { logic_channels(&ini, unit, &mut channels) };
    let first_analogue = channels.len();
    let mut waves = analogue_channels(&archive, &ini, &mut channels)?;
    let (timebase, ticks_per_sample) = timebase(samplerate, !waves.is_empty());
    for (number, channel) in channels.iter_mut().enumerate() {
        let analogue = number >= first_analogue;
        channel.resolution_ticks = if analogue { 1 } else { ticks_per_sample };
    }
    for difference in analogue::differences(&channels) {
        let ChannelKind::Difference(high, low) = difference.kind else { continue };
        let members = |channel| {
            waves.iter().find(|w: &&Wave| w.channel == channel).and_then(|w| match &w.source {
                WaveSource::Members(members) => Some(members.clone()),
                WaveSource::Difference(..) => None,
            })
        };
        let (Some(high), Some(low)) = (members(high), members(low)) else { continue };
        let source = WaveSource::Difference(high, low);
        waves.push(Wave { channel: channels.len(), source, signal: None });
        channels.push(difference);
    }
    if channels.is_empty() {
        return Err(CaptureError::damaged(Place::Member("metadata".into()), "no channel has data"));
    }
    let total = inflated(&archive, options)?;
    let reader = Sr {
        archive,
        options: *options,
        total,
        logic,
        unit,
        lines,
        ticks_per_sample,
        analogue: waves,
    };
    Ok(Capture::new(FORMAT, timebase, Some(samplerate), channels, reader))
}

fn missing(name: &str) -> CaptureError {
    CaptureError::damaged(Place::Member(name.into()), "is missing from the archive")
}

fn in_metadata(reason: impl Into<String>) -> CaptureError {
    CaptureError::damaged(Place::Member("metadata".into()), reason)
}

fn check_version(archive: &Archive) -> Result<(), CaptureError> {
    let text = archive.text("version")?.ok_or_else(|| missing("version"))?;
    match text.trim() {
        "1" | "2" => Ok(()),
        other => {
            let other: String = other.chars().take(20).collect();
            Err(CaptureError::unsupported(FORMAT, format!("version {other:?} (1 and 2 are read)")))
        }
    }
}

fn samplerate(ini: &Ini<'_>) -> Result<Hertz, CaptureError> {
    let text = ini.get(DEVICE, "samplerate").ok_or(CaptureError::NoSamplerate(FORMAT))?;
    crate::number::hertz(text).ok_or_else(|| {
        let text: String = text.chars().take(40).collect();
        in_metadata(format!("samplerate {text:?} is not 1 Hz to {} Hz", Hertz::MAX.hertz()))
    })
}

fn unit_size(ini: &Ini<'_>) -> Result<usize, CaptureError> {
    let Some(text) = ini.get(DEVICE, "unitsize") else { return Ok(1) };
    match text.parse() {
        Ok(unit @ 1..=8) => Ok(unit),
        _ => {
            let text: String = text.chars().take(20).collect();
            Err(in_metadata(format!("unitsize {text:?} is not 1 to 8 bytes")))
        }
    }
}

/// The members of one stream: the undivided one, or the chunks in numeric order.
fn chunks(archive: &Archive, name: &str) -> Result<Vec<Entry>, CaptureError> {
    if let Some(whole) = archive.find(name) {
        return Ok(vec![whole.clone()]);
    }
    let mut numbered = BTreeMap::new();
    for entry in &archive.entries {
        let number = entry.name.strip_prefix(name).and_then(|rest| rest.strip_prefix('-'));
        let Some(number) = number.and_then(|n| n.parse::<u32>().ok()) else { continue };
        if numbered.insert(number, entry).is_some() {
            return Err(CaptureError::damaged(
                Place::Member(entry.name.to_string()),
                "there are two members with this number",
            ));
        }
    }
    for (number, wanted) in numbered.keys().zip(1..) {
        if *number != wanted {
            let place = Place::Member(format!("{name}-{wanted}"));
            return Err(CaptureError::damaged(place, "is missing from the archive"));
        }
    }
    if numbered.is_empty() {
        return Err(missing(name));
    }
    Ok(numbered.into_values().cloned().collect())
}

/// A probe without a name line is disabled; without any name line all of them are meant.
fn logic_channels(ini: &Ini<'_>, unit: usize, channels: &mut Vec<Channel>) -> Vec<(u32, usize)> {
    let bits = 8 * unit as u32;
    let mut named: BTreeMap<u32, String> = ini
        .numbered(DEVICE, "probe")
        .filter(|(number, _)| (1..=bits).contains(number))
        .map(|(number, name)| (number, name.to_owned()))
        .collect();
    if named.is_empty() {
        let total = ini.get(DEVICE, "total probes").and_then(|t| t.parse().ok()).unwrap_or(bits);
        named = (1..=total.min(bits)).map(|number| (number, format!("D{}", number - 1))).collect();
    }
    let mut lines = Vec::new();
    for (number, name) in named {
        lines.push((number - 1, channels.len()));
        channels.push(Channel::new(name, ChannelKind::Digital, 1));
    }
    lines
}

fn analogue_channels(
    archive: &Archive,
    ini: &Ini<'_>,
    channels: &mut Vec<Channel>,
) -> Result<Vec<Wave>, CaptureError> {
    let named: BTreeMap<u32, &str> = ini.numbered(DEVICE, "analog").collect();
    if named.len() > MAX_ANALOGUE {
        return Err(CaptureError::Limit {
            what: "the number of analogue channels",
            value: named.len() as u64,
            max: MAX_ANALOGUE as u64,
        });
    }
    let mut waves = Vec::new();
    for (number, name) in named {
        let members = chunks(archive, &format!("analog-1-{number}"))?;
        let source = WaveSource::Members(members);
        waves.push(Wave { channel: channels.len(), source, signal: None });
        channels.push(Channel::new(name, ChannelKind::Analogue, 1));
    }
    Ok(waves)
}

/// The tick is a sample, or a 16th of one where crossings are interpolated.
pub(crate) fn timebase(samplerate: Hertz, interpolated: bool) -> (Timebase, u64) {
    let fine = samplerate.hertz().checked_mul(TICKS_PER_SAMPLE).and_then(Hertz::new);
    match fine {
        Some(rate) if interpolated => (Timebase::from_frequency(rate), TICKS_PER_SAMPLE),
        _ => (Timebase::from_frequency(samplerate), 1),
    }
}

/// Bytes of all members together, checked against the limit.
pub(crate) fn inflated(archive: &Archive, options: &OpenOptions) -> Result<u64, CaptureError> {
    let total = archive.entries.iter().fold(0_u64, |sum, entry| sum.saturating_add(entry.size));
    if total > options.max_inflated {
        return Err(CaptureError::Limit {
            what: "the inflated size of the archive in bytes",
            value: total,
            max: options.max_inflated,
        });
    }
    Ok(total)
}

impl Reader for Sr {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        self.stream_logic(out, report)?;
        let size =
            |members: &[Entry]| members.iter().fold(0_u64, |sum, m| sum.saturating_add(m.size));
        let mut done = size(&self.logic);
        for wave in &mut self.analogue {
            if !out.wants(wave.channel) {
                continue;
            }
            let (archive, source) = (&self.archive, &wave.source);
            let open = |number: usize| -> Result<Option<Segment<'_>>, CaptureError> {
                if number > 0 {
                    return Ok(None);
                }
                Ok(Some(match source {
                    WaveSource::Members(members) => {
                        (0, Box::new(Floats::new(archive.chain(members.clone()))))
                    }
                    WaveSource::Difference(high, low) => {
                        let [high, low] = [high, low].map(|m| archive.chain(m.clone()));
                        (0, Box::new(Difference::new(high, low)))
                    }
                }))
            };
            let job = Job {
                channel: wave.channel,
                step: self.ticks_per_sample,
                threshold: self.options.threshold,
                progress: (done, self.total),
                open: &open,
            };
            job.stream(&mut wave.signal, out, report)?;
            if let WaveSource::Members(members) = &wave.source {
                done = done.saturating_add(size(members));
            }
        }
        out.progress(self.total, self.total);
        Ok(())
    }
}

impl Sr {
    fn stream_logic(&self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        let lines: Vec<(u32, usize)> =
            self.lines.iter().copied().filter(|&(_, channel)| out.wants(channel)).collect();
        if lines.is_empty() {
            return Ok(());
        }
        for &(_, channel) in &lines {
            if let Some(signal) = report.signals.get_mut(channel) {
                *signal = Signal::Digital;
            }
        }
        let mut packed = Packed::new(Packing::Words(self.unit), &lines, self.ticks_per_sample);
        let mut chain = self.archive.chain(self.logic.clone());
        let mut done = 0;
        let left = packed.pump(&mut chain, out, |out, bytes| {
            done += bytes;
            out.progress(done, self.total);
        })?;
        if left > 0 {
            report.notes.push(format!(
                "the logic data ends with {left} bytes that do not fill a sample of {} bytes",
                self.unit
            ));
        }
        packed.end(out)
    }
}
