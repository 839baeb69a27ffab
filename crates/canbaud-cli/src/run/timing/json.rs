//! The answer for programs: one JSON object, described by `schemas/timing.schema.json`.

use canbaud::timing::controllers::{Configuration, Controller, Register};
use canbaud::timing::{BitTiming, Ratio, Solution};
use serde::Serialize;

use super::plan::{Answer, PhaseAnswer};
use super::refusal::Refusal;
use super::{snippets, text};

/// One object on one line.
pub(super) fn line(record: &impl Serialize) -> Result<String, Refusal> {
    let line = serde_json::to_string(record)
        .map_err(|error| Refusal::usage(format!("cannot write JSON: {error}"), None))?;
    Ok(line + "\n")
}

/// Why there is no answer.
#[derive(Debug, Serialize)]
pub(super) struct ErrorRecord<'a> {
    pub(super) kind: &'static str,
    pub(super) message: &'a str,
    pub(super) hint: Option<&'a str>,
    pub(super) nearest_bitrate: Option<f64>,
}

#[derive(Debug, Serialize)]
struct SolutionRecord<'a> {
    kind: &'static str,
    controller: &'a str,
    unconfirmed: Option<&'a str>,
    clock_hz: u64,
    clock_divider: u16,
    phases: Vec<PhaseRecord>,
    data_tdc_offset_clocks: Option<i16>,
    pwm: Option<PwmRecord>,
    sample_point_window_permille: Option<[f64; 2]>,
    registers: Vec<RegisterRecord>,
    snippets: SnippetRecord,
}

#[derive(Debug, Serialize)]
struct PwmRecord {
    short_clocks: u16,
    long_clocks: u16,
    offset_clocks: u16,
}

#[derive(Debug, Serialize)]
struct SnippetRecord {
    linux: String,
    c: String,
    rust: String,
}

#[derive(Debug, Serialize)]
struct PhaseRecord {
    phase: &'static str,
    bitrate: u32,
    sample_point_permille: u16,
    solutions: Vec<SettingRecord>,
}

/// A setting.
#[derive(Debug, Serialize)]
pub(super) struct SettingRecord {
    prescaler: u16,
    time_quanta: u32,
    prop_seg: u16,
    phase_seg1: u16,
    phase_seg2: u16,
    sjw: u16,
    sample_point_permille: f64,
    bitrate_actual: Option<f64>,
    bitrate_error_ppm: Option<f64>,
    oscillator_tolerance_ppm: Option<u64>,
    longest_bus_m: Option<u32>,
}

impl SettingRecord {
    /// What the timing alone says.
    pub(super) fn of(timing: &BitTiming) -> Self {
        Self {
            prescaler: timing.prescaler,
            time_quanta: timing.quanta(),
            prop_seg: timing.prop_seg,
            phase_seg1: timing.phase_seg1,
            phase_seg2: timing.phase_seg2,
            sjw: timing.sjw,
            sample_point_permille: permille(timing.sample_point()),
            bitrate_actual: None,
            bitrate_error_ppm: None,
            oscillator_tolerance_ppm: None,
            longest_bus_m: None,
        }
    }

    /// With the bit rate that it gives.
    pub(super) fn with_bitrate(mut self, bits_per_second: f64) -> Self {
        self.bitrate_actual = Some(bits_per_second);
        self
    }
}

/// A register with its word.
#[derive(Debug, Serialize)]
pub(super) struct RegisterRecord {
    name: &'static str,
    offset: Option<u32>,
    bits: u8,
    word: u32,
    hex: String,
    fields: Vec<FieldRecord>,
}

#[derive(Debug, Serialize)]
struct FieldRecord {
    name: &'static str,
    stored: u32,
    value: Option<i32>,
}

