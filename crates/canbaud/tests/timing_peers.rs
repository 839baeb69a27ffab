//! Answers of nine other calculators: canbaud is never worse, and equal to the known optimum.
//!
//! Reads `../shared/reference/bittiming_peers.csv` beside the project, if it is there.

use canbaud::timing::controllers::{self, Configuration};
use canbaud::timing::{
    BitTiming, Limits, Prescalers, Ratio, Request, SamplePointPolicy, Span, solve,
};
use canbaud::units::{Bitrate, Hertz, Permille};

const PATH: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/reference/bittiming_peers.csv");

/// One line of the file by column name.
struct Row<'a> {
    line: usize,
    cells: Vec<&'a str>,
    header: &'a [&'a str],
}

impl Row<'_> {
    fn get(&self, name: &str) -> &str {
        let column = self.header.iter().position(|h| *h == name).unwrap();
        self.cells[column]
    }

    fn number(&self, name: &str) -> Option<u32> {
        self.get(name).parse().ok()
    }
}

/// What we compare with: our limits for the peer's controller, and how many of our clock periods
/// one of its has.
fn limits_for(controller: &str, phase: &str) -> (&'static str, Limits, u64) {
    let (name, factor) = match controller {
        "rcar_can" => ("rcan", 1),
        "sja1000" | "sja1000-strict" | "zephyr-sja1000/twai" => ("sja1000", 2),
        "mcp251x" => ("mcp2515", 2),
        "flexcan" | "zephyr-flexcan-ctrl1" => ("flexcan_ctrl1", 1),
        "flexcan-fd" => ("flexcan_fdcbt", 1),
        "flexcan-ENCBT" => ("flexcan_enhanced", 1),
        "linux6.12:ctu_can_fd" => ("ctu_can_fd", 1),
        "xilinx_can_fd" => ("xcanfd1", 1),
        "c167_btr(brp even = 2*(BRP+1))" => ("c167", 1),
        "twai-esp32(brp2..128)" => ("esp32_twai", 1),
        "twai-s2/s3/c3(brp2..32768)" => ("esp32s3_twai", 1),
        "multican(no DIV8)" => ("multican", 1),
        "zephyr-bxcan(stm32)" => ("bxcan", 1),
        name if name.contains("mcan") || name.contains("fdcan") => ("m_can", 1),
        "iso11898-strict-fd" => ("m_can", 1),
        name => (controllers::find(name).unwrap_or_else(|| panic!("unmapped {name}")).name, 1),
    };
    let found = controllers::find(name).unwrap();
    let mut limits = if phase == "data" { found.data.unwrap() } else { found.nominal };
    // Where the peer's limits are tighter or wider than the chip's, its own count.
    match (controller, phase) {
        ("linux6.12:ctu_can_fd", "data") => limits.prescalers = Prescalers::range(1, 2),
        ("linux6.12:ctu_can_fd", _) => limits.prescalers = Prescalers::range(1, 8),
        // Zephyr takes the fields for what they hold, Linux asks for TSEG1 >= 4.
        ("zephyr-flexcan-ctrl1", _) => limits.tseg1.min = 2,
        ("stm32-fdcan-nominal", _) => limits.tseg2.min = 1,
        ("multican(no DIV8)", _) => limits.prescalers = Prescalers::range(1, 64),
        _ => {}
    }
    if name == "m_can" {
        limits.bit_quanta = Span::new(3, 385);
    }
    (found.name, limits, factor)
}

/// Rate error and sample point error, in the order in which they count.
fn errors(timing: &BitTiming, clock: u64, divider: u16, row: &Row<'_>) -> (Ratio, Ratio) {
    let bitrate = u64::from(row.number("bitrate").unwrap());
    let divisor = timing.clocks_per_bit(divider);
    let rate = Ratio::new(clock.abs_diff(bitrate * divisor), bitrate * divisor).unwrap();
    let asked = permille(row) * u64::from(timing.quanta());
    let actual = 1_000 * u64::from(1 + timing.tseg1());
    (rate, Ratio::new(actual.abs_diff(asked), u64::from(timing.quanta())).unwrap())
}

fn permille(row: &Row<'_>) -> u64 {
    (row.get("sample_point_requested").parse::<f64>().unwrap() * 10.0).round() as u64
}

fn setting(prescaler: u32, tseg1: u32, tseg2: u32) -> BitTiming {
    BitTiming {
        prescaler: prescaler as u16,
        prop_seg: 0,
        phase_seg1: tseg1 as u16,
        phase_seg2: tseg2 as u16,
        sjw: 1,
    }
}

/// The prescaler as our limits count it: the C167 rows count both divisions.
fn prescaler(name: &str, brp: u32) -> u32 {
    if name == "c167" { brp / 2 } else { brp }
}

fn allows(limits: &Limits, timing: &BitTiming) -> bool {
    limits.prescalers.contains(timing.prescaler)
        && limits.tseg1.contains(timing.tseg1())
        && limits.tseg2.contains(timing.tseg2())
        && limits.bit_quanta.contains(timing.quanta())
        && limits
            .rules
            .tseg1_excess_min
            .is_none_or(|excess| timing.tseg1() as i32 - timing.tseg2() as i32 >= i32::from(excess))
}

