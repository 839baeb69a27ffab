//! Value change dump, the format of waveform viewers; 1 is recessive.

use std::io::{self, Write};

use canbaud::wire::Level;

use super::recorder::Recorder;
use crate::time::{Span, Time};

/// The identifier of signal `number`: printable characters.
fn code(number: usize) -> String {
    let mut code = String::new();
    let mut rest = number;
    loop {
        code.push(char::from(b'!' + (rest % 94) as u8));
        rest /= 94;
        if rest == 0 {
            return code;
        }
    }
}

const fn bit(level: Level) -> u8 {
    match level {
        Level::Dominant => 0,
        Level::Recessive => 1,
    }
}

/// Writes the bus and the TXD of each node of `names`, rounded down to `step`, which is a power of
/// ten from 1 fs to 1 s.
///
/// # Errors
/// Whatever writing comes to.
pub fn write_vcd(
    out: &mut impl Write,
    recording: &Recorder,
    names: &[String],
    step: Span,
    end: Time,
) -> io::Result<()> {
    let per_step = step.femtoseconds().max(1);
    writeln!(out, "$version canbaud $end\n$timescale {step} $end\n$scope module can $end")?;
    writeln!(out, "$var wire 1 {} bus $end", code(0))?;
    for (number, name) in names.iter().enumerate() {
        let word: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        writeln!(out, "$var wire 1 {} txd_{word} $end", code(number + 1))?;
    }
    writeln!(out, "$upscope $end\n$enddefinitions $end\n#0\n$dumpvars")?;
    for number in 0..=names.len() {
        writeln!(out, "1{}", code(number))?;
    }
    writeln!(out, "$end")?;
    let bus = recording.bus.iter().map(|(at, level)| (*at, 0, *level));
    let txd = recording.txd.iter().map(|(at, node, level)| (*at, node.0 + 1, *level));
    let mut changes: Vec<_> = bus.chain(txd).collect();
    changes.sort_by_key(|(at, ..)| *at);
    let mut last = 0;
    for (at, signal, level) in changes {
        let stamp = at.femtoseconds() / per_step;
        if stamp != last {
            writeln!(out, "#{stamp}")?;
            last = stamp;
        }
        writeln!(out, "{}{}", bit(level), code(signal))?;
    }
    writeln!(out, "#{}", (end.femtoseconds() / per_step).max(last + 1))?;
    out.flush()
}
