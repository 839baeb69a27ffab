//! Whatever is heard and whenever: no panic, the bound holds, and no rate is announced without
//! frames that were received at it.

use canbaud::detect::scan::*;
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};
use proptest::prelude::*;

/// What happens next.
#[derive(Debug, Clone)]
enum Event {
    /// Time goes on, or back.
    Later(u64),
    Earlier(u64),
    /// To the deadline.
    Deadline,
    Poll,
    Frame {
        content: u8,
        fd: bool,
        received: Option<i64>,
        local: bool,
    },
    Error {
        class: ErrorClass,
        place: ErrorPlace,
        received: Option<i64>,
    },
    Counter(u16),
    Edges(u32),
    Lost,
    /// The controller listens although nobody asked.
    Listening,
    Refused,
}

fn span() -> impl Strategy<Value = u64> {
    prop_oneof![0..100_u64, 0..10_000_u64, 0..2_000_000_u64, Just(u64::MAX)]
}

fn stamp() -> impl Strategy<Value = Option<i64>> {
    prop_oneof![Just(None), Just(Some(0)), (-50_000..50_000_i64).prop_map(Some)]
}

fn class() -> impl Strategy<Value = ErrorClass> {
    use ErrorClass::{Acknowledge, Bit, Crc, Form, Stuff, Unknown};
    prop::sample::select(vec![Stuff, Form, Crc, Bit, Acknowledge, Unknown])
}

fn place() -> impl Strategy<Value = ErrorPlace> {
    use ErrorPlace::{AckDelimiter, AckSlot, Arbitration, BeforeCrcEnd, Between, EndOfFrame};
    prop::sample::select(vec![
        Arbitration,
        BeforeCrcEnd,
        ErrorPlace::CrcDelimiter,
        AckSlot,
        AckDelimiter,
        EndOfFrame,
        Between,
        ErrorPlace::Unknown,
    ])
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => (0..3_000_u64).prop_map(Event::Later),
        1 => span().prop_map(Event::Later),
        1 => (0..5_000_u64).prop_map(Event::Earlier),
        4 => Just(Event::Deadline),
        4 => Just(Event::Poll),
        2 => (0..4_u8, any::<bool>(), stamp(), any::<bool>()).prop_map(
            |(content, fd, received, local)| Event::Frame { content, fd, received, local }
        ),
        6 => (class(), place(), stamp()).prop_map(
            |(class, place, received)| Event::Error { class, place, received }
        ),
        1 => any::<u16>().prop_map(Event::Counter),
        1 => any::<u32>().prop_map(Event::Edges),
        1 => Just(Event::Lost),
        1 => Just(Event::Listening),
        1 => Just(Event::Refused),
    ]
}

/// The scan's controller, which believes everything, and what may be believed of it.
struct World {
    scan: Scan<8>,
    now: Micros,
    start: Option<Micros>,
    /// Since when it listens, and at which rate.
    listening: Option<(Micros, Bitrate)>,
    /// Frames from the bus at each rate that came while it listened there, by content.
    heard: Vec<(Bitrate, u8, bool)>,
    latency: Micros,
}

const T_CC: Micros = Micros(900);

impl World {
    fn new(
        evidence: Evidence,
        latency: Micros,
        settings: Settings,
        data_rates: &[Bitrate],
    ) -> Self {
        let rates = RateChoice::Between(Bitrate::new(1).unwrap(), Bitrate::new(1_000_000).unwrap());
        let fd = FdSupport::Fd;
        let capabilities = Capabilities { rates, evidence, fd, reconfiguration: T_CC, latency };
        let nominal = [125_000, 250_000, 500_000].map(|rate| Bitrate::new(rate).unwrap());
        let mut list = Candidates::<8>::of_rates(&nominal).unwrap();
        if !data_rates.is_empty() {
            list = list.with_data(data_rates).unwrap();
        }
        let scan = Scan::new(&list, &capabilities, settings);
        let start = Micros::from_ms(10_000);
        Self { scan, now: start, start: None, listening: None, heard: Vec::new(), latency }
    }

    fn poll(&mut self) {
        self.start = self.start.or(Some(self.now));
        match self.scan.poll(self.now) {
            Some(Action::Listen(candidate)) => {
                self.now = self.now + T_CC;
                let configured = Configured { nominal: candidate.nominal, data: candidate.data };
                self.scan.handle_listening(self.now, configured);
                self.listening = Some((self.now, candidate.nominal));
            }
            Some(Action::Stop) => self.listening = None,
            None => {}
        }
    }

    fn at(&self, received: Option<i64>) -> Option<Micros> {
        let now = i128::from(self.now.0);
        received.map(|by| Micros((now + i128::from(by)).clamp(0, u64::MAX.into()) as u64))
    }

    fn frame(&mut self, content: u8, fd: bool, received: Option<i64>, local: bool) {
        let kind =
            if fd { FrameKind::Fd { brs: content > 1, esi: false } } else { FrameKind::Data };
        let frame = Frame::new(Id::Base(0x100), kind, 1, &[content]).unwrap();
        let origin = if local { Origin::Local } else { Origin::Bus };
        let received = self.at(received);
        if let (Some((since, rate)), false) = (self.listening, local) {
            let fresh = match received {
                Some(at) => at >= since,
                None => self.now >= since + self.latency,
            };
            if fresh {
                self.heard.push((rate, content, fd));
            }
        }
        let seen = FrameSeen { frame, origin, received };
        self.scan.handle(self.now, &Observation::Frame(seen));
    }

