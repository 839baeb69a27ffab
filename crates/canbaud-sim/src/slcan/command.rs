//! What a line means in each firmware.

use canbaud::wire::Frame;

use super::firmware::Firmware;
use super::{frame, rates};
use crate::node::{Mode, Retransmission};
use crate::timing::BitTiming;

/// Longest command: an extended CAN FD frame of 64 bytes.
pub(super) const LENGTH_MAX: usize = 1 + 8 + 1 + 128;

/// A command, understood.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Command {
    /// A bare CR, and settings of the real thing that mean nothing here.
    Nothing,
    Nominal(BitTiming),
    Data(BitTiming),
    Open(Mode),
    /// `O` where `M1` chooses the mode.
    OpenAsSet,
    Close,
    SilentMode(Switch),
    Retransmission(Retransmission),
    Send(Frame),
    PollOne,
    PollAll,
    AutoPoll(Switch),
    Status,
    /// State, last error and counters in words.
    DetailedStatus,
    /// Of a USBtin: forget overruns.
    ClearOverruns,
    /// Of a USBtin: tell changes of the flags unasked.
    TellChanges(Switch),
    /// A fixed answer, all of it.
    Say(&'static str),
    Report(Report),
    Code(u32),
    Mask(u32),
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Switch {
    Off,
    On,
}

/// When a command is allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum When {
    Always,
    Closed,
    Opened,
}

/// What is told of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Report {
    pub(super) stamps: Stamps,
    pub(super) received: Switch,
    pub(super) transmitted: Switch,
    pub(super) esi: Switch,
}

/// Time stamps after the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stamps {
    None,
    /// Of a minute.
    Milliseconds,
    /// Of an hour.
    Microseconds,
}

impl Report {
    /// Received frames with `stamps`.
    pub(super) const fn with(stamps: Stamps) -> Self {
        Self { stamps, received: Switch::On, transmitted: Switch::Off, esi: Switch::Off }
    }
}

fn switch(digits: &str) -> Option<Switch> {
    match digits {
        "0" => Some(Switch::Off),
        "1" => Some(Switch::On),
        _ => None,
    }
}

fn hex32(digits: &str) -> Option<u32> {
    let eight = digits.len() == 8 && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    eight.then(|| u32::from_str_radix(digits, 16).ok()).flatten()
}

/// What `line` means to `firmware` and when it is allowed; `None` if it means nothing.
pub(super) fn parse(line: &str, firmware: Firmware) -> Option<(Command, When)> {
    let Some(letter) = line.bytes().next() else {
        // A USBtin knows no empty command.
        return (firmware != Firmware::Usbtin).then_some((Command::Nothing, When::Always));
    };
    let rest = line.get(1..)?;
    match firmware {
        Firmware::Lawicel => lawicel(letter, rest, line),
        Firmware::Canable1 => canable1(letter, rest, line),
        Firmware::Canable2 => canable2(letter, rest, line),
        Firmware::Canable2Stock => canable2_stock(letter, rest, line),
        Firmware::Usbtin => usbtin(letter, rest, line),
    }
}

fn send(line: &str) -> Option<(Command, When)> {
    Some((Command::Send(frame::parse(line)?), When::Opened))
}

fn lawicel(letter: u8, rest: &str, line: &str) -> Option<(Command, When)> {
    const ME: Firmware = Firmware::Lawicel;
    Some(match letter {
        b'S' => (Command::Nominal(rates::nominal(rest, ME)?), When::Closed),
        b's' => (Command::Nominal(rates::registers(rest, ME)?), When::Closed),
        b'O' if rest.is_empty() => (Command::Open(Mode::Normal), When::Closed),
        b'L' if rest.is_empty() => (Command::Open(Mode::BusMonitoring), When::Closed),
        b'C' if rest.is_empty() => (Command::Close, When::Opened),
        b't' | b'T' | b'r' | b'R' => send(line)?,
        b'P' if rest.is_empty() => (Command::PollOne, When::Opened),
        b'A' if rest.is_empty() => (Command::PollAll, When::Opened),
        b'F' if rest.is_empty() => (Command::Status, When::Opened),
        b'V' if rest.is_empty() => (Command::Say("V1013\r"), When::Always),
        b'v' if rest.is_empty() => (Command::Say("vcanbaud\r"), When::Always),
        b'N' if rest.is_empty() => (Command::Say("NCB01\r"), When::Always),
        b'X' => (Command::AutoPoll(switch(rest)?), When::Closed),
        b'Z' => (Command::Report(Report::with(milliseconds(rest)?)), When::Closed),
        b'M' => (Command::Code(hex32(rest)?), When::Closed),
        b'm' => (Command::Mask(hex32(rest)?), When::Closed),
        b'W' | b'Q' | b'U' if rest.len() == 1 => (Command::Nothing, When::Always),
        _ => return None,
    })
}