fn for_each_row(mut check: impl FnMut(&Row<'_>)) -> bool {
    let Ok(text) = std::fs::read_to_string(PATH) else {
        eprintln!("absent: {PATH}; the comparison with other calculators is skipped");
        return false;
    };
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    for (index, line) in lines.enumerate() {
        // The last column, `error`, may hold commas; nothing here needs it.
        let cells: Vec<&str> = line.splitn(header.len(), ',').collect();
        check(&Row { line: index + 2, cells, header: &header });
    }
    true
}

#[test]
fn never_worse_than_a_peer_and_equal_to_the_optimum() {
    let (mut peers, mut optima, mut outside) = (0, 0, 0);
    let present = for_each_row(|row| {
        let (name, limits, factor) = limits_for(row.get("controller"), row.get("phase"));
        let clock = u64::from(row.number("f_clock").unwrap()) * factor;
        let request = Request::new(
            Hertz::new(clock).unwrap(),
            Bitrate::new(row.number("bitrate").unwrap()).unwrap(),
        )
        .with_sample_point(Permille::new(permille(row) as u16).unwrap(), SamplePointPolicy::Nearest)
        .with_tolerance_ppm(u32::MAX);
        let at = |timing: &BitTiming| errors(timing, clock, limits.clock_divider, row);
        let ours = solve(&request, &limits);
        let ours = ours.as_ref().map(|solution| at(&solution.timing));
        if let (Some(brp), Some(ps1), Some(ps2)) =
            (row.number("brp"), row.number("ps1"), row.number("ps2"))
        {
            let tseg1 = row.number("prop").unwrap_or(0) + ps1;
            let theirs = setting(prescaler(name, brp), tseg1, ps2);
            if allows(&limits, &theirs) {
                peers += 1;
                let ours = ours.as_ref().unwrap_or_else(|e| panic!("line {}: {e}", row.line));
                assert!(*ours <= at(&theirs), "line {}: {ours:?}", row.line);
            } else {
                assert_eq!(row.get("verdict"), "out_of_range", "line {}", row.line);
                outside += 1;
            }
        }
        let optimum: Vec<&str> = row.get("optimum").split('/').collect();
        if let [brp, tseg1, tseg2, ..] = optimum[..] {
            let [brp, tseg1, tseg2] = [brp, tseg1, tseg2].map(|text| text.parse().unwrap());
            let best = setting(prescaler(name, brp), tseg1, tseg2);
            assert!(allows(&limits, &best), "line {}: {name} {best:?}", row.line);
            optima += 1;
            match &ours {
                Ok(ours) => assert_eq!(*ours, at(&best), "line {}", row.line),
                // Out of reach by more than a factor of two: the nearest rate is the same.
                Err(error) => assert_eq!(
                    error.nearest().unwrap().divisor(),
                    best.clocks_per_bit(limits.clock_divider),
                    "line {}",
                    row.line
                ),
            }
        }
    });
    if present {
        println!("{peers} answers of peers, {optima} optima, {outside} answers out of range");
        assert!(peers > 4_000 && optima > 1_500);
    }
}

/// What `can-calc-bit-timing` prints as register values is what we pack.
#[test]
fn registers_equal_those_that_can_utils_prints() {
    let mut compared = 0;
    let present = for_each_row(|row| {
        if !row.get("peer").starts_with("can-utils") || row.get("register").is_empty() {
            return;
        }
        let (name, ..) = limits_for(row.get("controller"), row.get("phase"));
        let printed: Vec<u32> = row
            .get("register")
            .split_whitespace()
            .map(|word| u32::from_str_radix(word.trim_start_matches("0x"), 16).unwrap())
            .collect();
        let field = |name| row.number(name).unwrap() as u16;
        let timing = BitTiming {
            prescaler: prescaler(name, row.number("brp").unwrap()) as u16,
            prop_seg: field("prop"),
            phase_seg1: field("ps1"),
            phase_seg2: field("ps2"),
            sjw: field("sjw"),
        };
        if name == "c167" || row.get("phase") == "data" {
            // Rows computed with it, but printed by no peer.
            return;
        }
        let configuration = Configuration::classic(timing);
        let registers = controllers::find(name).unwrap().registers;
        let packed: Vec<u32> = registers
            .iter()
            .filter(|register| register.is_used_by(&configuration))
            .map(|register| register.pack(&configuration).unwrap())
            .collect();
        // can-utils leaves out BTLMODE of the MCP2515, and prints BRP bits in a 32 bit word.
        let same = match (name, &printed[..], &packed[..]) {
            ("mcp2515", [c1, c2, c3], [p1, p2, p3]) => [*c1, c2 | 0x80, *c3] == [*p1, *p2, *p3],
            (_, printed, packed) => printed == packed,
        };
        assert!(same, "line {}: {name} printed {printed:x?}, packed {packed:x?}", row.line);
        compared += 1;
    });
    if present {
        println!("{compared} register values compared");
        assert!(compared > 1_000);
    }
}
