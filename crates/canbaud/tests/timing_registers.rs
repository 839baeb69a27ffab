//! Registers: known words, round trips, range checks, and the layouts of the reference list.

use canbaud::timing::controllers::register::{Content, Encoding, Field, Part};
use canbaud::timing::controllers::{
    self, ALL, Configuration, Controller, Phase, Pwm, Register, RegisterError,
};
use canbaud::timing::{BitTiming, Limits};
use proptest::prelude::*;

fn timing(prescaler: u16, tseg1: u16, tseg2: u16, sjw: u16) -> BitTiming {
    let phase_seg1 = tseg2.min(tseg1 - 1).max(1);
    BitTiming { prescaler, prop_seg: tseg1 - phase_seg1, phase_seg1, phase_seg2: tseg2, sjw }
}

fn words(controller: &Controller, configuration: &Configuration) -> Vec<(&'static Register, u32)> {
    controller
        .registers
        .iter()
        .filter(|register| register.is_used_by(configuration))
        .map(|register| (register, register.pack(configuration).unwrap()))
        .collect()
}

/// Words from data sheets, application notes and generated code; each worked out by hand.
#[test]
fn known_words_pack_and_unpack() {
    #[rustfmt::skip]
    let known: &[(&str, BitTiming, &[u32])] = &[
        ("sja1000", timing(1, 13, 2, 1), &[0x00, 0x1C]),             // 500k at 16 MHz, EL6751
        ("sja1000", timing(50, 13, 2, 1), &[0x31, 0x1C]),            // 10k, EL6751
        ("sja1000", timing(1, 7, 2, 1), &[0x00, 0x16]),              // 800k, EL6751
        ("c167", timing(1, 15, 4, 1), &[0x3E00]),                    // AP2925
        ("c167", timing(1, 16, 3, 1), &[0x2F00]),
        ("c167", timing(1, 16, 3, 2), &[0x2F40]),                    // generated C1BTR
        ("twincan", timing(80, 5, 4, 2), &[0xB449]),                 // generated, DIV8X set
        ("c_can", timing(1, 8, 1, 1), &[0x0700, 0]),                 // TI SPRUIN7
        ("c_can", timing(2, 5, 4, 4), &[0x34C1, 0]),                 // TI SPRUIN7
        ("lpc_can", timing(30, 13, 2, 1), &[0x001C_001D]),           // 125k at 60 MHz
        ("m_can", timing(1, 11, 4, 4), &[0x0600_0A03]),              // reset value
        ("bxcan", timing(9, 6, 1, 1), &[0x0005_0008]),               // 500k at 36 MHz
        ("at90can", BitTiming { prescaler: 2, prop_seg: 7, phase_seg1: 4, phase_seg2: 4, sjw: 1 },
            &[0x02, 0x0C, 0x36]),                                    // 500k at 16 MHz, SMP 0
    ];
    for (name, timing, expected) in known {
        let controller = controllers::find(name).unwrap();
        let packed = words(controller, &Configuration::classic(*timing));
        let plain: Vec<u32> = packed.iter().map(|(_, word)| *word).collect();
        assert_eq!(plain, *expected, "{name} {timing:?}");
        let unpacked = controller.unpack(packed).unwrap().nominal;
        assert_eq!(
            (unpacked.prescaler, unpacked.tseg1(), unpacked.tseg2(), unpacked.sjw),
            (timing.prescaler, timing.tseg1(), timing.tseg2(), timing.sjw)
        );
    }
}

#[test]
fn data_phase_and_tdc_words_pack_and_unpack() {
    let nominal = timing(1, 11, 4, 4);
    let configuration = Configuration::classic(nominal).with_data(timing(1, 11, 4, 4), None);
    let packed = words(&controllers::m_can::CONTROLLER, &configuration);
    // DBTP reset value 0x0000_0A33 [SAM C21]
    assert_eq!(packed[1].1, 0x0000_0A33);
    // 5 Mbit/s at 40 MHz: can-utils prints the nominal layout for it, DBTP is 0x0000_0410.
    let fast = BitTiming { prescaler: 1, prop_seg: 3, phase_seg1: 2, phase_seg2: 2, sjw: 1 };
    let configuration = Configuration::classic(nominal).with_data(fast, Some(6));
    let packed = words(&controllers::m_can::CONTROLLER, &configuration);
    let plain: Vec<u32> = packed.iter().map(|(_, word)| *word).collect();
    assert_eq!(plain, [0x0600_0A03, 0x0080_0410, 0x0000_0600]);
    let unpacked = controllers::m_can::CONTROLLER.unpack(packed).unwrap();
    assert_eq!(unpacked.data_tdc_offset, Some(6));
}