fn milliseconds(digits: &str) -> Option<Stamps> {
    Some(match switch(digits)? {
        Switch::Off => Stamps::None,
        Switch::On => Stamps::Milliseconds,
    })
}

/// The settings that both firmwares of the maker have; anything but 1 is off.
fn stock(letter: u8, rest: &str) -> Option<(Command, When)> {
    let one = rest.starts_with('1');
    Some(match letter {
        b'O' => (Command::OpenAsSet, When::Closed),
        b'C' => (Command::Close, When::Opened),
        b'M' if one => (Command::SilentMode(Switch::On), When::Closed),
        b'M' => (Command::SilentMode(Switch::Off), When::Closed),
        b'A' if one => (Command::Retransmission(Retransmission::Automatic), When::Closed),
        b'A' => (Command::Retransmission(Retransmission::OneShot), When::Closed),
        _ => return None,
    })
}

fn canable1(letter: u8, rest: &str, line: &str) -> Option<(Command, When)> {
    const ME: Firmware = Firmware::Canable1;
    const VERSION: &str = "8ca5d39 https://github.com/normaldotcom/canable-fw.git\r";
    match letter {
        b'S' => Some((Command::Nominal(rates::nominal(rest.get(..1)?, ME)?), When::Closed)),
        // Either case is the same.
        b'm' => stock(b'M', rest),
        b'a' => stock(b'A', rest),
        b'V' | b'v' => Some((Command::Say(VERSION), When::Always)),
        b't' | b'T' | b'r' | b'R' => send(line),
        _ => stock(letter, rest),
    }
}

fn canable2_stock(letter: u8, rest: &str, line: &str) -> Option<(Command, When)> {
    const ME: Firmware = Firmware::Canable2Stock;
    const VERSION: &str = "b0ce665 https://github.com/normaldotcom/canable2-fw.git\r";
    match letter {
        b'S' => Some((Command::Nominal(rates::nominal(rest.get(..1)?, ME)?), When::Closed)),
        b'Y' => Some((Command::Data(rates::data(rest.get(..1)?, ME)?), When::Closed)),
        b'V' => Some((Command::Say(VERSION), When::Always)),
        // The register has overflows of its buffers, and no line end follows it.
        b'E' => Some((Command::Say("CANable Error Register: 0"), When::Always)),
        b't' | b'T' | b'r' | b'R' | b'd' | b'D' | b'b' | b'B' => send(line),
        _ => stock(letter, rest),
    }
}

