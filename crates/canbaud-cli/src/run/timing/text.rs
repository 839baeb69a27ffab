//! The answer for people.

use std::fmt::Write as _;
use std::io::{self, Write as _};

use canbaud::timing::controllers::{Configuration, Controller, Phase, Register};
use canbaud::timing::physics::{classic_tolerance, fd_tolerance};
use canbaud::timing::physics_bus::longest_bus_m;
use canbaud::timing::tdc::Tdc;
use canbaud::timing::{Rate, Ratio, Solution};

use super::picture::picture;
use super::plan::{Answer, PhaseAnswer};
use super::refusal::Refusal;
use super::snippets;
use crate::exit::Exit;
use crate::run::failure::unwritable;

/// Writes to the standard output; a reader that went away is no error.
pub(super) fn print(text: &str) -> Exit {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Ok(()) => Exit::Found,
        Err(error) => unwritable("standard output", &error),
    }
}

/// The answer for one controller.
pub(super) fn answer(answer: &Answer) -> Result<String, Refusal> {
    let mut text = String::new();
    heading(&mut text, answer);
    for phase in &answer.phases {
        settings(&mut text, answer, phase);
    }
    notes(&mut text, answer);
    registers(&mut text, &answer.controller, &answer.configuration);
    let _ = write!(text, "\n{}", snippets::all(answer));
    Ok(text)
}

fn heading(text: &mut String, answer: &Answer) {
    let controller = &answer.controller;
    let _ = writeln!(text, "{}: {}", controller.name, controller.description);
    let _ = write!(text, "clock {}Hz: {}", answer.clock, controller.clock);
    let divider = controller.nominal.clock_divider;
    if divider > 1 {
        let _ = write!(text, "; divided by {divider} before the prescaler");
    }
    text.push('\n');
    if let Some(unconfirmed) = controller.unconfirmed {
        let _ = writeln!(text, "unconfirmed: {unconfirmed}");
    }
    if let Some(window) = &answer.window {
        let _ = writeln!(
            text,
            "bus of {} m: sample point from {} to {}",
            answer.bus.length_m, window.earliest, window.latest
        );
    }
}

fn settings(text: &mut String, answer: &Answer, phase: &PhaseAnswer) {
    let _ = writeln!(
        text,
        "\n{} phase, {} at {}",
        phase.phase,
        Rate::from(phase.request.bitrate).words(),
        phase.request.sample_point
    );
    let _ = writeln!(
        text,
        "  {:>9} {:>4} {:>5} {:>4} {:>4} {:>4}  {:>12}  {:>18}  {:>12}  {:>9}  {:>11}",
        "prescaler",
        "TQ",
        "PROP",
        "PS1",
        "PS2",
        "SJW",
        "sample point",
        "bit rate",
        "error",
        "tolerance",
        "longest bus"
    );
    for solution in &phase.solutions {
        let timing = &solution.timing;
        let _ = writeln!(
            text,
            "  {:>9} {:>4} {:>5} {:>4} {:>4} {:>4}  {:>12}  {:>18}  {:>12}  {:>9}  {:>11}",
            timing.prescaler,
            timing.quanta(),
            timing.prop_seg,
            timing.phase_seg1,
            timing.phase_seg2,
            timing.sjw,
            timing.sample_point().to_string(),
            solution.rate.words().to_string(),
            ppm(solution.bitrate_error_ppb()),
            tolerance(answer, phase, solution).to_string(),
            length(answer, phase, solution),
        );
    }
    if let Some(best) = phase.solutions.first() {
        let [line, arrow] = picture(&best.timing);
        let _ = writeln!(text, "\n  {line}\n  {arrow}");
    }
}

/// The oscillator tolerance of this setting; with a data phase, of both phases together.
pub(super) fn tolerance(answer: &Answer, phase: &PhaseAnswer, solution: &Solution) -> Ratio {
    match (phase.phase, answer.configuration.data) {
        (Phase::Nominal, Some(data)) => fd_tolerance(&solution.timing, &data).limit(),
        (Phase::Data, Some(data)) => fd_tolerance(&answer.configuration.nominal, &data).limit(),
        _ => classic_tolerance(&solution.timing).limit(),
    }
}

/// The longest bus, which only the nominal phase limits.
pub(super) fn longest(answer: &Answer, phase: &PhaseAnswer, solution: &Solution) -> Option<u32> {
    let divider = answer.controller.nominal.clock_divider;
    match phase.phase {
        Phase::Nominal => longest_bus_m(&solution.timing, answer.clock, divider, &answer.bus),
        Phase::Data | Phase::Xl => None,
    }
}

fn length(answer: &Answer, phase: &PhaseAnswer, solution: &Solution) -> String {
    match (phase.phase, longest(answer, phase, solution)) {
        (_, Some(metres)) => format!("{metres} m"),
        (Phase::Nominal, None) => "none".to_owned(),
        (Phase::Data | Phase::Xl, None) => "-".to_owned(),
    }
}