#[test]
fn x_can_nominal_reset_value_unpacks() {
    let registers = controllers::x_can_prt::CONTROLLER.registers;
    let nbtp = registers.iter().find(|register| register.name == "NBTP").unwrap();
    let unpacked = controllers::x_can_prt::CONTROLLER.unpack([(nbtp, 0x00FE_3F3F)]).unwrap();
    let nominal = unpacked.nominal;
    assert_eq!(
        (nominal.prescaler, nominal.tseg1(), nominal.tseg2(), nominal.sjw),
        (1, 255, 64, 64)
    );
}

/// Every setting that the limits allow, as long as there are fewer than 10^6; a grid over the
/// ends and primes in between otherwise.
fn settings(limits: &Limits) -> Vec<BitTiming> {
    let prescalers: Vec<u16> = (1..=u16::MAX).filter(|p| limits.prescalers.contains(*p)).collect();
    let span = |min: u16, max: u16| (min..=max).collect::<Vec<u16>>();
    let prop_max = limits.prop_seg.max.min(limits.tseg1.max - 1);
    // Without a PROP_SEG field every split of TSEG1 packs alike: one of each is enough.
    let has_prop = limits.prop_seg.max < u16::MAX;
    let props = if has_prop { span(limits.prop_seg.min, prop_max) } else { vec![0] };
    let phase_max = limits.phase_seg1.max.min(limits.tseg1.max);
    let phases = span(limits.phase_seg1.min.max(1), phase_max);
    let seconds = span(limits.tseg2.min, limits.tseg2.max);
    let jumps = span(1, limits.sjw_max);
    let total = [&prescalers, &props, &phases, &seconds, &jumps]
        .iter()
        .map(|axis| axis.len())
        .product::<usize>();
    let thin = |axis: Vec<u16>| -> Vec<u16> {
        if total < 1_000_000 || axis.len() < 8 {
            return axis;
        }
        let picks = [0, 1, axis.len() / 3, axis.len() / 2 + 1, axis.len() - 2, axis.len() - 1];
        picks.map(|index| axis[index]).to_vec()
    };
    let (prescalers, props) = (thin(prescalers), thin(props));
    let (phases, seconds, jumps) = (thin(phases), thin(seconds), thin(jumps));
    let mut settings = Vec::new();
    for &prescaler in &prescalers {
        for &prop_seg in &props {
            for &phase_seg1 in &phases {
                for &phase_seg2 in &seconds {
                    for &sjw in &jumps {
                        let timing = BitTiming { prescaler, prop_seg, phase_seg1, phase_seg2, sjw };
                        if limits.check(&timing).is_ok() {
                            settings.push(timing);
                        }
                    }
                }
            }
        }
    }
    settings
}

fn assert_same(controller: &Controller, limits: &Limits, a: &BitTiming, b: &BitTiming) {
    let plain = |t: &BitTiming| (t.prescaler, t.tseg1(), t.tseg2(), t.sjw);
    assert_eq!(plain(a), plain(b), "{}", controller.name);
    let has_prop = limits.prop_seg.max < u16::MAX && limits.prop_seg.max > limits.prop_seg.min;
    if has_prop {
        assert_eq!(a, b, "{}", controller.name);
    }
}

/// Controllers whose registers hold the whole bit timing.
fn complete() -> impl Iterator<Item = &'static Controller> {
    ALL.iter().copied().filter(|c| c.name != "peak_pucan" && c.name != "m16c_can")
}

#[test]
fn every_nominal_setting_survives_its_registers() {
    for controller in complete() {
        for timing in settings(&controller.nominal) {
            let packed = words(controller, &Configuration::classic(timing));
            let unpacked = controller.unpack(packed).unwrap().nominal;
            assert_same(controller, &controller.nominal, &timing, &unpacked);
        }
    }
}

