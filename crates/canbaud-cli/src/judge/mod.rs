//! Local check only.
use std::ops::ControlFlow;

use canbaud::detect::{DataPhase, PulseDetector, Verdict, find_data_rate};
use canbaud::units::Bitrate;
use canbaud::wire::*;
use canbaud_capture::{Capture, CaptureError, EdgeSink};

use crate::report::{ChannelReport, FrameCounts, Outcome, Rate};

#[derive(Debug, Clone)]
#[allow(dead_code)]
pub(crate) struct JudgeOptions {
    pub(crate) channel: Option<String>,
    pub(crate) bitrate: Option<Bitrate>,
    pub(crate) data_bitrate: Option<Bitrate>,
    pub(crate) polarity: Option<Polarity>,
}

struct Det<'a>(Vec<(PulseDetector<800>, u64, u64, u64)>, &'a mut dyn FnMut(u64, u64));
impl EdgeSink for Det<'_> {
    fn begin(&mut self, c: usize, at: u64, level: Logic) {
        self.0[c].0.begin(at, level);
        self.0[c].1 = at;
    }
    fn edges(&mut self, c: usize, t: &[u64]) -> ControlFlow<()> {
        for &t in t {
            self.0[c].0.push(t);
        }
        self.0[c].3 += t.len() as u64;
        ControlFlow::Continue(())
    }
    fn end(&mut self, c: usize, at: u64) {
        self.0[c].0.finish(at);
        self.0[c].2 = at;
    }
    fn progress(&mut self, a: u64, b: u64) {
        (self.1)(a, b);
    }
}
struct Dec<'a>(Option<Decoder<800>>, Polarity, usize, L<'a>);
struct L<'a>(&'a mut dyn FnMut(&Item) -> ControlFlow<()>, bool, FrameCounts);
impl Listener for L<'_> {
    fn item(&mut self, d: &Decoded) {
        if self.1 {
            return;
        }
        match &d.item.kind {
            ItemKind::Frame(r) => {
                match r.frame.kind() {
                    FrameKind::Data => self.2.classic += 1,
                    FrameKind::Remote => self.2.remote += 1,
                    FrameKind::Fd { brs, .. } => {
                        self.2.fd += 1;
                        self.2.fd_brs += u64::from(brs);
                    }
                }
                self.2.extended += u64::from(r.frame.id().is_extended());
                self.2.unacknowledged += u64::from(!r.acknowledged);
            }
            ItemKind::Error(_) => self.2.error += 1,
            ItemKind::Overload => self.2.overload += 1,
        }
        self.1 = (self.0)(&d.item).is_break();
    }
    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        find_data_rate(wanted)
    }
}
impl EdgeSink for Dec<'_> {
    fn begin(&mut self, c: usize, at: u64, level: Logic) {
        if c == self.2
            && let Some(d) = &mut self.0
        {
            d.begin(at, self.1.level(level));
        }
    }
    fn edges(&mut self, c: usize, t: &[u64]) -> ControlFlow<()> {
        if c == self.2
            && let Some(d) = &mut self.0
        {
            d.edges(t, &mut self.3);
        }
        if self.3.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
    fn end(&mut self, c: usize, at: u64) {
        if c == self.2
            && let Some(d) = &mut self.0
        {
            d.finish(at, &mut self.3);
        }
    }
}

fn judge(
    capture: &mut Capture,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<(ChannelReport, Option<BusTiming>, usize)>, CaptureError> {
    let n = capture.channels().len();
    let mut s = Det((0..n).map(|_| (PulseDetector::new(), 0, 0, 0)).collect(), progress);
    capture.stream(&mut s)?;
    let tb = capture.timebase();
    let hz = tb.ticks() as f64 / tb.seconds() as f64;
    let mut out = Vec::new();
    for (i, (det, begin, end, edges)) in s.0.iter().enumerate() {
        let mut r = blank(&capture.channels()[i].name);
        r.edges = *edges;
        r.duration_s = (end - begin) as f64 / hz;
        let rate = |ticks: u64, ppb: u32| {
            let m = hz / (ticks as f64 / 1048576.0);
            let k = 500.0;
            let snap = (m / k).round() * k;
            let b = if (snap / m - 1.0).abs() < 1e-3 { snap } else { m.round() };
            Rate {
                bitrate: b as u32,
                measured: m,
                uncertainty_ppm: f64::from(ppb) / 1000.0,
                known_as: None,
            }
        };
        match det.verdict() {
            Verdict::Found(f) => {
                r.outcome = Outcome::Found;
                r.inverted = f.polarity == Polarity::Inverted;
                r.nominal = Some(rate(f.nominal.ticks_q20, f.nominal.uncertainty_ppb));
                r.samples_per_bit = Some(f.nominal.ticks_q20 as f64 / 1048576.0);
                if let DataPhase::Switched(d) = f.data {
                    r.data = Some(rate(d.ticks_q20, d.uncertainty_ppb));
                }
                r.proven_frames = u64::from(f.proven_frames);
                r.error_probability = 2f64.powi(-(f.proof_bits as i32));
            }
            Verdict::Undecided(n) => {
                r.outcome = Outcome::Undecided;
                r.need = Some(format!("{n:?}"));
            }
            Verdict::NoTraffic => {}
            Verdict::Conflict { .. } => r.outcome = Outcome::Conflict,
        }
        out.push((r, det.bus_timing(), i));
    }
    out.sort_by_key(|(r, _, _)| {
        (
            r.outcome != Outcome::Found,
            r.outcome == Outcome::NoTraffic,
            std::cmp::Reverse(r.proven_frames),
        )
    });
    Ok(out)
}

pub(crate) fn detect(
    capture: &mut Capture,
    _o: &JudgeOptions,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<ChannelReport>, CaptureError> {
    let mut v = judge(capture, progress)?;
    let timing = v[0].1;
    if timing.is_some() {
        let mut sink = |_: &Item| ControlFlow::Continue(());
        let mut dec = Dec(
            timing.and_then(|t| Decoder::new(&t)),
            if v[0].0.inverted { Polarity::Inverted } else { Polarity::Normal },
            v[0].2,
            L(&mut sink, false, FrameCounts::default()),
        );
        capture.stream(&mut dec)?;
        v[0].0.frames = dec.3.2;
    }
    Ok(v.into_iter().map(|v| v.0).collect())
}

pub(crate) fn decode(
    capture: &mut Capture,
    _o: &JudgeOptions,
    sink: &mut dyn FnMut(&Item) -> ControlFlow<()>,
) -> Result<ChannelReport, CaptureError> {
    let (mut r, timing, i) = judge(capture, &mut |_, _| ())?.remove(0);
    let mut dec = Dec(
        timing.and_then(|t| Decoder::new(&t)),
        if r.inverted { Polarity::Inverted } else { Polarity::Normal },
        i,
        L(sink, false, FrameCounts::default()),
    );
    capture.stream(&mut dec)?;
    r.frames = dec.3.2;
    Ok(r)
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
