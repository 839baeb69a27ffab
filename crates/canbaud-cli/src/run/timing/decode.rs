//! `canbaud timing --decode`: what a firmware is really running at.

use std::fmt::Write as _;

use canbaud::timing::controllers::{Configuration, Controller, Phase, Register};
use canbaud::timing::{BitTiming, Rate};
use serde::Serialize;

use super::args::TimingArgs;
use super::json::{self, RegisterRecord, SettingRecord};
use super::picture::picture;
use super::refusal::Refusal;
use super::{plan, text};

type Words = Vec<(&'static Register, u32)>;

/// Decodes the words.
pub(super) fn run(args: &TimingArgs, given: &str) -> Result<String, Refusal> {
    let controller = plan::controller(args)?;
    let words = words(&controller, given)?;
    let configuration = controller
        .unpack(words.iter().map(|(register, word)| (*register, *word)))
        .map_err(|error| refuse(&controller, &error.to_string()))?;
    let outside = controller.check(&configuration).err().map(|error| error.to_string());
    if args.json {
        as_json(args, &controller, &words, &configuration, outside)
    } else {
        Ok(describe(args, &controller, &words, &configuration, outside))
    }
}

fn refuse(controller: &Controller, line: &str) -> Refusal {
    let order: Vec<&str> = controller.registers.iter().map(|register| register.name).collect();
    let hint = match order[..] {
        [] => format!("no register of {} is known", controller.name),
        _ => format!("the registers of {} in order: {}", controller.name, order.join(", ")),
    };
    Refusal::usage(line, Some(hint))
}

/// The words as given: by name, or in the order of the controller's registers.
fn words(controller: &Controller, given: &str) -> Result<Words, Refusal> {
    let mut words = Words::new();
    let mut order = controller.registers.iter();
    for token in given.split([',', ' ']).filter(|token| !token.is_empty()) {
        let (register, word) = match token.split_once('=') {
            Some((name, word)) => {
                let named = |r: &&Register| r.name.eq_ignore_ascii_case(name);
                (controller.registers.iter().find(named), word)
            }
            None => (order.next(), token),
        };
        let Some(register) = register else {
            return Err(refuse(controller, &format!("{token:?} is for no register")));
        };
        let Some(value) = number(word) else {
            let line = format!("{word:?} is no register word (0x1C, 28, 0b11100)");
            return Err(refuse(controller, &line));
        };
        if words.iter().any(|(known, _)| known.name == register.name) {
            return Err(refuse(controller, &format!("{} is given twice", register.name)));
        }
        words.push((register, value));
    }
    Ok(words)
}

fn number(text: &str) -> Option<u32> {
    let text = text.trim().replace('_', "").to_ascii_lowercase();
    if let Some(digits) = text.strip_prefix("0x") {
        u32::from_str_radix(digits, 16).ok()
    } else if let Some(digits) = text.strip_prefix("0b") {
        u32::from_str_radix(digits, 2).ok()
    } else {
        text.parse().ok()
    }
}

/// The phases that the registers hold.
fn phases(configuration: &Configuration) -> Vec<(Phase, BitTiming)> {
    [Phase::Nominal, Phase::Data, Phase::Xl]
        .into_iter()
        .filter_map(|phase| Some((phase, configuration.phase(phase)?)))
        .collect()
}

fn rate(args: &TimingArgs, controller: &Controller, timing: &BitTiming) -> Option<Rate> {
    Rate::new(args.clock?, timing.clocks_per_bit(controller.nominal.clock_divider))
}

fn describe(
    args: &TimingArgs,
    controller: &Controller,
    words: &Words,
    configuration: &Configuration,
    outside: Option<String>,
) -> String {
    let mut text = format!("{}: {}\n", controller.name, controller.description);
    for (register, word) in words {
        let _ = writeln!(text, "  {}", text::register_line(register, *word));
    }
    for (phase, timing) in phases(configuration) {
        let clocks = timing.clocks_per_bit(controller.nominal.clock_divider);
        match rate(args, controller, &timing) {
            Some(rate) => {
                let _ = write!(text, "\n{phase} phase: {}", rate.words());
            }
            None => {
                let _ =
                    write!(text, "\n{phase} phase: clock / {clocks} (--clock gives the bit rate)");
            }
        }
        let _ = writeln!(
            text,
            ", sample point {}, {} TQ of prescaler {}, SJW {}",
            timing.sample_point(),
            timing.quanta(),
            timing.prescaler,
            timing.sjw
        );
        let [line, arrow] = picture(&timing);
        let _ = writeln!(text, "  {line}\n  {arrow}");
    }
    if let Some(offset) = configuration.data_tdc_offset {
        let _ = writeln!(text, "transmitter delay compensation: offset {offset} clock periods");
    }
    if let Some(outside) = outside {
        let _ = writeln!(text, "outside the limits of the controller: {outside}");
    }
    text
}

#[derive(Debug, Serialize)]
struct DecodedRecord<'a> {
    kind: &'static str,
    controller: &'a str,
    clock_hz: Option<u64>,
    clock_divider: u16,
    registers: Vec<RegisterRecord>,
    phases: Vec<DecodedPhase>,
    data_tdc_offset_clocks: Option<i16>,
    outside_limits: Option<String>,
}

#[derive(Debug, Serialize)]
struct DecodedPhase {
    phase: &'static str,
    setting: SettingRecord,
}

fn as_json(
    args: &TimingArgs,
    controller: &Controller,
    words: &Words,
    configuration: &Configuration,
    outside_limits: Option<String>,
) -> Result<String, Refusal> {
    let phase = |(phase, timing): (Phase, BitTiming)| {
        let setting = SettingRecord::of(&timing);
        let setting = match rate(args, controller, &timing) {
            Some(rate) => setting.with_bitrate(rate.millibits_per_second() as f64 / 1e3),
            None => setting,
        };
        DecodedPhase { phase: json::name(phase), setting }
    };
    json::line(&DecodedRecord {
        kind: "decoded",
        controller: controller.name,
        clock_hz: args.clock.map(canbaud::units::Hertz::hertz),
        clock_divider: controller.nominal.clock_divider,
        registers: words
            .iter()
            .map(|(register, word)| RegisterRecord::of(register, *word))
            .collect(),
        phases: phases(configuration).into_iter().map(phase).collect(),
        data_tdc_offset_clocks: configuration.data_tdc_offset,
        outside_limits,
    })
}
