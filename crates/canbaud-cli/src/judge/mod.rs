//! Temporary shim: the interface of the glue between captures and the detector, replaced by it.

use std::ops::ControlFlow;

use canbaud::units::Bitrate;
use canbaud::wire::{Item, Polarity};
use canbaud_capture::{Capture, CaptureError};

use crate::report::{ChannelReport, FrameCounts, Outcome};

#[derive(Debug, Clone)]
#[allow(dead_code)]
pub(crate) struct JudgeOptions {
    pub(crate) channel: Option<String>,
    pub(crate) bitrate: Option<Bitrate>,
    pub(crate) data_bitrate: Option<Bitrate>,
    pub(crate) polarity: Option<Polarity>,
}

pub(crate) fn detect(
    capture: &mut Capture,
    _options: &JudgeOptions,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<ChannelReport>, CaptureError> {
    progress(1, 1);
    Ok(capture.channels().iter().map(|channel| blank(&channel.name)).collect())
}

pub(crate) fn decode(
    capture: &mut Capture,
    _options: &JudgeOptions,
    _sink: &mut dyn FnMut(&Item) -> ControlFlow<()>,
) -> Result<ChannelReport, CaptureError> {
    Ok(blank(capture.channels().first().map_or("", |channel| &channel.name)))
}

fn blank(channel: &str) -> ChannelReport {
    ChannelReport {
        channel: channel.to_owned(),
        inverted: false,
        outcome: Outcome::NoTraffic,
        need: None,
        nominal: None,
        data: None,
        other: None,
        proven_frames: 0,
        frames: FrameCounts::default(),
        error_probability: 1.0,
        bus_load: 0.0,
        asymmetry_ns: None,
        clock_spread_ppm: None,
        samples_per_bit: None,
        duration_s: 0.0,
        edges: 0,
        caveats: Vec::new(),
    }
}