    fn take(&mut self, event: &Event) {
        match *event {
            Event::Later(by) => self.now = self.now + Micros(by),
            Event::Earlier(by) => self.now = self.now - Micros(by),
            Event::Deadline => {
                if let Some(due) = self.scan.deadline() {
                    self.now = self.now.max(due);
                }
                self.poll();
            }
            Event::Poll => self.poll(),
            Event::Frame { content, fd, received, local } => {
                self.frame(content, fd, received, local);
            }
            Event::Error { class, place, received } => {
                let seen = ErrorSeen { class, place, received: self.at(received) };
                self.scan.handle(self.now, &Observation::Error(seen));
            }
            Event::Counter(count) => {
                self.scan.handle(self.now, &Observation::ReceiveErrors(count));
            }
            Event::Edges(count) => self.scan.handle(self.now, &Observation::Edges(count)),
            Event::Lost => self.scan.handle(self.now, &Observation::Lost),
            Event::Listening => {
                let rate = Bitrate::new(123_456).unwrap();
                let configured = Configured { nominal: rate, data: None };
                self.scan.handle_listening(self.now, configured);
            }
            Event::Refused => self.scan.handle_refused(self.now),
        }
    }

    /// What holds whatever happened.
    fn check(&self) {
        let status = self.scan.status(self.now);
        assert!(self.scan.standings().count() <= 8);
        assert_eq!(self.scan.outcome().is_some(), status.activity == Activity::Done);
        let Some(Outcome::Found(found)) = self.scan.outcome() else { return };
        let at_rate = || self.heard.iter().filter(|(rate, ..)| *rate == found.nominal());
        let mut contents: Vec<_> = at_rate().map(|(_, content, fd)| (*content, *fd)).collect();
        assert!(!contents.is_empty(), "announced without a frame: {found:?}");
        assert!(found.frames as usize <= contents.len(), "{found:?}");
        contents.sort_unstable();
        contents.dedup();
        assert!(usize::from(found.distinct) <= contents.len(), "{found:?}");
    }
}

fn data() -> [Bitrate; 2] {
    [1_000_000, 2_000_000].map(|rate| Bitrate::new(rate).unwrap())
}

fn settings() -> impl Strategy<Value = Settings> {
    let policy = prop::sample::select(Policy::ALL.to_vec());
    let end = prop::sample::select(vec![End::AtBound, End::Never]);
    (policy, end, 0..3_u32, 0..2_000_000_u64).prop_map(|(policy, end, rounds, pause)| Settings {
        policy,
        end,
        rounds,
        pause: Micros(pause),
        ..Settings::default()
    })
}

fn evidence() -> impl Strategy<Value = Evidence> {
    prop::sample::select(vec![Evidence::Errors, Evidence::Counter, Evidence::FramesOnly])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn nothing_makes_it_panic_or_announce_what_was_not_heard(
        evidence in evidence(),
        latency in 0..30_000_u64,
        settings in settings(),
        events in prop::collection::vec(event(), 0..400),
    ) {
        let mut world = World::new(evidence, Micros(latency), settings, &data());
        for event in &events {
            world.take(event);
            world.check();
        }
    }

    /// One that is polled at its deadlines ends within its bound, whatever it hears.
    #[test]
    fn the_bound_holds_whatever_is_heard(
        evidence in evidence(),
        settings in settings(),
        events in prop::collection::vec(event(), 1..200),
    ) {
        let mut world = World::new(evidence, Micros(0), settings, &data());
        let Some(bound) = world.scan.bound() else { return Ok(()) };
        world.poll();
        let start = world.start.unwrap();
        for event in events.iter().cycle().take(20_000) {
            if world.scan.outcome().is_some() {
                break;
            }
            let due = world.scan.deadline().unwrap_or(world.now);
            match event {
                // Time goes on, but never past a deadline without a poll.
                Event::Later(by) => {
                    world.now = (world.now + Micros(*by)).min(due.max(world.now));
                    world.poll();
                }
                Event::Earlier(_) | Event::Listening | Event::Refused => {}
                event => world.take(event),
            }
            prop_assert!(world.now <= start + bound + T_CC, "{} of {bound}", world.now - start);
        }
        if world.scan.outcome().is_none() {
            // Time stood still for too long: from here on it does not.
            for _ in 0..100_000 {
                world.take(&Event::Deadline);
            }
        }
        prop_assert!(world.scan.outcome().is_some(), "no outcome");
        prop_assert!(world.now <= start + bound, "{} of {bound}", world.now - start);
    }

    /// One frame is never enough without a quiet time, and an equal one makes it no better.
    #[test]
    fn one_content_is_announced_after_a_quiet_time_only(
        copies in 1..6_usize,
        gap in 300..5_000_u64,
    ) {
        let mut world = World::new(Evidence::Errors, Micros(0), Settings::default(), &[]);
        world.poll();
        world.now = world.now + Micros(5_000);
        let first = world.now;
        for _ in 0..copies {
            world.frame(1, false, Some(0), false);
            world.poll();
            // 125 kbit/s is the slowest that could look like 500 kbit/s: 160 bits are 1.28 ms.
            let quiet = world.now - first >= Micros(1_280);
            prop_assert_eq!(world.scan.outcome().is_some(), quiet, "{}", world.now - first);
            if quiet {
                break;
            }
            world.now = world.now + Micros(gap);
        }
    }
}