#[test]
fn every_data_setting_survives_its_registers() {
    for controller in complete() {
        let Some(data) = &controller.data else { continue };
        for timing in settings(data) {
            let nominal =
                BitTiming { prescaler: timing.prescaler, ..timing_in(&controller.nominal) };
            let configuration = Configuration::classic(nominal).with_data(timing, None);
            let unpacked = controller.unpack(words(controller, &configuration)).unwrap();
            assert_same(controller, data, &timing, &unpacked.data.unwrap());
        }
    }
}

fn timing_in(limits: &Limits) -> BitTiming {
    BitTiming {
        prescaler: limits.prescalers.ends().min,
        prop_seg: limits.prop_seg.min.max(2),
        phase_seg1: 2,
        phase_seg2: limits.tseg2.min,
        sjw: 1,
    }
}

/// A word of timing fields only, without a factor that a smaller one could replace.
fn is_canonical(register: &Register, word: u32) -> bool {
    register.fields.iter().all(|field| match field.content {
        Content::Timing(_, Part::PrescalerScale) => field.stored(word) == 0,
        Content::Constant(value) => field.stored(word) == value,
        Content::Timing(..) => true,
        _ => field.stored(word) == 0,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any word that unpacks packs to itself again.
    #[test]
    fn words_survive_unpacking(index in 0..ALL.len(), raw in any::<[u32; 3]>()) {
        let controller = ALL[index];
        let nominal: Vec<(&Register, u32)> = controller
            .registers
            .iter()
            .filter(|r| r.fields.iter().any(|f| f.phase() == Some(Phase::Nominal)))
            .zip(raw)
            .map(|(register, raw)| {
                let timing_bits = |f: &&Field| f.phase() == Some(Phase::Nominal);
                let keep: u32 = register.fields.iter().filter(timing_bits).map(Field::mask).sum();
                let constant: u32 = register.fields.iter().map(|f| match f.content {
                    Content::Constant(value) => value << f.lsb,
                    _ => 0,
                }).sum();
                (register, raw & keep | constant)
            })
            .collect();
        if let Ok(configuration) = controller.unpack(nominal.iter().copied()) {
            let configuration = Configuration::classic(configuration.nominal);
            if nominal.iter().all(|(register, word)| is_canonical(register, *word)) {
                for (register, word) in nominal {
                    prop_assert_eq!(register.pack(&configuration), Ok(word));
                }
            }
        }
    }

    /// No word of any width makes unpacking panic.
    #[test]
    fn any_word_is_answered(index in 0..ALL.len(), raw in any::<[u32; 6]>()) {
        let controller = ALL[index];
        let _ = controller.unpack(controller.registers.iter().zip(raw));
    }

    /// No configuration makes packing panic or mask: what packs unpacks to itself.
    #[test]
    fn any_configuration_is_answered(
        index in 0..ALL.len(),
        parts in any::<[u16; 5]>(),
        small in any::<[u8; 5]>(),
        offset in any::<i16>(),
    ) {
        let controller = ALL[index];
        let wide = |p: [u16; 5]| BitTiming {
            prescaler: p[0], prop_seg: p[1], phase_seg1: p[2], phase_seg2: p[3], sjw: p[4],
        };
        let narrow = wide(small.map(|p| u16::from(p % 40)));
        let configuration = Configuration {
            nominal: narrow,
            data: Some(wide(parts)),
            xl: Some(narrow),
            data_tdc_offset: Some(offset),
            xl_tdc_offset: None,
            pwm: Some(Pwm { short: parts[0], long: parts[1], offset: parts[2] }),
        };
        for configuration in [configuration, Configuration::classic(narrow)] {
            let _ = controller.pack(&configuration).map(Iterator::count);
            let packed: Result<Vec<_>, _> =
                controller.registers.iter().map(|r| r.pack(&configuration).map(|w| (r, w))).collect();
            if let (Ok(packed), Ok(())) = (packed, controller.check(&configuration))
                && !controller.registers.is_empty()
                && let Ok(unpacked) = controller.unpack(packed)
            {
                let plain = |t: &BitTiming| (t.prescaler, t.tseg1(), t.tseg2(), t.sjw);
                prop_assert_eq!(plain(&unpacked.nominal), plain(&narrow), "{}", controller.name);
            }
        }
    }
}

#[test]
fn a_value_that_does_not_fit_is_named_with_its_range() {
    // 42 MHz, 5 kbit/s: a prescaler of 525 in a field that some mask to 9 bits.
    let low = timing(525, 13, 2, 1);
    assert!(controllers::bxcan::BTR.pack(&Configuration::classic(low)).is_ok());
    let too_low = timing(1025, 13, 2, 1);
    assert_eq!(
        controllers::bxcan::BTR.pack(&Configuration::classic(too_low)),
        Err(RegisterError::Field { register: "BTR", field: "brp", value: 1025, min: 1, max: 1024 })
    );
    // TSEG1 17, which XMCLib masks to 1.
    let error = controllers::multican::NBTR.pack(&Configuration::classic(timing(10, 17, 2, 1)));
    assert_eq!(error.unwrap_err().to_string(), "NBTR.tseg1 cannot hold 17 (it holds 1 to 16)");
    // Odd prescalers, which esp-hal halves.
    let odd =
        controllers::esp32_twai::BUS_TIMING_0.pack(&Configuration::classic(timing(35, 13, 2, 1)));
    assert!(matches!(odd, Err(RegisterError::Field { field: "brp", value: 35, .. })));
    let error = controllers::at91::CONTROLLER.pack(&Configuration::classic(timing(1, 13, 2, 1)));
    assert_eq!(error.err().unwrap().to_string(), "prescaler 1 outside 2 to 128");
}

#[test]
fn reserved_bits_and_constants_are_checked() {
    let m_can = &controllers::m_can::CONTROLLER;
    let error = m_can.unpack([(&controllers::m_can::NBTP, 0x0600_0A83)]).unwrap_err();
    assert_eq!(error, RegisterError::Reserved { register: "NBTP", bits: 0x80 });
    let error = controllers::flexcan_cbt::CONTROLLER
        .unpack([(&controllers::flexcan_cbt::CBT, 0x0000_0021)])
        .unwrap_err();
    assert_eq!(error.to_string(), "CBT.btf is 0 and must be 1");
    let error = controllers::c167::CONTROLLER.unpack([(&controllers::c167::BTR, 0x1_0000)]);
    assert_eq!(error, Err(RegisterError::TooWide { register: "BTR", word: 0x1_0000, bits: 16 }));
}

#[test]
fn fields_lie_inside_their_register_and_do_not_overlap() {
    for controller in ALL {
        for register in controller.registers {
            let mut taken = 0_u32;
            for field in register.fields {
                assert!(
                    field.lsb + field.width <= register.bits,
                    "{} {}",
                    register.name,
                    field.name
                );
                assert_eq!(taken & field.mask(), 0, "{} {}", register.name, field.name);
                taken |= field.mask();
                assert!(field.width <= 16 && field.value_bits >= field.shift + field.width);
            }
        }
    }
}

/// The limits never exceed what the fields hold: whatever is solved can be packed.
#[test]
fn limits_fit_the_fields() {
    for controller in complete() {
        for (phase, limits) in
            [(Phase::Nominal, Some(&controller.nominal)), (Phase::Data, controller.data.as_ref())]
        {
            let Some(limits) = limits else { continue };
            for field in controller.registers.iter().flat_map(|r| r.fields) {
                let Content::Timing(owner, part) = field.content else { continue };
                let (max, base) = match part {
                    Part::Tseg1 => (limits.tseg1.max, 0),
                    Part::Tseg2 => (limits.tseg2.max, 0),
                    Part::Sjw => (limits.sjw_max, 0),
                    Part::PropSeg => (limits.prop_seg.max, 0),
                    Part::PhaseSeg1 => (limits.phase_seg1.max, 0),
                    Part::Prescaler | Part::PrescalerScale => continue,
                };
                if owner != phase {
                    continue;
                }
                let holds = match field.encoding {
                    Encoding::MinusOne => 1 << field.width,
                    Encoding::MinusTwo => (1 << field.width) + 1,
                    _ => (1 << field.width) - 1,
                };
                assert!(i32::from(max) + base <= holds, "{} {}", controller.name, field.name);
            }
        }
    }
}

/// Ranges, positions and encodings equal those of the reference list, if it is there.
#[test]
fn layouts_equal_the_reference_list() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/reference/controllers.json");
    let Ok(text) = std::fs::read_to_string(path) else {
        eprintln!("absent: {path}; the comparison with the reference list is skipped");
        return;
    };
    let list: serde_json::Value = serde_json::from_str(&text).unwrap();
    for entry in list.as_array().unwrap() {
        let id = entry["id"].as_str().unwrap();
        let name =
            id.trim_end_matches("_btr").trim_end_matches("_nominal").trim_end_matches("_data");
        let controller = controllers::find(name).unwrap_or_else(|| panic!("no controller {name}"));
        assert_eq!(controller.name, name);
        for register in entry["registers"].as_array().unwrap() {
            compare_register(controller, register);
        }
        let ranges = &entry["ranges"];
        let is_data = id.ends_with("_data") || id == "flexcan_fdcbt";
        for (key, limits) in [
            ("nominal", Some(&controller.nominal)),
            ("data", controller.data.as_ref()),
            ("fd", controller.data.as_ref()),
            ("xl", controller.xl.as_ref()),
        ] {
            if !ranges[key].is_null() {
                compare_ranges(name, &ranges[key], limits.unwrap());
            }
        }
        if !ranges["tseg1"].is_null() {
            let limits =
                if is_data { controller.data.as_ref().unwrap() } else { &controller.nominal };
            compare_ranges(name, ranges, limits);
        }
    }
}

fn compare_ranges(name: &str, ranges: &serde_json::Value, limits: &Limits) {
    let pair = |value: &serde_json::Value| (value[0].as_u64().unwrap(), value[1].as_u64().unwrap());
    let span = |s: canbaud::timing::Span| (u64::from(s.min), u64::from(s.max));
    assert_eq!(pair(&ranges["tseg1"]), span(limits.tseg1), "{name}");
    assert_eq!(pair(&ranges["tseg2"]), span(limits.tseg2), "{name}");
    assert_eq!(ranges["sjw_max"].as_u64().unwrap(), u64::from(limits.sjw_max), "{name}");
    if ranges["brp"].is_array() {
        let (min, max) = pair(&ranges["brp"]);
        let step = ranges["brp_inc"].as_u64().unwrap();
        for prescaler in (min..=max).step_by(step as usize) {
            assert!(limits.prescalers.contains(prescaler as u16), "{name} {prescaler}");
        }
        assert_eq!(u64::from(limits.prescalers.ends().min), min, "{name}");
    }
    for (key, limit) in
        [("bit_tq", limits.bit_quanta), ("prop", limits.prop_seg), ("ps1", limits.phase_seg1)]
    {
        if ranges[key].is_array() {
            assert_eq!(pair(&ranges[key]), span(limit), "{name} {key}");
        }
    }
}

fn compare_register(controller: &Controller, register: &serde_json::Value) {
    let name = register["name"].as_str().unwrap();
    // The classic mode of RS-CANFD generation 3 is a controller of its own here.
    let (controller, name) = match name {
        "CmCFG(classic)" => (&controllers::rscanfd_gen3_classic::CONTROLLER, "CmCFG"),
        _ => (controller, name),
    };
    let ours = controller.registers.iter().find(|r| r.name == name);
    let ours = ours.unwrap_or_else(|| panic!("{} lacks {name}", controller.name));
    assert_eq!(register["offset"].as_u64(), ours.offset.map(u64::from), "{name}");
    assert_eq!(register["bits"].as_u64(), Some(u64::from(ours.bits)), "{name}");
    for field in register["fields"].as_array().unwrap() {
        let place = (field["lsb"].as_u64().unwrap() as u8, field["w"].as_u64().unwrap() as u8);
        // MCP251xFD TDCO is given with its sign, so no field of ours differs in place.
        let same = ours.fields.iter().find(|f| (f.lsb, f.width) == place);
        let same = same.unwrap_or_else(|| panic!("{} {name} {field}", controller.name));
        let encoding = field["enc"].as_str().unwrap();
        let expected = match encoding.split([' ', '?']).next().unwrap() {
            "m1" => Encoding::MinusOne,
            "m2" => Encoding::MinusTwo,
            "half_m1" => Encoding::HalfMinusOne,
            "raw" | "log2" => Encoding::Raw,
            _ => continue,
        };
        // Prescaler bits of the second channel of the DS80C390 are not ours to write; PS1 of the
        // GRCAN as it is equals TSEG1 minus one, its PROP_SEG being 1.
        if same.content != Content::Other && (controller.name, same.name) != ("grcan", "ps1") {
            assert_eq!(same.encoding, expected, "{} {name} {field}", controller.name);
        }
    }
}