/// `0 ppm`, `-4.762 ppm`.
pub(super) fn ppm(ppb: i64) -> String {
    if ppb == 0 {
        return "0 ppm".to_owned();
    }
    let sign = if ppb < 0 { '-' } else { '+' };
    let (whole, fraction) = (ppb.unsigned_abs() / 1_000, ppb.unsigned_abs() % 1_000);
    match format!("{fraction:03}").trim_end_matches('0') {
        "" => format!("{sign}{whole} ppm"),
        fraction => format!("{sign}{whole}.{fraction} ppm"),
    }
}

fn notes(text: &mut String, answer: &Answer) {
    let _ = writeln!(
        text,
        "\ntolerance: each clock may be off by this much. longest bus: with {} ns in each node and \
         {} ps/m",
        answer.bus.node_delay_ns, answer.bus.cable_delay_ps_per_m
    );
    if let [nominal, others @ ..] = &answer.phases[..]
        && !others.is_empty()
    {
        let prescaler = |phase: &PhaseAnswer| phase.solutions.first().map(|s| s.timing.prescaler);
        let common = others.iter().all(|phase| prescaler(phase) == prescaler(nominal));
        let words = if common { "the same in all phases" } else { "not the same in all phases" };
        let _ = writeln!(text, "prescaler: {words}");
    }
    match answer.data_tdc {
        Tdc::None => {}
        Tdc::Offset(offset) => {
            let _ = writeln!(text, "transmitter delay compensation: offset {offset} clock periods");
        }
        Tdc::PrescalerTooLarge { prescaler } => {
            let _ = writeln!(
                text,
                "transmitter delay compensation: off, ISO 11898-1 allows it with prescaler 1 or 2 \
                 only, not {prescaler}"
            );
        }
        Tdc::OffsetTooLarge { offset, max } => {
            let _ = writeln!(
                text,
                "transmitter delay compensation: off, its offset of {offset} clock periods is above \
                 {max}"
            );
        }
    }
    if let Some(pwm) = answer.configuration.pwm {
        let _ = writeln!(
            text,
            "PWM of the XL data phase: short {}, long {}, offset {} clock periods",
            pwm.short, pwm.long, pwm.offset
        );
    }
}

/// The words to write with the fields in them.
fn registers(text: &mut String, controller: &Controller, configuration: &Configuration) {
    match controller.pack(configuration) {
        Err(error) => {
            let _ = writeln!(text, "registers: {error}");
        }
        Ok(packed) => {
            let _ = writeln!(text, "registers");
            for (register, word) in packed {
                match word {
                    Ok(word) => {
                        let _ = writeln!(text, "  {}", register_line(register, word));
                    }
                    Err(error) => {
                        let _ = writeln!(text, "  {}: {error}", register.name);
                    }
                }
            }
        }
    }
}

/// `NBTP @ 0x1C = 0x06000A03   ntseg2 4, ntseg1 11, nbrp 1, nsjw 4`.
pub(super) fn register_line(register: &Register, word: u32) -> String {
    let place = register.offset.map(|offset| format!(" @ {offset:#04X}")).unwrap_or_default();
    let fields: Vec<String> = register
        .fields
        .iter()
        .filter(|field| field.phase().is_some() || field.stored(word) != 0)
        .map(|field| match field.value(word) {
            Some(value) => format!("{} {value}", field.name),
            None => format!("{} bits {:#x}", field.name, field.stored(word)),
        })
        .collect();
    let name = format!("{}{}", register.name, place.replace("0X", "0x"));
    format!("{name:<24} = {}   {}", hex(register, word), fields.join(", "))
}

/// The word in as many digits as the register has.
pub(super) fn hex(register: &Register, word: u32) -> String {
    format!("0x{word:0width$X}", width = usize::from(register.bits) / 4)
}

/// One line for each controller.
pub(super) fn all(answers: &[Answer], refusals: &[(&str, Refusal)]) -> Result<String, Refusal> {
    let mut text = String::new();
    for answer in answers {
        let phases: Vec<String> = answer
            .phases
            .iter()
            .filter_map(|phase| {
                let best = phase.solutions.first()?;
                let timing = &best.timing;
                Some(format!(
                    "{} x (1 + {} + {}) SJW {} {} {}",
                    timing.prescaler,
                    timing.tseg1(),
                    timing.tseg2(),
                    timing.sjw,
                    timing.sample_point(),
                    ppm(best.bitrate_error_ppb())
                ))
            })
            .collect();
        let words: Vec<String> = answer
            .controller
            .pack(&answer.configuration)
            .into_iter()
            .flatten()
            .map(|(register, word)| match word {
                Ok(word) => format!("{}={}", register.name, hex(register, word)),
                Err(error) => error.to_string(),
            })
            .collect();
        let name = answer.controller.name;
        let _ = writeln!(text, "{name:<21} {}  {}", phases.join(" / "), words.join(" "));
    }
    for (name, refusal) in refusals {
        let _ = writeln!(text, "{name:<21} - {}", refusal.line);
    }
    Ok(text)
}