fn canable2(letter: u8, rest: &str, line: &str) -> Option<(Command, When)> {
    const ME: Firmware = Firmware::Canable2;
    const DETAIL: &str = "v: hardware=\"CANable2.0\", software=\"0000000\", \
                          url=\"https://github.com/Nakakiyo092/canable2-fw\"\r";
    const CONTROLLER: &str =
        "i: protocol=\"ISO-CANFD\", clock_mhz=160, controller=\"STM32G431CB\"\r";
    Some(match letter {
        b'S' => (Command::Nominal(rates::nominal(rest, ME)?), When::Closed),
        b's' => (Command::Nominal(rates::registers(rest, ME)?), When::Closed),
        b'Y' => (Command::Data(rates::data(rest, ME)?), When::Closed),
        b'y' => (Command::Data(rates::data_registers(rest, ME)?), When::Closed),
        b'O' if rest.is_empty() => (Command::Open(Mode::Normal), When::Closed),
        b'L' if rest.is_empty() => (Command::Open(Mode::BusMonitoring), When::Closed),
        b'=' if rest.is_empty() => (Command::Open(Mode::Loopback), When::Closed),
        b'C' if rest.is_empty() => (Command::Close, When::Opened),
        b't' | b'T' | b'r' | b'R' | b'd' | b'D' | b'b' | b'B' => send(line)?,
        b'F' if rest.is_empty() => (Command::Status, When::Opened),
        b'f' if rest.is_empty() => (Command::DetailedStatus, When::Opened),
        b'V' if rest.is_empty() => (Command::Say("VL2K1\r"), When::Always),
        b'v' if rest.is_empty() => (Command::Say(DETAIL), When::Always),
        b'I' if rest.is_empty() => (Command::Say("I30A0\r"), When::Always),
        b'i' if rest.is_empty() => (Command::Say(CONTROLLER), When::Always),
        b'N' if rest.is_empty() => (Command::Say("N0000\r"), When::Always),
        b'Z' => (Command::Report(Report::with(stamps(rest)?)), When::Closed),
        b'z' => (Command::Report(report(rest)?), When::Closed),
        b'W' if rest == "2" => (Command::Nothing, When::Closed),
        b'M' => (Command::Code(hex32(rest)?), When::Closed),
        b'm' => (Command::Mask(hex32(rest)?), When::Closed),
        b'Q' if matches!(rest, "0" | "1" | "2") => (Command::Nothing, When::Opened),
        _ => return None,
    })
}

fn stamps(digit: &str) -> Option<Stamps> {
    match digit {
        "0" => Some(Stamps::None),
        "1" => Some(Stamps::Milliseconds),
        "2" => Some(Stamps::Microseconds),
        _ => None,
    }
}

/// `znxyy`: time stamps, a reserved digit, eight flags.
fn report(digits: &str) -> Option<Report> {
    let flags = digits.get(2..).filter(|flags| flags.len() == 2)?;
    let flags = u8::from_str_radix(flags, 16).ok()?;
    let flag = |bit: u8| if flags >> bit & 1 == 1 { Switch::On } else { Switch::Off };
    Some(Report {
        stamps: stamps(digits.get(..1)?)?,
        received: flag(0),
        transmitted: flag(1),
        esi: flag(4),
    })
}

fn usbtin(letter: u8, rest: &str, line: &str) -> Option<(Command, When)> {
    const ME: Firmware = Firmware::Usbtin;
    Some(match letter {
        b'S' => (Command::Nominal(rates::nominal(rest.get(..1)?, ME)?), When::Closed),
        b's' => (Command::Nominal(rates::registers(rest, ME)?), When::Closed),
        b'O' => (Command::Open(Mode::Normal), When::Closed),
        b'L' => (Command::Open(Mode::BusMonitoring), When::Closed),
        b'l' => (Command::Open(Mode::Loopback), When::Closed),
        b'C' => (Command::Close, When::Opened),
        b't' | b'T' | b'r' | b'R' => send(line)?,
        b'F' => (Command::Status, When::Always),
        b'f' => match rest {
            "0" => (Command::TellChanges(Switch::Off), When::Always),
            "1" => (Command::TellChanges(Switch::On), When::Always),
            "2" => (Command::ClearOverruns, When::Always),
            "3" => (Command::ClearOverruns, When::Closed),
            _ => return None,
        },
        b'V' => (Command::Say("V0100\r"), When::Always),
        b'v' => (Command::Say("v0108\r"), When::Always),
        b'N' => (Command::Say("NFFFF\r"), When::Always),
        b'Z' if rest == "0" => (Command::Report(Report::with(Stamps::None)), When::Always),
        b'Z' if rest.len() == 1 => {
            (Command::Report(Report::with(Stamps::Milliseconds)), When::Always)
        }
        b'M' => (Command::Code(hex32(rest)?), When::Closed),
        b'm' => (Command::Mask(hex32(rest)?), When::Closed),
        _ => return None,
    })
}
