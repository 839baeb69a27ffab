//! Header and edges.

use canbaud::units::Hertz;
use canbaud::wire::Logic;

use super::block::{self, Block};
use super::numbers::{MAGIC, Numbers};
use super::runs::{Runs, Step};
use crate::Format;
use crate::capture::{Capture, Channel, ChannelKind, OpenOptions, Reader, Report, Signal};
use crate::error::{CaptureError, Halt, Place};
use crate::input::Input;
use crate::sink::Output;
use crate::sr;

const FORMAT: Format = Format::LogicData;
const VERSION: u64 = 5;
const TITLE: &[u8] = b"Data save";
/// Bytes of the head that are looked at.
const HEAD: usize = 4096;
const MAX_CHANNELS: u64 = 64;
/// Runs between two words on the progress.
const PROGRESS: u64 = 64 * 1024;

struct LogicData {
    input: Input,
    blocks: Vec<Block>,
}

pub(crate) fn open(input: &Input, options: &OpenOptions) -> Result<Capture, CaptureError> {
    let head = input.bytes(0, HEAD)?;
    let [MAGIC, rest @ ..] = head.as_slice() else {
        return Err(CaptureError::damaged(Place::Byte(0), "no .logicdata starts like this"));
    };
    let mut numbers = Numbers::new(rest);
    let cut = || CaptureError::damaged(Place::Byte(1), "the header makes no sense");
    let version = numbers.number().ok_or_else(cut)?;
    let title = numbers.string().ok_or_else(cut)?;
    if version != VERSION || title != TITLE {
        let title = String::from_utf8_lossy(title.get(..20).unwrap_or(title)).into_owned();
        let what = format!(
            "version {version} ({title:?}); version {VERSION} (\"Data save\") is read: export the \
             capture as CSV or binary in the Logic program"
        );
        return Err(CaptureError::unsupported(FORMAT, what));
    }
    let rate_at = 1 + numbers.used() as u64;
    let stated = numbers.number().and_then(Hertz::new);
    let samplerate = options.samplerate.or(stated).ok_or_else(|| {
        CaptureError::damaged(Place::Byte(rate_at), "the sample rate is out of range")
    })?;
    let names = names(&mut numbers.clone()).unwrap_or_default();
    let blocks = block::find(input, 1 + numbers.used() as u64)?;
    if blocks.is_empty() {
        let reason = "no channel with edges follows the header (or the file is cut short)";
        return Err(CaptureError::damaged(Place::Byte(rate_at), reason));
    }
    // A channel without edges has no block: with fewer blocks than names the names cannot be told.
    let named = names.len() == blocks.len();
    let channel = |n: usize| {
        let name = if named { names.get(n).cloned() } else { None };
        Channel::new(name.unwrap_or_else(|| format!("Channel {n}")), ChannelKind::Digital, 1)
    };
    let channels = (0..blocks.len()).map(channel).collect();
    let (timebase, _) = sr::timebase(samplerate, false);
    let reader = LogicData { input: input.clone(), blocks };
    Ok(Capture::new(FORMAT, timebase, Some(samplerate), channels, reader))
}

/// After the rate: pre-trigger span, requested samples, number of channels, their ids and names.
fn names(numbers: &mut Numbers<'_>) -> Option<Vec<String>> {
    numbers.number()?;
    numbers.number()?;
    let count = numbers.number().filter(|count| (1..=MAX_CHANNELS).contains(count))?;
    for _ in 0..count {
        numbers.number()?;
    }
    let name = |_| {
        let name = core::str::from_utf8(numbers.string()?).ok()?;
        let is_name = !name.is_empty() && name.len() <= 64 && !name.contains(char::is_control);
        is_name.then(|| name.to_owned())
    };
    (0..count).map(name).collect()
}

impl Reader for LogicData {
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt> {
        for (channel, block) in self.blocks.iter().enumerate() {
            if !out.wants(channel) {
                continue;
            }
            if let Some(signal) = report.signals.get_mut(channel) {
                *signal = Signal::Digital;
            }
            let mut runs = Runs::new(&self.input, block);
            let mut count = 0_u64;
            loop {
                let at = runs.position();
                match runs.step()? {
                    Step::Run { samples: 0, .. } => {}
                    Step::Run { high, samples } => {
                        // The first step may move the position to where the recording starts.
                        let begin = runs.position().saturating_sub(samples).max(at);
                        out.level(channel, begin, if high { Logic::High } else { Logic::Low })?;
                    }
                    Step::End => break,
                }
                count += 1;
                if count.is_multiple_of(PROGRESS) {
                    out.progress(channel as u64, self.blocks.len() as u64);
                }
            }
            out.end(channel, runs.position())?;
        }
        out.progress(self.input.len(), self.input.len());
        Ok(())
    }
}
