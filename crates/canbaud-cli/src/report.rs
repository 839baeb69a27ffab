//! What is known about one channel of one source; text and JSON are made from this.

mod live;

pub(crate) use live::{LiveRate, LiveReport};

/// One bit rate of a channel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rate {
    /// In bit/s: the known rate that was meant, or the measured one rounded.
    pub(crate) bitrate: u32,
    /// In bit/s, as measured against the clock of the capture.
    pub(crate) measured: f64,
    /// One standard deviation.
    pub(crate) uncertainty_ppm: f64,
    /// Who uses the known rate that was meant.
    pub(crate) known_as: Option<&'static str>,
}

/// The outcome for one channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Found,
    Undecided,
    NoTraffic,
    Conflict,
}

/// Frames by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct FrameCounts {
    pub(crate) classic: u64,
    pub(crate) fd: u64,
    /// CAN FD frames that switched the bit rate.
    pub(crate) fd_brs: u64,
    /// CAN FD frames with the non-ISO CRC.
    pub(crate) fd_non_iso: u64,
    pub(crate) remote: u64,
    pub(crate) extended: u64,
    /// Destroyed.
    pub(crate) error: u64,
    /// In which the recording begins or ends.
    pub(crate) truncated: u64,
    pub(crate) overload: u64,
    /// Good frames whose ACK slot was recessive.
    pub(crate) unacknowledged: u64,
}

/// A remark that a reader should know of, with what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Caveat {
    /// Stable, snake_case.
    pub(crate) code: &'static str,
    /// One sentence, with the hint.
    pub(crate) text: String,
}

/// Everything about one channel of one source.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChannelReport {
    pub(crate) channel: String,
    pub(crate) inverted: bool,
    pub(crate) outcome: Outcome,
    /// For `Undecided`: what is missing, one sentence.
    pub(crate) need: Option<String>,
    pub(crate) nominal: Option<Rate>,
    pub(crate) data: Option<Rate>,
    /// For `Conflict`: the second rate.
    pub(crate) other: Option<Rate>,
    pub(crate) proven_frames: u64,
    pub(crate) frames: FrameCounts,
    /// Upper bound on the probability that the rate is wrong.
    pub(crate) error_probability: f64,
    /// 0 to 1.
    pub(crate) bus_load: f64,
    /// How much longer a dominant bit is than a recessive one is short, in ns.
    pub(crate) asymmetry_ns: Option<f64>,
    /// Largest minus smallest clock of the senders.
    pub(crate) clock_spread_ppm: Option<f64>,
    /// Samples or ticks per nominal bit.
    pub(crate) samples_per_bit: Option<f64>,
    pub(crate) duration_s: f64,
    pub(crate) edges: u64,
    pub(crate) caveats: Vec<Caveat>,
}

#[cfg(test)]
pub(crate) mod samples;
