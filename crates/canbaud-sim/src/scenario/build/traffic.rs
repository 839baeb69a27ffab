//! Streams of requests.

use std::path::Path;

use canbaud::wire::{FrameKind, Id};

use super::{Outcome, Scenario, find};
use crate::event::NodeId;
use crate::scenario::model::{FormatName, TrafficKind, TrafficTable};
use crate::time::{Span, Time};
use crate::traffic::{Arrivals, FrameFormat, Payload, parse_candump};

/// A stream of requests of a scenario.
#[derive(Debug, Clone)]
pub(in crate::scenario) struct Stream {
    pub(in crate::scenario) node: NodeId,
    pub(in crate::scenario) arrivals: Arrivals,
    pub(in crate::scenario) format: FrameFormat,
    pub(in crate::scenario) payload: Payload,
    pub(in crate::scenario) span: (Time, Time),
}

pub(super) fn id(raw: u32, extended: bool) -> Outcome<Id> {
    let id = if extended { Id::extended(raw) } else { u16::try_from(raw).ok().and_then(Id::base) };
    let allowed = if extended { "0 to 0x1FFFFFFF" } else { "0 to 0x7FF" };
    id.ok_or_else(|| format!("id is {raw:#X}, allowed are {allowed}"))
}

pub(super) fn hex(text: &str) -> Outcome<Vec<u8>> {
    let digits = text.replace([' ', '_', '.'], "");
    let bad = || format!("\"{text}\" is no data: write pairs of hexadecimal digits");
    if !digits.is_ascii() || !digits.len().is_multiple_of(2) {
        return Err(bad());
    }
    (0..digits.len() / 2)
        .map(|at| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).map_err(|_| bad()))
        .collect()
}

fn payload(text: Option<&str>) -> Outcome<Payload> {
    Ok(match text {
        None | Some("random") => Payload::Random,
        Some("zeros") => Payload::Zeros,
        Some("ones") => Payload::Ones,
        Some("worst-stuffing") => Payload::WorstStuffing,
        Some("counter") => Payload::Counter,
        Some(other) => match other.strip_prefix("hex:") {
            Some(bytes) => Payload::Fixed(hex(bytes)?),
            None => {
                return Err(format!(
                    "payload is \"{other}\", allowed are random, zeros, ones, worst-stuffing, \
                     counter, hex:…"
                ));
            }
        },
    })
}

pub(super) fn stream(
    table: &TrafficTable,
    scenario: &Scenario,
    directory: &Path,
) -> Outcome<Stream> {
    let node = find(scenario, &table.node)?;
    if scenario.is_autonomous(node) {
        return Err("an autonomous node sends by itself: give it pdo, sync or heartbeat".into());
    }
    let period = || {
        let span = table.period.ok_or("this kind of traffic needs a period")?.0;
        if span == Span::ZERO {
            Err("period is 0, allowed is more than 0".to_owned())
        } else {
            Ok(span)
        }
    };
    let kind = match table.format {
        None | Some(FormatName::Data) => FrameKind::Data,
        Some(FormatName::Remote) => FrameKind::Remote,
        Some(FormatName::Fd) => FrameKind::Fd { brs: false, esi: false },
        Some(FormatName::FdBrs) => FrameKind::Fd { brs: true, esi: false },
    };
    let arrivals = match table.kind {
        TrafficKind::Periodic => {
            let jitter = table.jitter.map_or(Span::ZERO, |jitter| jitter.0);
            Arrivals::Periodic { period: period()?, jitter }
        }
        TrafficKind::Poisson => Arrivals::Poisson { mean: period()? },
        TrafficKind::Burst => Arrivals::Burst { size: table.size.unwrap_or(10), period: period()? },
        TrafficKind::Single => Arrivals::Single,
        TrafficKind::Saturate => Arrivals::Saturate,
        TrafficKind::Replay => {
            let file = table.file.as_ref().ok_or("replay needs a file")?;
            let text = std::fs::read_to_string(directory.join(file))
                .map_err(|error| format!("file {file}: {error}"))?;
            Arrivals::Replay(parse_candump(&text).map_err(|error| format!("file {file}: {error}"))?)
        }
    };
    let format = FrameFormat { id: id(table.id, table.extended)?, kind, dlc: table.dlc };
    let payload = payload(table.payload.as_deref())?;
    let mut probe = crate::rng::Rng::new(0);
    payload.frame(format, 0, &mut probe).map_err(|error| error.to_string())?;
    let start = Time::ZERO + table.start.map_or(Span::ZERO, |start| start.0);
    let stop = table.stop.map_or(Time::NEVER, |stop| Time::ZERO + stop.0);
    Ok(Stream { node, arrivals, format, payload, span: (start, stop) })
}
