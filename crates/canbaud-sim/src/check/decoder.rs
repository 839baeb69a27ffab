//! Reads every successful frame back from the star point, with a decoder of its own.
//!
//! It is as plain as can be: a list of bits, long division for the CRC. It knows the sender's bit
//! rates, samples at the sample point and begins anew at every edge to dominant.

use std::collections::VecDeque;

use canbaud::wire::{FdCrc, Frame, FrameKind, Level};

use super::Findings;
use crate::event::{Event, NodeId};
use crate::node::NodeConfig;
use crate::time::Time;

/// Edges kept: more than two of the longest frames have.
const KEPT: usize = 2048;

/// The sender's timing in femtoseconds.
#[derive(Debug, Clone, Copy)]
struct Timing {
    nominal: f64,
    data: f64,
    nominal_sample: f64,
    data_sample: f64,
    fd_crc: FdCrc,
    /// In loopback nothing reaches the star point.
    on_bus: bool,
}

impl Timing {
    fn new(config: &NodeConfig) -> Self {
        let period =
            1e15 / (config.oscillator.hertz as f64 * (1.0 + config.oscillator.ppb as f64 * 1e-9));
        let data = config.data.unwrap_or(config.nominal);
        let quantum = |timing: &crate::BitTiming| f64::from(timing.prescaler()) * period;
        let nominal = &config.nominal;
        Self {
            nominal: f64::from(nominal.quanta()) * quantum(nominal),
            data: f64::from(data.quanta()) * quantum(&data),
            nominal_sample: f64::from(nominal.sample_quanta()) * quantum(nominal),
            data_sample: f64::from(data.sample_quanta()) * quantum(&data),
            fd_crc: config.fd_crc,
            on_bus: config.mode != crate::node::Mode::Loopback,
        }
    }
}

/// The decoder and the latest edges.
#[derive(Debug)]
pub(super) struct Decoder {
    timings: Vec<Timing>,
    started: Vec<Option<Time>>,
    edges: VecDeque<(Time, Level)>,
    /// When something from outside last changed the line.
    disturbed: Option<Time>,
    decoded: u64,
}

/// Takes bits off the wire.
struct Cursor<'a> {
    edges: Vec<(f64, u8)>,
    /// Edges before this one lie too far back to matter.
    past: usize,
    timing: &'a Timing,
    /// Start of the next bit.
    at: f64,
    fast: bool,
    /// Bits as they are on the wire; 1 is recessive.
    raw: Vec<u8>,
}

impl Cursor<'_> {
    fn level(&self, time: f64) -> u8 {
        let before = self.edges[self.past..].iter().take_while(|(at, _)| *at <= time);
        before.last().map_or(1, |(_, level)| *level)
    }

    /// The next bit; its start is taken from an edge to dominant that lies near.
    fn bit(&mut self) -> u8 {
        let length = if self.fast { self.timing.data } else { self.timing.nominal };
        // The last edge before the bit says what its level is.
        let before = self.at - 0.5 * length;
        while self.edges.get(self.past + 1).is_some_and(|(at, _)| *at < before) {
            self.past += 1;
        }
        let mut around =
            self.edges[self.past..].iter().take_while(|(at, _)| *at < self.at + length);
        let near = |(at, level): &&(f64, u8)| *level == 0 && (at - self.at).abs() < length * 0.45;
        if let Some((at, _)) = around.find(near) {
            self.at = *at;
        }
        let sample = if self.fast { self.timing.data_sample } else { self.timing.nominal_sample };
        let bit = self.level(self.at + sample);
        self.at += length;
        self.raw.push(bit);
        bit
    }

    /// The bit just read was BRS or the CRC delimiter: the rest of it has the other rate.
    fn change_rate(&mut self, fast: bool) {
        let timing = self.timing;
        let (from, to) = if fast {
            (timing.nominal - timing.nominal_sample, timing.data - timing.data_sample)
        } else {
            (timing.data - timing.data_sample, timing.nominal - timing.nominal_sample)
        };
        self.at += to - from;
        self.fast = fast;
    }

    /// Five equal bits at the end of what was read?
    fn stuffed(&self, since: usize) -> bool {
        let tail = &self.raw[since..];
        matches!(tail, [.., a, b, c, d, e] if a == b && b == c && c == d && d == e)
    }
}

/// Remainder of `bits` by a polynomial (all of its coefficients, highest first) by long division.
fn divide(bits: &[u8], polynomial: &[u8], ones_first: bool) -> Vec<u8> {
    let width = polynomial.len() - 1;
    let mut work: Vec<u8> = bits.to_vec();
    work.extend(std::iter::repeat_n(0, width));
    if ones_first {
        // A register that starts at 1000… is the same as the first bit turned over.
        work[0] ^= 1;
    }
    for at in 0..bits.len() {
        if work[at] == 1 {
            for (offset, coefficient) in polynomial.iter().enumerate() {
                work[at + offset] ^= coefficient;
            }
        }
    }
    work[bits.len()..].to_vec()
}

