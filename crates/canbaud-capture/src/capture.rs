//! An open capture.

use canbaud::units::{Hertz, Timebase};

use crate::Format;
use crate::analogue::{Levels, Threshold};
use crate::error::{CaptureError, Halt};
use crate::sink::{EdgeSink, Output};

/// How to read a capture; the default finds everything from the content.
///
/// ```
/// use canbaud_capture::{Format, OpenOptions, WordSize};
/// use canbaud::units::Hertz;
/// let options = OpenOptions {
///     format: Some(Format::Logic1Samples(WordSize::Bits8)),
///     samplerate: Hertz::new(24_000_000),
///     ..OpenOptions::default()
/// };
/// assert_eq!(options.max_inflated, OpenOptions::DEFAULT_MAX_INFLATED);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct OpenOptions {
    /// Reads the file as this format, whatever its content looks like.
    pub format: Option<Format>,
    /// The sample rate, for files that do not hold theirs; replaces the one in the file.
    pub samplerate: Option<Hertz>,
    /// The threshold of analogue channels; found from the signal if `None`.
    pub threshold: Option<Threshold>,
    /// Bytes that the members of a zip archive may inflate to, taken together: bounds the time a
    /// zip bomb can take.
    pub max_inflated: u64,
}

impl OpenOptions {
    /// 64 GiB: about half a minute of inflating.
    pub const DEFAULT_MAX_INFLATED: u64 = 64 << 30;
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self {
            format: None,
            samplerate: None,
            threshold: None,
            max_inflated: Self::DEFAULT_MAX_INFLATED,
        }
    }
}

/// What a channel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ChannelKind {
    /// Recorded as two levels.
    Digital,
    /// Recorded as voltages; edges are threshold crossings.
    Analogue,
    /// Computed: the voltage of the first channel minus that of the second.
    Difference(usize, usize),
}

/// One channel of a capture.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Channel {
    /// The name in the file, or `D0`, `CH1`, … where it has none.
    pub name: String,
    /// What it is.
    pub kind: ChannelKind,
    /// Quantisation step of its edge times in ticks, at least 1.
    pub resolution_ticks: u64,
}

impl Channel {
    pub(crate) fn new(name: impl Into<String>, kind: ChannelKind, resolution_ticks: u64) -> Self {
        Self { name: name.into(), kind, resolution_ticks: resolution_ticks.max(1) }
    }
}

/// What became of a channel in a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Signal {
    /// Not selected, or never reached.
    NotRead,
    /// Digital: there was nothing to decide.
    Digital,
    /// Analogue, with these two levels.
    TwoLevels(Levels),
    /// Analogue, and no two levels can be told apart: no edges.
    Flat,
}

/// One channel after a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ChannelSummary {
    /// Edges handed over.
    pub edges: u64,
    /// What the channel turned out to be.
    pub signal: Signal,
}

/// What a stream delivered.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// One entry per channel of the capture.
    pub channels: Vec<ChannelSummary>,
    /// What a person should know about the file: tolerated oddities.
    pub notes: Vec<String>,
    /// The sink stopped the stream before its end.
    pub stopped: bool,
}

/// What a reader has to say besides edges.
pub(crate) struct Report {
    pub(crate) signals: Vec<Signal>,
    pub(crate) notes: Vec<String>,
}

/// One file being read.
pub(crate) trait Reader: Send {
    /// Streams the wanted channels from the start.
    fn stream(&mut self, out: &mut Output<'_>, report: &mut Report) -> Result<(), Halt>;
}

/// An open capture file.
pub struct Capture {
    pub(crate) format: Format,
    pub(crate) timebase: Timebase,
    pub(crate) samplerate: Option<Hertz>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) selected: Vec<bool>,
    pub(crate) reader: Box<dyn Reader>,
}

impl Capture {
    pub(crate) fn new(
        format: Format,
        timebase: Timebase,
        samplerate: Option<Hertz>,
        channels: Vec<Channel>,
        reader: impl Reader + 'static,
    ) -> Self {
        let selected = vec![true; channels.len()];
        Self { format, timebase, samplerate, channels, selected, reader: Box::new(reader) }
    }

    /// The format the file is read as.
    #[must_use]
    pub const fn format(&self) -> Format {
        self.format
    }

    /// How long a tick of the edge times is.
    #[must_use]
    pub const fn timebase(&self) -> Timebase {
        self.timebase
    }

    /// The sample rate, rounded to 1 Hz, if the file or the options hold it.
    #[must_use]
    pub const fn samplerate(&self) -> Option<Hertz> {
        self.samplerate
    }

    /// The coarsest quantisation step among the channels, in ticks, at least 1.
    #[must_use]
    pub fn resolution_ticks(&self) -> u64 {
        self.channels.iter().map(|channel| channel.resolution_ticks).max().unwrap_or(1)
    }

    /// The channels; an edge names its channel by the position here.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Streams only these channels from now on; numbers that do not exist select nothing.
    ///
    /// Channels that are not selected cost next to nothing.
    pub fn select(&mut self, channels: &[usize]) {
        for (number, selected) in self.selected.iter_mut().enumerate() {
            *selected = channels.contains(&number);
        }
    }

    /// Streams the selected channels from the start of the file; can be called again.
    ///
    /// Times of all channels count from the same origin, the start of the recording.
    ///
    /// # Errors
    /// Damage is reported after everything that precedes it was handed over and `end` was called.
    pub fn stream(&mut self, sink: &mut dyn EdgeSink) -> Result<Summary, CaptureError> {
        let mut out = Output::new(sink, &self.selected);
        let mut report =
            Report { signals: vec![Signal::NotRead; self.channels.len()], notes: Vec::new() };
        let stopped = match self.reader.stream(&mut out, &mut report) {
            Ok(()) => false,
            Err(Halt::Stopped) => true,
            Err(Halt::Failed(error)) => {
                out.end_all();
                return Err(error);
            }
        };
        let channels = report
            .signals
            .iter()
            .enumerate()
            .map(|(channel, &signal)| ChannelSummary { edges: out.edge_count(channel), signal })
            .collect();
        Ok(Summary { channels, notes: report.notes, stopped })
    }
}

impl core::fmt::Debug for Capture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Capture")
            .field("format", &self.format)
            .field("timebase", &self.timebase)
            .field("samplerate", &self.samplerate)
            .field("channels", &self.channels)
            .finish_non_exhaustive()
    }
}
