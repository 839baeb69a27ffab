//! Declarations: timescale, wires, and the sample rate that sigrok leaves in a comment.

use std::collections::HashMap;

use canbaud::units::{Hertz, Timebase};

use super::tokens::Tokens;
use crate::Format;
use crate::error::CaptureError;
use crate::number;

/// Channels that are read; a simulation may declare any number of wires.
const MAX_CHANNELS: usize = 1024;
/// Bytes of one `$comment` that are looked at.
const MAX_COMMENT: usize = 4096;
/// Bytes of names that are kept.
const MAX_NAME: usize = 256;

/// What an identifier stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Variable {
    /// Lines `first` to `first + width - 1`; the last one is the least significant bit.
    Wires { first: usize, width: usize },
    /// A voltage.
    Real { channel: usize },
}

/// What each identifier stands for.
#[derive(Debug, Default)]
pub(super) struct Variables {
    /// By the only byte of the identifier: nearly every dump of a bus needs no more.
    short: Vec<Vec<Variable>>,
    long: HashMap<Box<[u8]>, Vec<Variable>>,
}

impl Variables {
    fn add(&mut self, id: &[u8], variable: Variable) {
        if let [byte] = *id {
            self.short.resize(256, Vec::new());
            self.short.get_mut(usize::from(byte)).into_iter().for_each(|v| v.push(variable));
        } else {
            self.long.entry(id.into()).or_default().push(variable);
        }
    }

    pub(super) fn get(&self, id: &[u8]) -> &[Variable] {
        match *id {
            [byte] => self.short.get(usize::from(byte)),
            _ => self.long.get(id),
        }
        .map_or(&[], Vec::as_slice)
    }
}

/// The declarations of a file.
pub(super) struct Header {
    pub(super) timebase: Timebase,
    pub(super) samplerate: Option<Hertz>,
    /// Name and whether it is a voltage.
    pub(super) channels: Vec<(String, bool)>,
    pub(super) variables: Variables,
    /// Wires that were left out because there are too many.
    pub(super) left_out: u64,
}

/// Reads up to and including `$enddefinitions`.
pub(super) fn read(tokens: &mut Tokens) -> Result<Header, CaptureError> {
    let mut timebase = None;
    let mut header = Header {
        timebase: Timebase::from_frequency(Hertz::MAX),
        samplerate: None,
        channels: Vec::new(),
        variables: Variables::default(),
        left_out: 0,
    };
    loop {
        let Some(token) = tokens.next()? else {
            let reason = "the file ends before $enddefinitions";
            return Err(CaptureError::damaged(tokens.place(), reason));
        };
        match token {
            b"$timescale" => timebase = Some(timescale(tokens)?),
            b"$comment" => {
                let mut text = Vec::new();
                tokens.until_end(|word| {
                    if text.len() < MAX_COMMENT {
                        text.extend_from_slice(word);
                        text.push(b' ');
                    }
                })?;
                header.samplerate = header.samplerate.or_else(|| rate_in(&text));
            }
            b"$var" => variable(tokens, &mut header)?,
            b"$enddefinitions" => {
                tokens.until_end(|_| {})?;
                break;
            }
            word if word.starts_with(b"$") => tokens.until_end(|_| {})?,
            _ => {
                let reason = "a word outside of a $command in the declarations";
                return Err(CaptureError::damaged(tokens.place(), reason));
            }
        }
    }
    header.timebase = timebase.ok_or_else(|| {
        CaptureError::unsupported(Format::Vcd, "no $timescale: the time unit is unknown")
    })?;
    Ok(header)
}

/// `1 ns`, `100ps`: the ticks per second.
fn timescale(tokens: &mut Tokens) -> Result<Timebase, CaptureError> {
    let mut text = String::new();
    tokens.until_end(|word| {
        if text.len() < 32 {
            text.push_str(&String::from_utf8_lossy(word.get(..32).unwrap_or(word)));
        }
    })?;
    let place = tokens.place();
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    let (number, unit) = text.split_at(digits);
    let per_second: Option<u64> = match unit {
        "s" => Some(1),
        "ms" => Some(1_000),
        "us" => Some(1_000_000),
        "ns" => Some(1_000_000_000),
        "ps" => Some(1_000_000_000_000),
        "fs" => Some(1_000_000_000_000_000),
        _ => None,
    };
    let units = number.parse::<u64>().ok().filter(|n| matches!(n, 1 | 10 | 100));
    match (units, per_second) {
        (Some(units), Some(per_second)) => Timebase::new(
            (per_second / units).max(1),
            if per_second < units { units / per_second } else { 1 },
        ),
        _ => None,
    }
    .ok_or_else(|| {
        let reason = format!("the timescale {text:?} is not 1, 10 or 100 of s to fs");
        CaptureError::damaged(place, reason)
    })
}

/// `Acquisition with 1/16 channels at 100 MHz`
fn rate_in(comment: &[u8]) -> Option<Hertz> {
    let text = String::from_utf8_lossy(comment);
    let (before, rate) = text.rsplit_once(" at ")?;
    before.contains("cquisition").then(|| number::hertz(rate))?
}

/// `$var wire 1 ! CAN_L $end`, `$var reg 8 " data [7:0] $end`, `$var real 64 ) A0 $end`.
fn variable(tokens: &mut Tokens, header: &mut Header) -> Result<(), CaptureError> {
    let place = tokens.place();
    let mut words: Vec<Box<[u8]>> = Vec::new();
    tokens.until_end(|word| {
        if words.len() < 5 && word.len() <= MAX_NAME {
            words.push(word.into());
        }
    })?;
    let [kind, width, id, name, ..] = words.as_slice() else {
        return Err(CaptureError::damaged(
            place,
            "a $var without type, width, identifier and name",
        ));
    };
    let name = String::from_utf8_lossy(name).into_owned();
    let first = header.channels.len();
    let width = core::str::from_utf8(width).ok().and_then(|w| w.parse::<usize>().ok());
    let variable = match (&**kind, width) {
        (b"real" | b"realtime", _) => Variable::Real { channel: first },
        // A parameter, a string or an event carries no level.
        (b"parameter" | b"string" | b"event" | b"time" | b"integer", _) => return Ok(()),
        (_, Some(width @ 1..=64)) => Variable::Wires { first, width },
        (_, Some(width)) if width > 64 => return Ok(()),
        _ => return Err(CaptureError::damaged(place, "a $var whose width is no number above 0")),
    };
    let new = if let Variable::Wires { width, .. } = variable { width } else { 1 };
    if first + new > MAX_CHANNELS {
        header.left_out += new as u64;
        return Ok(());
    }
    match variable {
        Variable::Real { .. } => header.channels.push((name, true)),
        Variable::Wires { width: 1, .. } => header.channels.push((name, false)),
        Variable::Wires { width, .. } => {
            let bits = (0..width).rev().map(|bit| (format!("{name}[{bit}]"), false));
            header.channels.extend(bits);
        }
    }
    header.variables.add(id, variable);
    Ok(())
}