/// Coefficients of a polynomial given by its exponents.
fn polynomial(exponents: &[usize]) -> Vec<u8> {
    let degree = exponents[0];
    (0..=degree).map(|at| u8::from(exponents.contains(&(degree - at)))).collect()
}

fn number(bits: &[u8]) -> u32 {
    bits.iter().fold(0, |value, bit| value * 2 + u32::from(*bit))
}

/// Dynamic stuffing: what was read, and where runs begin to count.
struct Destuffed {
    bits: Vec<u8>,
    stuff_bits: u32,
    /// The run of equal bits begins here in the raw bits.
    run_from: usize,
}

impl Destuffed {
    fn take(&mut self, cursor: &mut Cursor<'_>, count: usize) -> Result<Vec<u8>, String> {
        let from = self.bits.len();
        for _ in 0..count {
            self.settle(cursor)?;
            let bit = cursor.bit();
            self.bits.push(bit);
        }
        Ok(self.bits[from..].to_vec())
    }

    fn settle(&mut self, cursor: &mut Cursor<'_>) -> Result<(), String> {
        if cursor.stuffed(self.run_from) {
            let before = cursor.raw[cursor.raw.len() - 1];
            self.run_from = cursor.raw.len();
            if cursor.bit() == before {
                return Err(format!("six equal bits at bit {}", cursor.raw.len()));
            }
            self.stuff_bits += 1;
        }
        Ok(())
    }
}

/// What a header says.
struct Header {
    id: u32,
    extended: bool,
    remote: bool,
    fd: Option<(bool, bool)>,
    dlc: u32,
}

fn header(cursor: &mut Cursor<'_>, stuffed: &mut Destuffed) -> Result<Header, String> {
    stuffed.take(cursor, 1)?;
    let mut id = number(&stuffed.take(cursor, 11)?);
    let mut remote = stuffed.take(cursor, 1)?[0] == 1;
    let extended = stuffed.take(cursor, 1)?[0] == 1;
    if extended {
        id = id << 18 | number(&stuffed.take(cursor, 18)?);
        remote = stuffed.take(cursor, 1)?[0] == 1;
    }
    let is_fd = stuffed.take(cursor, 1)?[0] == 1;
    let mut fd = None;
    if is_fd {
        if stuffed.take(cursor, 1)?[0] == 1 {
            return Err("res is recessive".into());
        }
        let brs = stuffed.take(cursor, 1)?[0] == 1;
        if brs {
            cursor.change_rate(true);
        }
        let esi = stuffed.take(cursor, 1)?[0] == 1;
        fd = Some((brs, esi));
    } else if extended {
        stuffed.take(cursor, 1)?;
    }
    let dlc = number(&stuffed.take(cursor, 4)?);
    Ok(Header { id, extended, remote, fd, dlc })
}

fn length(header: &Header) -> usize {
    const FD: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
    match (header.fd, header.remote) {
        (Some(_), _) => FD[header.dlc as usize],
        (None, true) => 0,
        (None, false) => header.dlc.min(8) as usize,
    }
}

fn check_crc15(cursor: &mut Cursor<'_>, stuffed: &mut Destuffed) -> Result<(), String> {
    let want = divide(&stuffed.bits, &polynomial(&[15, 14, 10, 8, 7, 4, 3, 0]), false);
    let got = stuffed.take(cursor, 15)?;
    stuffed.settle(cursor)?;
    if want == got { Ok(()) } else { Err("CRC-15 does not match".into()) }
}

/// The CRC field of CAN FD: a fixed stuff bit before every four bits.
fn check_fd_crc(
    cursor: &mut Cursor<'_>,
    stuffed: &Destuffed,
    length: usize,
    fd_crc: FdCrc,
) -> Result<(), String> {
    let (width, exponents): (usize, &[usize]) = if length <= 16 {
        (17, &[17, 16, 14, 13, 11, 6, 4, 3, 1, 0])
    } else {
        (21, &[21, 20, 13, 11, 7, 4, 3, 0])
    };
    let iso = fd_crc == FdCrc::Iso;
    let mut covered = cursor.raw.clone();
    let mut field = Vec::new();
    let bits = if iso { 4 + width } else { width };
    for index in 0..bits {
        if index % 4 == 0 {
            let before = cursor.raw[cursor.raw.len() - 1];
            if cursor.bit() == before {
                return Err("a fixed stuff bit is no stuff bit".into());
            }
        }
        field.push(cursor.bit());
    }
    if iso {
        const GRAY: [[u8; 4]; 8] = [
            [0, 0, 0, 0],
            [0, 0, 1, 1],
            [0, 1, 1, 0],
            [0, 1, 0, 1],
            [1, 1, 0, 0],
            [1, 1, 1, 1],
            [1, 0, 1, 0],
            [1, 0, 0, 1],
        ];
        if field[..4] != GRAY[(stuffed.stuff_bits % 8) as usize] {
            return Err("the stuff count does not match".into());
        }
        covered.extend(&field[..4]);
        field.drain(..4);
    }
    if divide(&covered, &polynomial(exponents), iso) == field {
        Ok(())
    } else {
        Err(format!("CRC-{width} does not match"))
    }
}

