//! What happened, as lines that a person reads.

use std::io::{self, Write};

use canbaud::wire::{Frame, FrameKind};

use crate::event::{Event, NodeId, Observer, Role};
use crate::node::{Mode, NodeConfig, Wire};
use crate::time::Time;

/// Writes a line for each event; the first error of the writer is kept. Of nodes whose software
/// tells what it does, that and their troubles are written, and not each frame.
#[derive(Debug)]
pub struct Timeline<W> {
    out: W,
    names: Vec<String>,
    width: usize,
    /// Nodes whose software tells what it does: whether they take part, else `None`.
    telling: Vec<Option<Part>>,
    /// By node: its last trouble, when it was told last, and how often since it was written.
    again: Vec<Option<(String, Time, u64)>>,
    error: Option<io::Error>,
}

fn show(frame: &Frame) -> String {
    let kind = match frame.kind() {
        FrameKind::Data => "",
        FrameKind::Remote => " remote",
        FrameKind::Fd { brs: false, .. } => " FD",
        FrameKind::Fd { brs: true, .. } => " FD BRS",
    };
    let bytes: Vec<_> = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    format!("{}{kind} [{}] {}", frame.id(), frame.dlc(), bytes.join(" "))
}

impl<W: Write> Timeline<W> {
    /// For nodes of these names.
    pub fn new(out: W, names: Vec<String>) -> Self {
        let width = names.iter().map(String::len).max().unwrap_or(0);
        let (telling, again) = (vec![None; names.len()], vec![None; names.len()]);
        Self { out, names, width, telling, again, error: None }
    }

    /// The writer, or the first error that it had.
    ///
    /// # Errors
    /// Whatever writing came to.
    pub fn finish(mut self) -> io::Result<W> {
        for node in 0..self.names.len() {
            self.settle(NodeId(node));
        }
        match self.error {
            Some(error) => Err(error),
            None => self.out.flush().map(|()| self.out),
        }
    }

    /// A trouble of a node whose software tells what it does: repetitions are counted.
    fn trouble(&mut self, at: Time, node: NodeId, what: String) {
        if let Some(Some((before, last, times))) = self.again.get_mut(node.0)
            && *before == what
        {
            (*last, *times) = (at, *times + 1);
            return;
        }
        self.line(at, node, &what);
        if let Some(again) = self.again.get_mut(node.0) {
            *again = Some((what, at, 0));
        }
    }

    /// Writes how often the last trouble of `node` was repeated.
    fn settle(&mut self, node: NodeId) {
        let again = self.again.get_mut(node.0).and_then(Option::take);
        if let Some((what, last, times @ 1..)) = again {
            self.line(last, node, &format!("{what}: {times} times more"));
        }
    }

    fn line(&mut self, at: Time, node: NodeId, what: &str) {
        self.settle(node);
        let name = self.names.get(node.0).map_or("?", String::as_str);
        let width = self.width;
        if self.error.is_none() {
            let line = format!("{at}  {name:width$}  {what}");
            self.error = writeln!(self.out, "{}", line.trim_end()).err();
        }
    }
}

/// What a node whose software tells what it does has to do with the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Listens,
    TakesPart,
}

/// Whether an event is for a reader who is told by the software what it does.
const fn is_trouble(part: Part, event: &Event) -> bool {
    // While it listens, errors are what it listens for.
    matches!(part, Part::TakesPart)
        && matches!(
            event,
            Event::Fault(_) | Event::Overload | Event::Abandoned { .. } | Event::Error { .. }
        )
}

impl<W: Write> Observer for Timeline<W> {
    fn told(&mut self, at: Time, node: NodeId, what: &str) {
        if let Some(telling @ None) = self.telling.get_mut(node.0) {
            *telling = Some(Part::Listens);
        }
        self.line(at, node, what);
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        if let Some(Some(part)) = self.telling.get(node.0)
            && !is_trouble(*part, event)
        {
            return;
        }
        let what = match event {
            Event::TransmissionStarted { frame, attempt: 1 } => {
                format!("sends     {}", show(frame))
            }
            Event::TransmissionStarted { frame, attempt } => {
                format!("sends     {} (attempt {attempt})", show(frame))
            }
            Event::ArbitrationLost { bit } => format!("lost arbitration at bit {bit}"),
            Event::Transmitted { frame } => format!("sent      {}", show(frame)),
            Event::Abandoned { frame } => format!("gave up   {}", show(frame)),
            Event::Received { frame } => format!("received  {}", show(frame)),
            Event::Error { kind, place, role, .. } => {
                let role = match role {
                    Role::Transmitter => "transmitter",
                    Role::Receiver => "receiver",
                };
                format!("{kind} as {role}, {place}")
            }
            Event::Fault(state) => format!("is {state}"),
            Event::Overload => "overload flag".into(),
            Event::ProtocolException => "protocol exception: waits for an idle bus".into(),
            Event::Integrated => "takes part".into(),
            // Every frame and every error counts; the state is what a reader looks for.
            Event::Counted { .. } | Event::RecoverySequence(_) => return,
        };
        match self.telling.get(node.0) {
            Some(Some(_)) => self.trouble(at, node, what),
            _ => self.line(at, node, &what),
        }
    }

    fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        if let Some(Some(part)) = self.telling.get_mut(node.0) {
            *part = if config.can_drive() { Part::TakesPart } else { Part::Listens };
            return;
        }
        let mode = match (config.wire, config.mode) {
            (Wire::Cut, _) => "is cut off",
            (Wire::Connected, Mode::Normal) => "is set up: normal",
            (Wire::Connected, Mode::BusMonitoring) => "is set up: bus monitoring",
            (Wire::Connected, Mode::Restricted) => "is set up: restricted",
            (Wire::Connected, Mode::Loopback) => "is set up: loopback",
            (Wire::Connected, Mode::Disabled) => "is switched off",
        };
        let periods = u64::from(config.nominal.prescaler() * config.nominal.quanta());
        let rate = config.oscillator.hertz / periods;
        let what = match config.mode {
            Mode::Disabled => mode.to_owned(),
            _ => format!("{mode}, {rate} bit/s"),
        };
        self.line(at, node, &what);
    }
}
