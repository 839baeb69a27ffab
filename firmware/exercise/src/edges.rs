//! Edges: all detectors, decoder, encoder.

use crate::{Sink, Source};
use canbaud::detect::{
    BitTime, CompactDetector, DataPhase, Measurement, MinimumPulse, PulseDetector, Verdict,
    find_data_rate,
};
use canbaud::units::{Hertz, Ticks, Timebase};
use canbaud::wire::{
    DataRateWanted, DataTiming, Decoded, Decoder, FdCrc, ItemKind, Level, Listener, Logic, encode,
};

pub(crate) fn exercise(source: &mut Source<'_>, sink: &mut Sink) {
    let mut detector = PulseDetector::<160>::new();
    detector.begin(0, if source.byte() & 1 == 1 { Logic::High } else { Logic::Low });
    let mut compact = CompactDetector::<128>::new();
    compact.begin(0, if source.byte() & 1 == 1 { Logic::High } else { Logic::Low });
    let mut minimum = MinimumPulse::new();
    let mut at = 0;
    for _ in 0..source.word() & 0xFFFF {
        let run = source.word();
        at += u64::from(run);
        detector.push(at);
        compact.push(at);
        minimum.push(run);
    }
    detector.finish(at + u64::from(source.word()));
    compact.finish(at + u64::from(source.word()));
    sink.take(minimum.shortest().unwrap_or(0));
    let timer = Timebase::from_frequency(source.clock());
    let timer = Timebase::new(u64::from(source.word()), u64::from(source.word())).unwrap_or(timer);
    sink.take_long(timer.nanoseconds(Ticks(at).0).unwrap_or(0));
    let mut bit = |bit: BitTime| {
        let rate = bit.millibits_per_second(timer).unwrap_or(0);
        let known = canbaud::rates::nearest(canbaud::rates::nominal(), rate, bit.uncertainty_ppb);
        sink.take_long(known.map_or(rate, |known| known.millibits_per_second()));
    };
    if let Verdict::Found(found) = compact.verdict() {
        bit(found.nominal);
    }
    match detector.verdict() {
        Verdict::Found(found) => {
            bit(found.nominal);
            if let DataPhase::Switched(data) = found.data {
                bit(data);
            }
        }
        Verdict::Conflict { first, second, .. } => {
            bit(first);
            bit(second);
        }
        Verdict::NoTraffic => {}
        Verdict::Undecided(need) => sink.take(need as u32),
    }
    if let Some(timing) = detector.bus_timing()
        && let Some(mut decoder) = Decoder::<160>::new(&timing)
    {
        let mut listener = Hearing { sink, measured: Measurement::default() };
        decoder.begin(0, Level::Recessive);
        let mut at = 0;
        for _ in 0..source.word() & 0xFFFF {
            at += u64::from(source.word());
            decoder.edges(&[at], &mut listener);
        }
        decoder.finish(at, &mut listener);
        let bit = listener.measured.bit_time();
        sink.take_long(bit.map_or(0, |bit| bit.ticks_q20));
    }
    if let Some(frame) = source.frame() {
        let crc = if source.byte() & 1 == 1 { FdCrc::Iso } else { FdCrc::NonIso };
        let encoded = encode(&frame, crc).acknowledged();
        for level in encoded.bits.iter() {
            sink.take(u32::from(level == Level::Dominant));
        }
    }
    sink.take_long(Hertz::MAX.hertz());
}

struct Hearing<'a> {
    sink: &'a mut Sink,
    measured: Measurement,
}

impl Listener for Hearing<'_> {
    fn item(&mut self, decoded: &Decoded) {
        self.sink.take_long(decoded.item.start);
        if let ItemKind::Frame(received) = decoded.item.kind {
            self.sink.take(received.crc);
            self.measured.add(&decoded.nominal);
        }
    }

    fn data_rate(&mut self, wanted: &DataRateWanted<'_>) -> Option<DataTiming> {
        find_data_rate(wanted)
    }
}
