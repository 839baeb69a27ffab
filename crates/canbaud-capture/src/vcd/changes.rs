//! The changes of a dump, one after the other.

use canbaud::wire::Logic;

use super::header::{self, Variable, Variables};
use super::tokens::Tokens;
use crate::error::{CaptureError, Halt};
use crate::input::Input;
use crate::number::Decimal;

/// Words between two words on the progress.
const PROGRESS: u64 = 64 * 1024;

/// What a pass over the file hears.
pub(super) trait Listener {
    /// A line has a level from this tick on; `None` for x and z.
    fn level(&mut self, channel: usize, at: u64, level: Option<Logic>) -> Result<(), Halt>;
    /// A voltage has this value from this tick on.
    fn volts(&mut self, channel: usize, at: u64, volts: f64) -> Result<(), Halt>;
    /// All changes of the tick have been heard.
    fn tick_done(&mut self, at: u64) -> Result<(), Halt>;
    fn progress(&mut self, done: u64);
}

/// All changes of a file.
pub(super) struct Changes<'a> {
    pub(super) input: &'a Input,
    pub(super) variables: &'a Variables,
}

impl Changes<'_> {
    /// Reads the whole file; returns the last tick.
    pub(super) fn pass(&self, listener: &mut impl Listener) -> Result<u64, Halt> {
        let mut tokens = Tokens::new(self.input);
        header::read(&mut tokens)?;
        let mut now = 0;
        let mut words = 0_u64;
        loop {
            words += 1;
            if words.is_multiple_of(PROGRESS) {
                listener.progress(tokens.done());
            }
            let Some(token) = tokens.next()? else {
                listener.tick_done(now)?;
                return Ok(now);
            };
            match token {
                [b'#', digits @ ..] => {
                    let Some(at) = stamp(digits) else {
                        let reason = "a time stamp that is no number of 64 bits";
                        return Err(CaptureError::damaged(tokens.place(), reason).into());
                    };
                    if at < now {
                        let reason = format!("time runs backwards: #{at} after #{now}");
                        return Err(CaptureError::damaged(tokens.place(), reason).into());
                    }
                    if at > now {
                        listener.tick_done(now)?;
                    }
                    now = at;
                }
                [value @ (b'0' | b'1' | b'x' | b'X' | b'z' | b'Z'), id @ ..] if !id.is_empty() => {
                    self.scalar(logic(*value), id, now, listener)?;
                }
                [b'b' | b'B', bits @ ..] => {
                    let bits: Vec<u8> = bits.iter().rev().take(64).copied().collect();
                    let id = tokens.next()?;
                    self.vector(&bits, id, now, listener)?;
                }
                [b'r' | b'R', value @ ..] => {
                    let Some(volts) = real(value) else {
                        let reason = "a real value that is no number";
                        return Err(CaptureError::damaged(tokens.place(), reason).into());
                    };
                    let id = tokens.next()?.unwrap_or_default();
                    for variable in self.variables.get(id) {
                        if let Variable::Real { channel } = *variable {
                            listener.volts(channel, now, volts)?;
                        }
                    }
                }
                b"$dumpvars" | b"$dumpall" | b"$dumpon" | b"$dumpoff" | b"$end" => {}
                [b'$', ..] => tokens.until_end(|_| {})?,
                [b's', ..] => {
                    tokens.next()?;
                }
                _ => {
                    let word =
                        String::from_utf8_lossy(token.get(..20).unwrap_or(token)).into_owned();
                    let reason = format!("{word:?} is no value change");
                    return Err(CaptureError::damaged(tokens.place(), reason).into());
                }
            }
        }
    }

    /// A scalar sets the last bit of a vector and clears the others.
    fn scalar(
        &self,
        level: Option<Logic>,
        id: &[u8],
        now: u64,
        listener: &mut impl Listener,
    ) -> Result<(), Halt> {
        for variable in self.variables.get(id) {
            if let Variable::Wires { first, width } = *variable {
                let last = first + width - 1;
                (first..last).try_for_each(|n| listener.level(n, now, Some(Logic::Low)))?;
                listener.level(last, now, level)?;
            }
        }
        Ok(())
    }

    /// `bits` start with the least significant one; missing ones repeat the last x or z, else 0.
    fn vector(
        &self,
        bits: &[u8],
        id: Option<&[u8]>,
        now: u64,
        listener: &mut impl Listener,
    ) -> Result<(), Halt> {
        let fill = match bits.last() {
            Some(b'0' | b'1') | None => b'0',
            Some(other) => *other,
        };
        for variable in self.variables.get(id.unwrap_or_default()) {
            if let Variable::Wires { first, width } = *variable {
                for n in 0..width {
                    let bit = bits.get(width - 1 - n).copied().unwrap_or(fill);
                    listener.level(first + n, now, logic(bit))?;
                }
            }
        }
        Ok(())
    }
}

/// The number after a `#`.
pub(super) fn stamp(digits: &[u8]) -> Option<u64> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0_u64, |n, byte| match byte {
        b'0'..=b'9' => n.checked_mul(10)?.checked_add(u64::from(byte - b'0')),
        _ => None,
    })
}

const fn logic(value: u8) -> Option<Logic> {
    match value {
        b'0' => Some(Logic::Low),
        b'1' => Some(Logic::High),
        _ => None,
    }
}

fn real(text: &[u8]) -> Option<f64> {
    match Decimal::parse(text) {
        Some(decimal) => Some(decimal.to_f64()),
        None => {
            let text = text.to_ascii_lowercase();
            [b"nan".as_slice(), b"-nan", b"inf", b"-inf", b"+inf"]
                .contains(&text.as_slice())
                .then_some(f64::NAN)
        }
    }
}
