//! `canbaud controllers`: what is known of each.

use std::fmt::Write as _;

use canbaud::timing::Limits;
use canbaud::timing::controllers::register::Encoding;
use canbaud::timing::controllers::{ALL, Controller, Phase};
use serde::Serialize;

use super::args::ControllersArgs;
use super::refusal::Refusal;
use super::{json, names, text};
use crate::exit::Exit;

/// `canbaud controllers`.
pub(crate) fn controllers(args: &ControllersArgs) -> Exit {
    match list(args) {
        Ok(text) => text::print(&text),
        Err(refusal) => refusal.tell(args.json),
    }
}

/// What the command prints.
pub(super) fn list(args: &ControllersArgs) -> Result<String, Refusal> {
    let chosen = match &args.name {
        Some(name) => vec![names::find(name)?],
        None => ALL.to_vec(),
    };
    if args.json {
        let controllers = chosen.iter().map(|controller| record(controller)).collect();
        return json::line(&ListRecord { kind: "controllers", controllers });
    }
    Ok(match (&args.name, &chosen[..]) {
        (Some(_), [controller]) => detail(controller),
        _ => chosen.iter().map(|controller| line(controller)).collect(),
    })
}

fn line(controller: &Controller) -> String {
    let kind = match (controller.data.is_some(), controller.xl.is_some()) {
        (_, true) => "XL",
        (true, false) => "FD",
        (false, false) => "",
    };
    let mark = if controller.unconfirmed.is_some() { "*" } else { " " };
    let registers: Vec<&str> = controller.registers.iter().map(|register| register.name).collect();
    format!(
        "{:<21}{mark} {kind:<2}  {}\n{:26}  {}\n",
        controller.name,
        controller.description,
        "",
        registers.join(", ")
    )
}

fn detail(controller: &Controller) -> String {
    let mut text = format!("{}: {}\n", controller.name, controller.description);
    let _ = writeln!(text, "also: {}", controller.aliases.join(", "));
    let _ = writeln!(text, "clock: {}", controller.clock);
    let _ = writeln!(text, "source: {}", controller.source);
    if let Some(unconfirmed) = controller.unconfirmed {
        let _ = writeln!(text, "unconfirmed: {unconfirmed}");
    }
    for phase in [Phase::Nominal, Phase::Data, Phase::Xl] {
        if let Some(limits) = controller.limits(phase) {
            let _ = writeln!(text, "{phase} phase: {}", limits_line(limits));
        }
    }
    for register in controller.registers {
        let place = register.offset.map(|o| format!(" @ 0x{o:X}")).unwrap_or_default();
        let _ = writeln!(text, "{}{place}, {} bits", register.name, register.bits);
        for field in register.fields {
            let top = field.lsb + field.width - 1;
            let bits =
                if field.width == 1 { top.to_string() } else { format!("{top}:{}", field.lsb) };
            let _ = writeln!(text, "  {bits:>5}  {:<16} {}", field.name, encoding(field.encoding));
        }
    }
    text
}

fn encoding(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Raw => "",
        Encoding::MinusOne => "minus one",
        Encoding::MinusTwo => "minus two",
        Encoding::HalfMinusOne => "half, minus one",
        Encoding::Signed => "two's complement",
    }
}

fn limits_line(limits: &Limits) -> String {
    let (quanta, prescalers) = (limits.quanta(), limits.prescalers.ends());
    let mut line = format!(
        "TSEG1 {} to {}, TSEG2 {} to {}, SJW to {}, {} to {} TQ, prescaler {} to {}",
        limits.tseg1.min,
        limits.tseg1.max,
        limits.tseg2.min,
        limits.tseg2.max,
        limits.sjw_max,
        quanta.min,
        quanta.max,
        prescalers.min,
        prescalers.max
    );
    if limits.clock_divider > 1 {
        let _ = write!(line, " after a division by {}", limits.clock_divider);
    }
    if let Some(excess) = limits.rules.tseg1_excess_min {
        let _ = write!(line, ", TSEG1 >= TSEG2 + {excess}");
    }
    if limits.rules.sjw_gap > 0 {
        let _ = write!(line, ", SJW <= PHASE_SEG2 - {}", limits.rules.sjw_gap);
    }
    line
}

#[derive(Debug, Serialize)]
struct ListRecord<'a> {
    kind: &'static str,
    controllers: Vec<ControllerRecord<'a>>,
}

#[derive(Debug, Serialize)]
struct ControllerRecord<'a> {
    name: &'a str,
    aliases: &'a [&'a str],
    description: &'a str,
    clock: &'a str,
    clock_divider: u16,
    phases: Vec<LimitsRecord>,
    registers: Vec<LayoutRecord<'a>>,
    source: &'a str,
    unconfirmed: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct LimitsRecord {
    phase: &'static str,
    tseg1: [u16; 2],
    tseg2: [u16; 2],
    sjw_max: u16,
    time_quanta: [u16; 2],
    prescaler: [u16; 2],
}

#[derive(Debug, Serialize)]
struct LayoutRecord<'a> {
    name: &'a str,
    offset: Option<u32>,
    bits: u8,
    fields: Vec<FieldLayoutRecord<'a>>,
}

#[derive(Debug, Serialize)]
struct FieldLayoutRecord<'a> {
    name: &'a str,
    lsb: u8,
    width: u8,
    encoding: &'static str,
}

fn record(controller: &'static Controller) -> ControllerRecord<'static> {
    let limits = |phase| {
        let limits = controller.limits(phase)?;
        let (quanta, prescalers) = (limits.quanta(), limits.prescalers.ends());
        Some(LimitsRecord {
            phase: json::name(phase),
            tseg1: [limits.tseg1.min, limits.tseg1.max],
            tseg2: [limits.tseg2.min, limits.tseg2.max],
            sjw_max: limits.sjw_max,
            time_quanta: [quanta.min, quanta.max],
            prescaler: [prescalers.min, prescalers.max],
        })
    };
    let layout = |register: &'static canbaud::timing::controllers::Register| LayoutRecord {
        name: register.name,
        offset: register.offset,
        bits: register.bits,
        fields: register
            .fields
            .iter()
            .map(|field| FieldLayoutRecord {
                name: field.name,
                lsb: field.lsb,
                width: field.width,
                encoding: match encoding(field.encoding) {
                    "" => "as it is",
                    words => words,
                },
            })
            .collect(),
    };
    ControllerRecord {
        name: controller.name,
        aliases: controller.aliases,
        description: controller.description,
        clock: controller.clock,
        clock_divider: controller.nominal.clock_divider,
        phases: [Phase::Nominal, Phase::Data, Phase::Xl].into_iter().filter_map(limits).collect(),
        registers: controller.registers.iter().map(layout).collect(),
        source: controller.source,
        unconfirmed: controller.unconfirmed,
    }
}
