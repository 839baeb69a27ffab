//! DSView sessions, `.dsl` and `.demo`, version 3, logic data.
//!
//! Source: DSView `storesession.cpp` at 2e9e2c8e. One bit per sample, least significant bit first,
//! in blocks of 2^24 samples, one member per channel and block.

use std::collections::BTreeMap;

use canbaud::units::Hertz;

use crate::Format;
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt, Place};
use crate::ini::Ini;
use crate::input::Input;
use crate::number;
use crate::packed::{Packed, Packing};
use crate::sink::Output;
use crate::sr;
use crate::zip::{Archive, Entry};

const FORMAT: Format = Format::DsView;
const SECTION: &str = "header";
/// More than any DSLogic has.
const MAX_CHANNELS: usize = 64;

/// Whether a zip with these members is a DSView session.
pub(crate) fn is_dsview(names: &[&str]) -> bool {
    names.contains(&"header")
}

struct DsView {
    archive: Archive,
    /// The blocks of each channel in order.
    blocks: Vec<Vec<Entry>>,
    samples: u64,
    total: u64,
}

/// Channel and block of `L-<channel>/<block>`.
fn block(name: &str) -> Option<(u32, u32)> {
    let (channel, block) = name.strip_prefix("L-")?.split_once('/')?;
    Some((channel.parse().ok()?, block.parse().ok()?))
}

pub(crate) fn open(input: &Input, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let is_wanted = |name: &str| name == "header" || name == "data" || block(name).is_some();
    let archive = Archive::open(input, FORMAT, is_wanted)?;
    let text = archive.text("header")?.ok_or_else(|| in_header("is missing from the archive"))?;
    let ini = Ini::parse(&text);
    match ini.get("version", "version") {
        Some("3") => {}
        other => {
            let other: String = other.unwrap_or("(none)").chars().take(20).collect();
            let what = format!("version {other} (3 is read; save the session again in DSView)");
            return Err(CaptureError::unsupported(FORMAT, what));
        }
    }
    if !matches!(ini.get(SECTION, "device mode"), None | Some("0")) {
        return Err(CaptureError::unsupported(
            FORMAT,
            "oscilloscope data (logic data is read; export CSV in DSView)",
        ));
    }
    let samplerate = match (options.samplerate, ini.get(SECTION, "samplerate")) {
        (Some(rate), _) => rate,
        (None, None) => return Err(CaptureError::NoSamplerate(FORMAT)),
        (None, Some(text)) => number::hertz(text).ok_or_else(|| {
            let text: String = text.chars().take(40).collect();
            in_header(format!("samplerate {text:?} is not 1 Hz to {} Hz", Hertz::MAX.hertz()))
        })?,
    };
    let samples = ini.get(SECTION, "total samples").and_then(|n| n.parse().ok());
    let samples = samples.ok_or_else(|| in_header("\"total samples\" is missing or no number"))?;
    let (channels, blocks) = channels(&archive, &ini)?;
    let total = sr::inflated(&archive, options)?;
    let (timebase, _) = sr::timebase(samplerate, false);
    let reader = DsView { archive, blocks, samples, total };
    Ok(Capture::new(FORMAT, timebase, Some(samplerate), channels, reader))
}

fn in_header(reason: impl Into<String>) -> CaptureError {
    CaptureError::damaged(Place::Member("header".into()), reason)
}

/// The channels that have data, in the order of their numbers (which count from 0).
fn channels(
    archive: &Archive,
    ini: &Ini<'_>,
) -> Result<(Vec<Channel>, Vec<Vec<Entry>>), CaptureError> {
    let mut found: BTreeMap<u32, BTreeMap<u32, Entry>> = BTreeMap::new();
    for entry in &archive.entries {
        if let Some((channel, number)) = block(&entry.name)
            && found.entry(channel).or_default().insert(number, entry.clone()).is_some()
        {
            let place = Place::Member(entry.name.to_string());
            return Err(CaptureError::damaged(place, "there are two members with this number"));
        }
    }
    if found.is_empty() {
        return Err(in_header("the archive has no logic data (no member L-0/0)"));
    }
    if found.len() > MAX_CHANNELS {
        return Err(CaptureError::Limit {
            what: "the number of channels",
            value: found.len() as u64,
            max: MAX_CHANNELS as u64,
        });
    }
    let names: BTreeMap<u32, &str> = ini.numbered(SECTION, "probe").collect();
    let mut channels = Vec::new();
    let mut blocks = Vec::new();
    for (number, members) in found {
        if let Some((missing, _)) = (0..).zip(members.keys()).find(|(n, key)| n != *key) {
            let place = Place::Member(format!("L-{number}/{missing}"));
            return Err(CaptureError::damaged(place, "is missing from the archive"));
        }
        let name =
            names.get(&number).map_or_else(|| format!("D{number}"), |name| (*name).to_owned());
        channels.push(Channel::new(name, ChannelKind::Digital, 1));
        blocks.push(members.into_values().collect());
    }
    Ok((channels, blocks))
}

impl Reader for DsView {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        let mut done = 0;
        for (channel, entries) in self.blocks.iter().enumerate() {
            if !out.wants(channel) {
                continue;
            }
            if let Some(signal) = report.signals.get_mut(channel) {
                *signal = Signal::Digital;
            }
            let mut packed =
                Packed::new(Packing::Bits, &[(0, channel)], 1).limited_to(self.samples);
            let mut chain = self.archive.chain(entries.clone());
            packed.pump(&mut chain, out, |out, bytes| {
                done += bytes;
                out.progress(done, self.total);
            })?;
            if packed.position() < self.samples {
                report.notes.push(format!(
                    "channel {channel} has {} samples, the header says {}",
                    packed.position(),
                    self.samples
                ));
            }
            packed.end(out)?;
        }
        out.progress(self.total, self.total);
        Ok(())
    }
}