fn compare(header: &Header, data: &[u8], frame: &Frame) -> Result<(), String> {
    let kind = match (header.fd, header.remote) {
        (Some((brs, esi)), _) => FrameKind::Fd { brs, esi },
        (None, true) => FrameKind::Remote,
        (None, false) => FrameKind::Data,
    };
    let good = header.id == frame.id().raw()
        && header.extended == frame.id().is_extended()
        && header.dlc == u32::from(frame.dlc())
        && kind == frame.kind()
        && data == frame.data();
    if good { Ok(()) } else { Err(format!("id {:X} dlc {} {data:02X?}", header.id, header.dlc)) }
}

fn decode(cursor: &mut Cursor<'_>, frame: &Frame) -> Result<(), String> {
    let mut stuffed = Destuffed { bits: Vec::new(), stuff_bits: 0, run_from: 0 };
    let header = header(cursor, &mut stuffed)?;
    let length = length(&header);
    let mut data = Vec::new();
    for _ in 0..length {
        data.push(number(&stuffed.take(cursor, 8)?) as u8);
    }
    if header.fd.is_some() {
        check_fd_crc(cursor, &stuffed, length, cursor.timing.fd_crc)?;
    } else {
        check_crc15(cursor, &mut stuffed)?;
    }
    if cursor.bit() == 0 {
        return Err("the CRC delimiter is dominant".into());
    }
    if header.fd.is_some_and(|(brs, _)| brs) {
        cursor.change_rate(false);
    }
    // In CAN FD the acknowledgement may come one bit late.
    let acknowledged = cursor.bit() == 0 || (header.fd.is_some() && cursor.bit() == 0);
    if !acknowledged {
        return Err("nobody acknowledges".into());
    }
    compare(&header, &data, frame)
}

impl Decoder {
    pub(super) fn new(configs: &[NodeConfig]) -> Self {
        Self {
            timings: configs.iter().map(Timing::new).collect(),
            started: vec![None; configs.len()],
            edges: VecDeque::new(),
            disturbed: None,
            decoded: 0,
        }
    }

    pub(super) const fn decoded(&self) -> u64 {
        self.decoded
    }

    pub(super) fn reconfigured(&mut self, node: NodeId, config: &NodeConfig) {
        self.timings[node.0] = Timing::new(config);
        self.started[node.0] = None;
    }

    pub(super) fn bus(&mut self, at: Time, level: Level) {
        if self.edges.len() == KEPT {
            self.edges.pop_front();
        }
        self.edges.push_back((at, level));
    }

    /// Edges of a glitch are no edges of the sender: a frame that has some is not read back.
    pub(super) fn disturbed(&mut self, at: Time) {
        self.disturbed = Some(at);
    }

    pub(super) fn event(&mut self, at: Time, node: NodeId, event: &Event, findings: &mut Findings) {
        match event {
            Event::TransmissionStarted { .. } => self.started[node.0] = Some(at),
            Event::Transmitted { frame } => {
                let Some(started) = self.started[node.0].take() else { return };
                if let Err(reason) = self.check(started, node, frame) {
                    let what = format!("sent {frame:?}, on the bus: {reason}");
                    findings.add(at, Some(node), what);
                }
            }
            _ => {}
        }
    }

    fn check(&mut self, started: Time, node: NodeId, frame: &Frame) -> Result<(), String> {
        let timing = self.timings[node.0];
        if !timing.on_bus || self.disturbed.is_some_and(|at| at >= started) {
            return Ok(());
        }
        // SOF is this sender's or, when it joined, began up to one and a half bits before.
        let earliest = started.femtoseconds() as f64 - timing.nominal;
        let from = self.edges.partition_point(|(at, _)| (at.femtoseconds() as f64) < earliest);
        let edges: Vec<(f64, u8)> = self
            .edges
            .range(from..)
            .map(|(at, level)| (at.femtoseconds() as f64, u8::from(*level == Level::Recessive)))
            .skip_while(|(_, level)| *level == 1)
            .collect();
        let at = edges.first().ok_or("nothing")?.0;
        self.decoded += 1;
        let mut cursor =
            Cursor { edges, past: 0, timing: &timing, at, fast: false, raw: Vec::new() };
        decode(&mut cursor, frame)
    }
}
