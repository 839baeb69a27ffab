//! Ready lines for Linux, C and Rust.

use std::fmt::Write as _;

use canbaud::timing::BitTiming;
use canbaud::timing::controllers::Phase;

use super::plan::{Answer, PhaseAnswer};
use super::text::hex;

/// All of them, each under its heading.
pub(super) fn all(answer: &Answer) -> String {
    let mut text = format!("Linux\n  {}\n", ip_link(answer));
    let _ = write!(text, "C\n{}", indented(&c(answer)));
    let _ = write!(text, "Rust\n{}", indented(&rust(answer)));
    text
}

fn indented(lines: &str) -> String {
    lines.lines().map(|line| format!("  {line}\n")).collect()
}

/// The `ip link` line; bit rate and sample point, so that the driver of any controller takes it.
pub(super) fn ip_link(answer: &Answer) -> String {
    let mut line = String::from("ip link set can0 type can");
    for phase in &answer.phases {
        let prefix = match phase.phase {
            Phase::Nominal => "",
            Phase::Data => "d",
            // iproute2 has no settled words for CAN XL yet.
            Phase::Xl => continue,
        };
        let Some(best) = phase.solutions.first() else { continue };
        let point = best.timing.sample_point().permille();
        let bitrate = phase.request.bitrate.bits_per_second();
        let sjw = best.timing.sjw;
        let _ = write!(
            line,
            " {prefix}bitrate {bitrate} {prefix}sample-point 0.{point:03} {prefix}sjw {sjw}"
        );
        if phase.phase == Phase::Data {
            line.push_str(" fd on");
        }
    }
    line
}

/// The C initialiser of the HAL that the controller is used with.
pub(super) fn c(answer: &Answer) -> String {
    let nominal = &answer.configuration.nominal;
    match answer.controller.name {
        "bxcan" => format!(
            "CAN_InitTypeDef init = {{ .Prescaler = {}, .SyncJumpWidth = CAN_SJW_{}TQ,\n    \
             .TimeSeg1 = CAN_BS1_{}TQ, .TimeSeg2 = CAN_BS2_{}TQ }};\n",
            nominal.prescaler,
            nominal.sjw,
            nominal.tseg1(),
            nominal.tseg2()
        ),
        "m_can" => fdcan(nominal, answer.configuration.data.as_ref()),
        "esp32_twai" | "esp32_twai_rev2" | "esp32s3_twai" => format!(
            "twai_timing_config_t timing = {{ .brp = {}, .tseg_1 = {}, .tseg_2 = {}, .sjw = {},\n    \
             .triple_sampling = false }};\n",
            nominal.prescaler,
            nominal.tseg1(),
            nominal.tseg2(),
            nominal.sjw
        ),
        _ => zephyr(&answer.phases),
    }
}

fn fdcan(nominal: &BitTiming, data: Option<&BitTiming>) -> String {
    let fields = |prefix: &str, timing: &BitTiming| {
        format!(
            ".{prefix}Prescaler = {}, .{prefix}SyncJumpWidth = {},\n    .{prefix}TimeSeg1 = {}, \
             .{prefix}TimeSeg2 = {}",
            timing.prescaler,
            timing.sjw,
            timing.tseg1(),
            timing.tseg2()
        )
    };
    let mut text = format!("FDCAN_InitTypeDef init = {{ {}", fields("Nominal", nominal));
    if let Some(data) = data {
        let _ = write!(text, ",\n    {}", fields("Data", data));
    }
    text.push_str(" };\n");
    text
}

fn zephyr(phases: &[PhaseAnswer]) -> String {
    let mut text = String::new();
    for phase in phases {
        let Some(best) = phase.solutions.first() else { continue };
        let timing = &best.timing;
        let name = match phase.phase {
            Phase::Nominal => "timing",
            Phase::Data => "timing_data",
            Phase::Xl => "timing_xl",
        };
        let _ = writeln!(
            text,
            "struct can_timing {name} = {{ .sjw = {}, .prop_seg = {}, .phase_seg1 = {},\n    \
             .phase_seg2 = {}, .prescaler = {} }}; /* Zephyr */",
            timing.sjw, timing.prop_seg, timing.phase_seg1, timing.phase_seg2, timing.prescaler
        );
    }
    text
}

/// Constants: the timing, and the words of the registers.
pub(super) fn rust(answer: &Answer) -> String {
    let mut text = String::new();
    for phase in &answer.phases {
        let Some(best) = phase.solutions.first() else { continue };
        let name = match phase.phase {
            Phase::Nominal => "NOMINAL",
            Phase::Data => "DATA",
            Phase::Xl => "XL",
        };
        let BitTiming { prescaler, prop_seg, phase_seg1, phase_seg2, sjw } = best.timing;
        let _ = writeln!(
            text,
            "const {name}: BitTiming = BitTiming {{ prescaler: {prescaler}, prop_seg: {prop_seg}, \
             phase_seg1: {phase_seg1}, phase_seg2: {phase_seg2}, sjw: {sjw} }};"
        );
    }
    let packed = answer.controller.pack(&answer.configuration).into_iter().flatten();
    for (register, word) in packed.filter_map(|(register, word)| Some((register, word.ok()?))) {
        let name: String = register
            .name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' })
            .collect();
        let _ = writeln!(text, "const {name}: u{} = {};", register.bits, hex(register, word));
    }
    text
}