impl RegisterRecord {
    /// The register with this word in it.
    pub(super) fn of(register: &Register, word: u32) -> Self {
        let field = |field: &canbaud::timing::controllers::register::Field| FieldRecord {
            name: field.name,
            stored: field.stored(word),
            value: field.value(word),
        };
        Self {
            name: register.name,
            offset: register.offset,
            bits: register.bits,
            word,
            hex: text::hex(register, word),
            fields: register.fields.iter().map(field).collect(),
        }
    }
}

fn permille(ratio: Ratio) -> f64 {
    ratio.scaled(1_000_000) as f64 / 1e3
}

/// The registers of a configuration; none where the layout is not known.
pub(super) fn registers(
    controller: &Controller,
    configuration: &Configuration,
) -> Vec<RegisterRecord> {
    let packed = controller.pack(configuration).into_iter().flatten();
    packed.filter_map(|(register, word)| Some(RegisterRecord::of(register, word.ok()?))).collect()
}

fn setting(answer: &Answer, phase: &PhaseAnswer, solution: &Solution) -> SettingRecord {
    SettingRecord {
        bitrate_actual: Some(solution.rate.millibits_per_second() as f64 / 1e3),
        bitrate_error_ppm: Some(solution.bitrate_error_ppb() as f64 / 1e3),
        oscillator_tolerance_ppm: Some(text::tolerance(answer, phase, solution).ppm_floor()),
        longest_bus_m: text::longest(answer, phase, solution),
        ..SettingRecord::of(&solution.timing)
    }
}

fn record(answer: &Answer) -> SolutionRecord<'_> {
    let phase = |phase: &PhaseAnswer| PhaseRecord {
        phase: name(phase.phase),
        bitrate: phase.request.bitrate.bits_per_second(),
        sample_point_permille: phase.request.sample_point.permille(),
        solutions: phase.solutions.iter().map(|s| setting(answer, phase, s)).collect(),
    };
    SolutionRecord {
        kind: "solution",
        controller: answer.controller.name,
        unconfirmed: answer.controller.unconfirmed,
        clock_hz: answer.clock.hertz(),
        clock_divider: answer.controller.nominal.clock_divider,
        phases: answer.phases.iter().map(phase).collect(),
        data_tdc_offset_clocks: answer.data_tdc.offset(),
        pwm: answer.configuration.pwm.map(|pwm| PwmRecord {
            short_clocks: pwm.short,
            long_clocks: pwm.long,
            offset_clocks: pwm.offset,
        }),
        sample_point_window_permille: answer
            .window
            .map(|window| [permille(window.earliest), permille(window.latest)]),
        registers: registers(&answer.controller, &answer.configuration),
        snippets: SnippetRecord {
            linux: snippets::ip_link(answer),
            c: snippets::c(answer),
            rust: snippets::rust(answer),
        },
    }
}

/// The name of a phase in JSON.
pub(super) const fn name(phase: canbaud::timing::controllers::Phase) -> &'static str {
    use canbaud::timing::controllers::Phase;
    match phase {
        Phase::Nominal => "nominal",
        Phase::Data => "data",
        Phase::Xl => "xl",
    }
}

/// The answer for one controller.
pub(super) fn answer(answer: &Answer) -> Result<String, Refusal> {
    line(&record(answer))
}

#[derive(Debug, Serialize)]
struct AllRecord<'a> {
    kind: &'static str,
    solutions: Vec<SolutionRecord<'a>>,
    impossible: Vec<ImpossibleRecord<'a>>,
}

#[derive(Debug, Serialize)]
struct ImpossibleRecord<'a> {
    controller: &'a str,
    message: &'a str,
    nearest_bitrate: Option<f64>,
}

/// The answers for all controllers.
pub(super) fn all(answers: &[Answer], refusals: &[(&str, Refusal)]) -> Result<String, Refusal> {
    let impossible = refusals.iter().map(|(controller, refusal)| ImpossibleRecord {
        controller,
        message: &refusal.line,
        nearest_bitrate: refusal.nearest,
    });
    line(&AllRecord {
        kind: "all",
        solutions: answers.iter().map(record).collect(),
        impossible: impossible.collect(),
    })
}
