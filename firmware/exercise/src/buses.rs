//! Live buses: the scan with a controller, the autonomous node, error confinement.

use crate::{Sink, Source};
use canbaud::detect::scan::{
    Candidate, Candidates, Capabilities, Configured, Controller, Driver, ErrorClass, ErrorPlace,
    ErrorSeen, Evidence, FdSupport, FrameSeen, Observation, Origin, Policy, Progress, RateChoice,
    Scan, Settings,
};
use canbaud::fault::{ErrorConfinement, FlagCause, Occurrence};
use canbaud::lss::{NodeId, RateSetting};
use canbaud::node::{self, Action, Input, Means, Node, Sending, Slot, Storage};
use canbaud::units::{Bitrate, Micros, Timebase};
use canbaud::wire::{Level, Logic};

pub(crate) fn exercise(source: &mut Source<'_>, sink: &mut Sink) {
    scan(source, sink);
    autonomous(source, sink);
    confinement(source, sink);
}

/// A controller that hears whatever the source says.
struct Hearing<'a, 'b>(&'a mut Source<'b>);

impl Controller for Hearing<'_, '_> {
    type Error = ();

    fn capabilities(&self) -> Capabilities<'_> {
        capabilities(Evidence::Errors)
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, ()> {
        match self.0.byte() {
            0 => Err(()),
            _ => Ok(Configured { nominal: candidate.nominal, data: candidate.data }),
        }
    }

    fn start_monitoring(&mut self) -> Result<(), ()> {
        Ok(())
    }

    fn observe(&mut self, _: Micros) -> Result<Option<Observation>, ()> {
        Ok(observation(self.0))
    }

    fn stop(&mut self) -> Result<(), ()> {
        Ok(())
    }
}

fn capabilities(evidence: Evidence) -> Capabilities<'static> {
    let low = Bitrate::new(10_000).unwrap_or(crate::RATE);
    Capabilities {
        rates: RateChoice::Between(low, crate::RATE),
        evidence,
        fd: FdSupport::Fd,
        reconfiguration: Micros(500),
        latency: Micros(0),
    }
}

fn observation(source: &mut Source<'_>) -> Option<Observation> {
    match source.byte() % 6 {
        0 => source.frame().map(|frame| {
            let received = (source.byte() & 1 == 1).then(|| source.time());
            Observation::Frame(FrameSeen { frame, origin: Origin::Bus, received })
        }),
        1 => {
            let class = if source.byte() & 1 == 1 { ErrorClass::Stuff } else { ErrorClass::Crc };
            let place = if source.byte() & 1 == 1 {
                ErrorPlace::AckDelimiter
            } else {
                ErrorPlace::BeforeCrcEnd
            };
            Some(Observation::Error(ErrorSeen { class, place, received: None }))
        }
        2 => Some(Observation::ReceiveErrors(source.word() as u16)),
        3 => Some(Observation::Edges(source.word())),
        4 => Some(Observation::Lost),
        _ => None,
    }
}

fn scan(source: &mut Source<'_>, sink: &mut Sink) {
    let candidates = match source.byte() % 3 {
        0 => Candidates::<16>::canopen(),
        1 => Candidates::<16>::known(),
        _ => Candidates::<16>::sweep(source.bitrate(), source.bitrate()),
    };
    let Ok(candidates) = candidates else { return };
    let policy = Policy::ALL.get(source.byte() as usize).copied().unwrap_or_default();
    let settings =
        Settings { policy, last_known: Bitrate::new(source.word()), ..Settings::default() };
    let evidence = if source.byte() & 1 == 1 { Evidence::Errors } else { Evidence::Counter };
    let scan = Scan::new(&candidates, &capabilities(evidence), settings);
    sink.take_long(scan.bound().map_or(0, |bound| bound.0));
    let mut now = 0;
    let mut driver = Driver::new(Hearing(source), scan, |_: &Hearing<'_, '_>| {
        now += 1000;
        Micros(now)
    });
    while let Ok(progress) = driver.turn() {
        match progress {
            Progress::Listening(until) => sink.take_long(until.map_or(0, |until| until.0)),
            Progress::Done(_) => break,
        }
        let status = driver.scan().status(Micros(1));
        sink.take(status.visits);
        driver.scan().standings().for_each(|standing| sink.take(standing.frames));
    }
}

