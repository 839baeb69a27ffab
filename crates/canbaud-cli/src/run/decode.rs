//! `canbaud decode`.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::Path;

use canbaud_capture::{Capture, CaptureError, open};

use super::failure::{source_name, unreadable, unwritable};
use super::live::LiveSource;
use crate::args::{DecodeArgs, FrameFormat};
use crate::exit::Exit;
use crate::judge;
use crate::output::{Candump, Clock, FramesJson, ItemWriter, Pcapng, RawDlc, summary};
use crate::printable::printable;
use crate::report::ChannelReport;
use crate::tell::{self, tell};

/// Large enough that a system call costs nothing per frame.
const BUFFER: usize = 64 * 1024;

/// Decodes one source and prints every frame.
pub(crate) fn decode(args: &DecodeArgs) -> Exit {
    let source = source_name(&args.source);
    if let Some(reason) = refuse_output(args) {
        tell!("canbaud: {reason}");
        return Exit::Usage;
    }
    let mut capture = match open(&args.source, &args.reading.open_options()) {
        Ok(capture) => capture,
        Err(error) => {
            tell::error(&unreadable(&source, &error));
            if !matches!(LiveSource::parse(&args.source), Ok(None)) {
                tell!(
                    "  hint: decode reads recordings; canbaud detect finds the rate of a live bus"
                );
            }
            return Exit::Unreadable;
        }
    };
    let target = args.output.as_deref().map_or_else(|| "standard output".to_owned(), source_name);
    let mut writer = match writer(args, Clock { timebase: capture.timebase(), start_s: args.start })
    {
        Ok(writer) => writer,
        Err(error) => return unwritable(&target, &error),
    };
    match copy(&mut capture, args, writer.as_mut()) {
        Ok(report) => conclude(args, &source, &report),
        Err(Stopped::Unreadable(error)) => {
            tell::error(&unreadable(&source, &error));
            Exit::Unreadable
        }
        Err(Stopped::Unwritable(error)) => unwritable(&target, &error),
    }
}

/// Why decoding ended before the end of the capture.
enum Stopped {
    Unreadable(CaptureError),
    Unwritable(io::Error),
}

/// Decodes into `writer`; what was decoded before a damage is kept.
fn copy(
    capture: &mut Capture,
    args: &DecodeArgs,
    writer: &mut dyn ItemWriter,
) -> Result<ChannelReport, Stopped> {
    let mut failed = None;
    let judged = judge::decode(capture, &args.reading.judge_options(), &mut |item| match writer
        .write(item)
    {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            failed = Some(error);
            ControlFlow::Break(())
        }
    });
    if let Some(error) = failed.or_else(|| writer.finish().err()) {
        return Err(Stopped::Unwritable(error));
    }
    judged.map_err(Stopped::Unreadable)
}

/// Why the output cannot go where it should: it would destroy the capture, or the terminal.
fn refuse_output(args: &DecodeArgs) -> Option<String> {
    match &args.output {
        Some(output) if same_file(output, &args.source) => {
            Some(format!("{}: would overwrite the capture itself", source_name(output)))
        }
        None if form(args) == FrameFormat::Pcapng && io::stdout().is_terminal() => {
            Some("pcapng is not for a terminal: add -o FILE or a pipe".to_owned())
        }
        _ => None,
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

const fn form(args: &DecodeArgs) -> FrameFormat {
    if args.json { FrameFormat::Json } else { args.format }
}

fn writer(args: &DecodeArgs, clock: Clock) -> io::Result<Box<dyn ItemWriter>> {
    let out: Box<dyn Write> = match &args.output {
        Some(path) => Box::new(File::create(path)?),
        None => Box::new(io::stdout().lock()),
    };
    let out = BufWriter::with_capacity(BUFFER, out);
    let raw_dlc = if args.raw_dlc { RawDlc::Shown } else { RawDlc::Hidden };
    Ok(match form(args) {
        FrameFormat::Candump => Box::new(Candump::new(out, clock, raw_dlc)),
        FrameFormat::Json => Box::new(FramesJson::new(out, clock)),
        FrameFormat::Pcapng => Box::new(Pcapng::new(out, clock)?),
    })
}

/// Tells what the frames were decoded with, or why there are none.
fn conclude(args: &DecodeArgs, source: &str, report: &ChannelReport) -> Exit {
    if !args.quiet {
        let channel = printable(&report.channel);
        tell!("canbaud: {source}: channel {channel}: {}", summary(report));
    }
    report.outcome.into()
}
