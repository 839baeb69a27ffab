//! Bit timing: solver, registers of every controller, physics, tables, doctor.

use crate::{Sink, Source};
use canbaud::timing::controllers::{ALL, Configuration, Controller, Register};
use canbaud::timing::fd::{PhaseRequests, SamplePoints, solve_phases};
use canbaud::timing::physics::{classic_tolerance, fd_tolerance};
use canbaud::timing::physics_bus::{Bus, longest_bus_m, longest_possible_m, outer_bus_m};
use canbaud::timing::physics_fit::solutions_for_bus;
use canbaud::timing::tables::{AP2925, AutobaudTable, CANOPEN, DS80C390, Deviation};
use canbaud::timing::tdc::Tdc;
use canbaud::timing::xl::{PwmLimits, pwm, short_share};
use canbaud::timing::{BitTiming, Request, SamplePointPolicy, doctor, solutions, solve};
use canbaud::units::Permille;

pub(crate) fn exercise(source: &mut Source<'_>, sink: &mut Sink) {
    let mut request = Request::new(source.clock(), source.bitrate());
    if let Some(point) = Permille::new(source.word() as u16) {
        request = request.with_sample_point(point, SamplePointPolicy::Nearest);
    }
    let Some(controller) = ALL.get(source.byte() as usize) else { return };
    match solve(&request, &controller.nominal) {
        Ok(solution) => timing(source, sink, controller, &solution.timing),
        Err(error) => {
            sink.take_long(error.nearest().map_or(0, |rate| rate.millibits_per_second()));
            sink.take(error.reason().len() as u32);
        }
    }
    if let Ok(best) = solutions::<4>(&request, &controller.nominal) {
        best.iter().for_each(|solution| sink.take_long(solution.bitrate_error_ppb() as u64));
    }
    let phases = PhaseRequests {
        nominal: request,
        data: (source.byte() & 1 == 1).then(|| Request::new(request.clock, source.bitrate())),
        xl: (source.byte() & 1 == 1).then(|| Request::new(request.clock, source.bitrate())),
        sample_points: if source.byte() & 1 == 1 { SamplePoints::Own } else { SamplePoints::Equal },
    };
    if let Ok(solved) = solve_phases(controller, &phases) {
        words(sink, controller, &solved.configuration());
    }
    let found = doctor::diagnose(source.bitrate(), u64::from(source.word()), source.word());
    sink.take(found.residual_ppm as u32);
    tables(source, sink, &request, controller);
}

fn timing(source: &mut Source<'_>, sink: &mut Sink, of: &Controller, timing: &BitTiming) {
    words(sink, of, &Configuration::classic(*timing));
    sink.take_long(timing.sample_point().permille());
    sink.take_long(classic_tolerance(timing).limit().ppm_floor());
    sink.take_long(fd_tolerance(timing, timing).limit().ppm_floor());
    sink.take(Tdc::of(timing, of.tdc_offset_max).offset().unwrap_or(0) as u32);
    let bus = Bus::new(source.word()).with_node_delay_ns(source.word());
    let (clock, rate) = (source.clock(), source.bitrate());
    sink.take(longest_bus_m(timing, clock, 1, &bus).unwrap_or(0));
    sink.take(outer_bus_m(timing, clock, 1, &bus).unwrap_or(0));
    sink.take(longest_possible_m(rate, &bus, source.word()).unwrap_or(0));
    let request = Request::new(clock, rate);
    if let Ok(best) = solutions_for_bus::<2>(&request, &of.nominal, &bus, source.word()) {
        best.iter().for_each(|solution| sink.take(solution.timing.quanta()));
    }
    let (xl_bit, bit) = (u64::from(source.word()), u64::from(source.word()));
    if let Ok(coding) = pwm(clock, xl_bit, bit, PwmLimits::SIX_BITS) {
        sink.take_long(short_share(&coding).permille());
    }
}

/// To registers and back.
fn words(sink: &mut Sink, controller: &Controller, configuration: &Configuration) {
    let Ok(packed) = controller.pack(configuration) else { return };
    let mut words: [Option<(&Register, u32)>; 8] = [None; 8];
    for (slot, (register, word)) in words.iter_mut().zip(packed) {
        if let Ok(word) = word {
            sink.take(word);
            *slot = Some((register, word));
        }
    }
    if let Ok(back) = controller.unpack(words.into_iter().flatten()) {
        sink.take(u32::from(back == *configuration));
    }
}

fn tables(source: &mut Source<'_>, sink: &mut Sink, request: &Request, controller: &Controller) {
    let at = source.byte() as usize;
    sink.take(AP2925.get(at).map_or(0, |row| row.ticks()));
    sink.take(CANOPEN.get(at).map_or(0, |row| row.bits_per_second));
    sink.take(DS80C390.get(at).map_or(0, |row| u32::from(row.brpv())));
    let rates = [source.bitrate(), source.bitrate(), source.bitrate()];
    let timer = source.clock();
    let deviation = Deviation::Ticks(source.word());
    if let Ok(table) = AutobaudTable::build(timer, rates, deviation, request, &controller.nominal) {
        let row = table.find(u64::from(source.word()));
        sink.take(row.map_or(0, |row| row.solution.timing.quanta()));
    }
}