fn autonomous(source: &mut Source<'_>, sink: &mut Sink) {
    let timer = Timebase::from_frequency(source.clock());
    let means = match source.byte() % 3 {
        0 => Means::Timer(timer),
        1 => Means::Controller(capabilities(Evidence::Errors)),
        _ => Means::Both(timer),
    };
    let Some(id) = NodeId::new(source.byte()) else { return };
    let settings = node::Settings::automatic(id, means);
    let remembered = Some(source.bitrate());
    let Ok(mut node) = Node::<160, 8>::new(settings, remembered, Micros(0)) else { return };
    for _ in 0..source.word() & 0xFFFF {
        let now = source.time();
        match source.byte() % 8 {
            0 => node.edge(u64::from(source.word()), Logic::High),
            1 => node.timer(u64::from(source.word()), Logic::High),
            2 => {
                let input = Input::Ready(Configured { nominal: source.bitrate(), data: None });
                node.handle(now, &input);
            }
            3 => node.handle(now, &Input::Refused),
            4 => node.handle(now, &Input::Sent),
            5 => {
                let _ = node.set_rate(RateSetting::Fixed(source.bitrate()), now);
                node.set_sending(Sending::Allowed);
            }
            6 => {
                let mut faults = ErrorConfinement::new();
                faults.count(Occurrence::ReceiverError);
                let (tec, rec) = (source.word() as u16, source.word() as u16);
                node.handle(now, &Input::Fault { state: faults.state(), tec, rec });
            }
            _ => {
                if let Some(heard) = observation(source) {
                    node.handle(now, &Input::Heard(heard));
                }
            }
        }
        while let Some(action) = node.poll(now) {
            match action {
                Action::Send(frame) => sink.take(u32::from(frame.dlc())),
                Action::Listen(candidate) | Action::TakePart(candidate) => {
                    sink.take(candidate.nominal.bits_per_second());
                }
                Action::Remember(rate) => remember(rate, source, sink),
                Action::Stop | Action::Reset(_) => {}
            }
        }
        sink.take_long(node.deadline().map_or(0, |at| at.0));
        let (run, error) = node.leds().lit(now);
        sink.take(u32::from(run) + 2 * u32::from(error));
    }
}

fn remember(rate: Bitrate, source: &mut Source<'_>, sink: &mut Sink) {
    let mut flash = Flash([[source.byte(); 32]; 2]);
    let bytes = rate.bits_per_second().to_le_bytes();
    sink.take(u32::from(node::save(&mut flash, &bytes).is_ok()));
    if let Ok(Some(bytes)) = node::load::<_, 4>(&mut flash) {
        sink.take(u32::from_le_bytes(bytes));
    }
}

struct Flash([[u8; 32]; 2]);

impl Flash {
    fn slot(&mut self, slot: Slot) -> &mut [u8; 32] {
        let [a, b] = &mut self.0;
        match slot {
            Slot::A => a,
            Slot::B => b,
        }
    }
}

impl Storage for Flash {
    type Error = ();

    fn read(&mut self, slot: Slot, into: &mut [u8]) -> Result<(), ()> {
        into.iter_mut().zip(self.slot(slot)).for_each(|(to, from)| *to = *from);
        Ok(())
    }

    fn write(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), ()> {
        self.slot(slot).iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        Ok(())
    }
}

fn confinement(source: &mut Source<'_>, sink: &mut Sink) {
    let mut faults = ErrorConfinement::new();
    for _ in 0..source.word() & 0xFFFF {
        match source.byte() & 3 {
            0 => drop(faults.count(Occurrence::TransmitterError(FlagCause::Other))),
            1 => drop(faults.count(Occurrence::Received)),
            2 => drop(faults.bit(Level::Recessive)),
            _ => drop(faults.recessive_bits(source.word())),
        }
        sink.take(u32::from(faults.tec()) + u32::from(faults.rec()));
    }
}
