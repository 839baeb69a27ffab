//! From the first capture to a bit rate: all of it but the interrupt controller and sleep.

use crate::{Capture, Registers};
use canbaud::detect::{CompactDetector, Found, Verdict};
use canbaud::rates;
use canbaud::units::{Bitrate, Hertz, Timebase};
use canbaud_capture_queue::{CaptureQueue, Recorder};

/// Measures the bit rate of the bus, once.
#[derive(Debug)]
pub struct Measurement {
    detector: CompactDetector<128>,
    recorder: Recorder,
    clock: Hertz,
}

/// How far a measurement is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measured {
    /// More edges are wanted.
    NotYet,
    /// The bit rate.
    Rate(Bitrate),
    /// A frame was read, at a bit rate that no bus has.
    OutOfRange,
}

impl Measurement {
    /// Starts the timer, whose clock is `clock`, and forgets what is in the queue. The interrupt of
    /// the timer is masked; it may be unmasked from now on, whenever that is.
    pub fn start<R: Registers, const N: usize>(
        timer: &mut Capture<R>,
        queue: &CaptureQueue<N>,
        clock: Hertz,
    ) -> Self {
        timer.start();
        queue.clear();
        Self { detector: CompactDetector::new(), recorder: Recorder::new(0), clock }
    }

    /// Takes what is in the queue.
    pub fn turn<const N: usize>(&mut self, queue: &CaptureQueue<N>) -> Measured {
        self.recorder.take(queue, &mut self.detector);
        match self.detector.verdict() {
            Verdict::Found(found) => {
                self.bitrate(&found).map_or(Measured::OutOfRange, Measured::Rate)
            }
            _ => Measured::NotYet,
        }
    }

    /// The rate that is meant, where only one in use is that close.
    fn bitrate(&self, found: &Found) -> Option<Bitrate> {
        let measured = found.nominal.millibits_per_second(Timebase::from_frequency(self.clock))?;
        let known = rates::nearest(rates::nominal(), measured, found.nominal.uncertainty_ppb);
        let rate = known.map_or(measured, |known| known.millibits_per_second());
        Bitrate::new(u32::try_from((rate + 500) / 1000).ok()?)
    }
}
