//! One sender: frames, error flags and acknowledges as dominant intervals on the time axis.

use super::line::{Dominant, End, Grid, Phase};
use canbaud::wire::{EncodedFrame, Level};

/// The clock of a sender, in ticks of the recorder.
#[derive(Debug, Clone, Copy)]
pub struct BitClock {
    /// Nominal bit time.
    pub nominal: f64,
    /// Data bit time.
    pub data: f64,
    /// Nominal sample point, as a fraction of the bit.
    pub nominal_sample_point: f64,
    /// Data sample point, as a fraction of the bit.
    pub data_sample_point: f64,
}

/// What becomes of the ACK slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ack {
    /// Nobody acknowledges, the sender is error passive: the line stays recessive.
    Silent,
    /// Nobody acknowledges, the sender sends its active error flag over the ACK delimiter.
    ErrorFlag,
    /// Dominant, late and longer than one bit, both as a fraction of the bit.
    Given { delay: f64, longer: f64 },
}

/// A frame that somebody destroys with an error flag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Destroyed {
    /// The flag begins at the start of this bit.
    pub bit: usize,
    /// Dominant bits: 6 to 12, as the flags of several nodes overlap.
    pub flag_bits: u32,
    /// By how much of a bit the flag is late.
    pub delay: f64,
}

/// Another node that loses the arbitration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contender {
    /// Bits that both send.
    pub bits: usize,
    /// How late the other node's edges arrive, as a fraction of the bit.
    pub delay: f64,
}

/// Plays frames one after the other.
#[derive(Debug, Clone)]
pub struct Player {
    pub intervals: Vec<Dominant>,
    /// End of everything so far, in ticks.
    pub now: f64,
    blocks: u32,
}

impl Player {
    /// A quiet bus at time 0.
    pub const fn new() -> Self {
        Self { intervals: Vec::new(), now: 0.0, blocks: 0 }
    }

    /// Lets the bus be recessive for some ticks.
    pub fn idle(&mut self, ticks: f64) {
        self.now += ticks;
    }

    /// A frame up to its last EOF bit, or up to its error delimiter if nobody acknowledges.
    pub fn frame(
        &mut self,
        frame: &EncodedFrame,
        clock: &BitClock,
        ack: Ack,
        contender: Option<Contender>,
    ) {
        let edges = boundaries(frame, clock, self.now);
        self.send(frame, &edges, frame.bits.len());
        if let Some(contender) = contender {
            self.contend(frame, &edges, contender, clock.nominal);
        }
        let slot = frame.crc_delimiter + 1;
        match ack {
            Ack::Silent => self.now = edges[frame.bits.len()],
            Ack::Given { delay, longer } => {
                let start = edges[slot] + delay * clock.nominal;
                self.drive(start, start + (1.0 + longer) * clock.nominal);
                self.now = edges[frame.bits.len()];
            }
            Ack::ErrorFlag => self.error_flag(edges[slot + 1], 6, clock.nominal),
        }
    }

    /// A frame that breaks off in an error flag, and the error delimiter.
    pub fn destroyed(&mut self, frame: &EncodedFrame, clock: &BitClock, how: Destroyed) {
        let edges = boundaries(frame, clock, self.now);
        self.send(frame, &edges, how.bit);
        self.error_flag(edges[how.bit] + how.delay * clock.nominal, how.flag_bits, clock.nominal);
    }

    /// Takes the intervals from `first` on off the grid: no estimator is asked to use them.
    pub fn untag(&mut self, first: usize) {
        for interval in &mut self.intervals[first..] {
            interval.start.grid = None;
            interval.end.grid = None;
        }
    }

    /// Dominant error flag and recessive error delimiter.
    fn error_flag(&mut self, start: f64, bits: u32, bit_time: f64) {
        let end = start + f64::from(bits) * bit_time;
        self.drive(start, end);
        self.now = end + 8.0 * bit_time;
    }

    /// Dominant from `start` to `end`, off the grid.
    pub fn drive(&mut self, start: f64, end: f64) {
        self.intervals.push(Dominant { start: End::free(start), end: End::free(end) });
    }

    /// The first `count` bits of the frame.
    fn send(&mut self, frame: &EncodedFrame, edges: &[f64], count: usize) {
        let mut start = None;
        for index in 0..=count {
            let dominant = index < count && frame.bits.level(index) == Level::Dominant;
            match (start, dominant) {
                (None, true) => start = Some(index),
                (Some(first), false) => {
                    self.intervals.push(Dominant {
                        start: self.end(frame, edges, first, false),
                        end: self.end(frame, edges, index, true),
                    });
                    start = None;
                }
                _ => {}
            }
        }
        self.blocks += 2;
    }

    /// The boundary before bit `index`, with its place on the grid.
    fn end(&self, frame: &EncodedFrame, edges: &[f64], index: usize, dominant_end: bool) -> End {
        // The BRS bit and the CRC delimiter are each partly nominal, partly data: what lies
        // between them has a start of its own.
        let grid = match frame.brs {
            Some(brs) if index > brs && index <= frame.crc_delimiter => Grid {
                block: self.blocks + 1,
                phase: Phase::Data,
                index: (index - brs) as u32,
                dominant_end,
            },
            Some(_) if index > frame.crc_delimiter => return End::free(edges[index]),
            _ => Grid {
                block: self.blocks,
                phase: Phase::Nominal,
                index: index as u32,
                dominant_end,
            },
        };
        End { at: edges[index], grid: Some(grid) }
    }

    /// The dominant bits of a node that sends the same arbitration bits a little later.
    fn contend(&mut self, frame: &EncodedFrame, edges: &[f64], contender: Contender, bit: f64) {
        let late = contender.delay * bit;
        for index in 0..contender.bits {
            if frame.bits.level(index) == Level::Dominant {
                self.drive(edges[index] + late, edges[index + 1] + late);
            }
        }
    }
}

/// The start of every bit, and the end of the last one.
fn boundaries(frame: &EncodedFrame, clock: &BitClock, start: f64) -> Vec<f64> {
    let brs_bit =
        clock.nominal * clock.nominal_sample_point + clock.data * (1.0 - clock.data_sample_point);
    let delimiter =
        clock.data * clock.data_sample_point + clock.nominal * (1.0 - clock.nominal_sample_point);
    let count = frame.bits.len();
    let mut edges = Vec::with_capacity(count + 1);
    // Products, not sums: the hundredth bit must not carry a hundred roundings.
    for index in 0..=count {
        let at = match frame.brs {
            Some(brs) if index > brs => {
                let data_start = brs as f64 * clock.nominal + brs_bit;
                if index <= frame.crc_delimiter {
                    data_start + (index - brs - 1) as f64 * clock.data
                } else {
                    data_start
                        + (frame.crc_delimiter - brs - 1) as f64 * clock.data
                        + delimiter
                        + (index - frame.crc_delimiter - 1) as f64 * clock.nominal
                }
            }
            _ => index as f64 * clock.nominal,
        };
        edges.push(start + at);
    }
    edges
}
