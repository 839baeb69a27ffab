//! The capture as a controller.

use std::collections::VecDeque;
use std::path::Path;
use std::time::Duration;

use canbaud::detect::scan::{
    Candidate, Capabilities, Configured, Controller, ErrorClass, ErrorPlace, ErrorSeen, Evidence,
    FdSupport, FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::timing::default_sample_point;
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{
    BusTiming, DataTiming, Decoded, Decoder, ErrorKind, Field, ItemKind, Level,
    Listener as ItemListener,
};

use super::receiver::Receiver;
use super::track::Track;
use crate::{Clock, LinkError, Listener};

/// A frame is decoded when the line has been idle behind it.
const LATENCY: Micros = Micros::from_ms(20);
/// Nothing is heard between two looks.
const LOOK: Duration = Duration::from_millis(2);
const SLOWEST: Bitrate = Bitrate::new(1_000).unwrap();
const FASTEST: Bitrate = Bitrate::new(1_000_000).unwrap();

/// A capture file that plays the bus.
#[derive(Debug)]
pub struct ReplayListener {
    track: Track,
    name: String,
    clock: Clock,
    setting: Option<(BusTiming, Receiver)>,
    hearing: Option<Hearing>,
}

/// Where the decoder is.
#[derive(Debug)]
struct Hearing {
    decoder: Box<Decoder<800>>,
    /// When the present repetition began.
    began: Micros,
    /// Edges of it that were heard.
    next: usize,
    receiver: Receiver,
    heard: Heard,
    told: VecDeque<Observation>,
}

/// What the decoder read, from and to which tick.
#[derive(Debug, Default)]
struct Heard(Vec<(u64, u64, Observation)>);

impl ReplayListener {
    /// Reads channel `channel` of the capture at `path`, or its first one.
    ///
    /// # Errors
    /// The file cannot be read, or has no such channel.
    pub fn open(path: &Path, channel: Option<&str>, clock: Clock) -> Result<Self, LinkError> {
        let track = Track::read(path, channel)?;
        let name = path.display().to_string();
        Ok(Self { track, name, clock, setting: None, hearing: None })
    }

    /// A bit time in ticks, times 2^20.
    fn ticks_q20(&self, rate: Bitrate) -> Option<u64> {
        let timebase = self.track.timebase;
        let ticks = u128::from(timebase.ticks()) << 20;
        let bits = u128::from(timebase.seconds()) * u128::from(rate.bits_per_second());
        u64::try_from(ticks / bits).ok()
    }

    fn timing(&self, candidate: &Candidate) -> Option<BusTiming> {
        let nominal = self.ticks_q20(candidate.nominal)?;
        let mut timing = BusTiming::classic(nominal);
        if let Some(rate) = candidate.data {
            let data = self.ticks_q20(rate)?;
            let part =
                |ticks: u64, rate| ticks / 1000 * u64::from(default_sample_point(rate).permille());
            // Nominal up to one sample point, data behind the other.
            let brs_ticks_q20 = part(nominal, candidate.nominal) + data - part(data, rate);
            timing.data = Some(DataTiming { ticks_q20: data, brs_ticks_q20 });
        }
        Some(timing)
    }

    fn misuse(&self, what: &'static str) -> LinkError {
        LinkError::State { adapter: self.name.clone(), what }
    }
}

impl Hearing {
    /// In the middle of the recording, like a controller that is switched on.
    fn start(track: &Track, decoder: Decoder<800>, receiver: Receiver, now: Micros) -> Self {
        let into = Micros(now.0 % track.length().0.max(1));
        let at = track.ticks(into);
        let next = track.edges.partition_point(|edge| *edge <= at);
        let level = if next.is_multiple_of(2) { track.level } else { track.level.toggled() };
        let mut decoder = Box::new(decoder);
        decoder.begin(at, level);
        let (heard, told) = (Heard::default(), VecDeque::new());
        Self { decoder, began: now - into, next, receiver, heard, told }
    }

    /// Hears what happened up to `now`.
    fn advance(&mut self, track: &Track, now: Micros) {
        // A scan that was held up does not hear what it missed more than once.
        if now - self.began > track.length().times(2) {
            self.began = now;
            self.next = track.edges.len();
        }
        let at = track.ticks(now - self.began);
        let rest = track.edges.get(self.next..).unwrap_or_default();
        let count = rest.partition_point(|edge| *edge <= at);
        self.decoder.edges(rest.get(..count).unwrap_or_default(), &mut self.heard);
        self.next += count;
        if now >= self.began + track.length() {
            self.decoder.finish(track.end, &mut self.heard);
            self.decoder.begin(0, track.level);
            self.began = now;
            self.next = 0;
        }
        self.tell(track);
    }

    /// A frame that no controller with this bit timing reads is an error to it.
    fn tell(&mut self, track: &Track) {
        for (start, end, observation) in self.heard.0.drain(..) {
            self.told.push_back(match observation {
                Observation::Frame(seen)
                    if !self.receiver.reads(track, &seen.frame, start, end) =>
                {
                    let (class, place) = (ErrorClass::Unknown, ErrorPlace::Unknown);
                    Observation::Error(ErrorSeen { class, place, received: None })
                }
                other => other,
            });
        }
    }
}

impl ItemListener for Heard {
    fn item(&mut self, decoded: &Decoded) {
        let observation = match decoded.item.kind {
            ItemKind::Frame(received) => Observation::Frame(FrameSeen {
                frame: received.frame,
                origin: Origin::Bus,
                received: None,
            }),
            ItemKind::Error(error) => {
                // The recording began or ended there: nobody on the bus saw an error.
                if error.kind == ErrorKind::Truncated {
                    return;
                }
                let (class, place) = (class_of(error.kind), place_of(error.field));
                Observation::Error(ErrorSeen { class, place, received: None })
            }
            ItemKind::Overload => return,
        };
        self.0.push((decoded.item.start, decoded.item.end, observation));
    }
}

const fn class_of(kind: ErrorKind) -> ErrorClass {
    match kind {
        ErrorKind::Stuff => ErrorClass::Stuff,
        ErrorKind::Crc => ErrorClass::Crc,
        ErrorKind::Form => ErrorClass::Form,
        ErrorKind::Acknowledge => ErrorClass::Acknowledge,
        _ => ErrorClass::Unknown,
    }
}

const fn place_of(field: Field) -> ErrorPlace {
    match field {
        Field::Arbitration => ErrorPlace::Arbitration,
        Field::Control | Field::Data | Field::Crc => ErrorPlace::BeforeCrcEnd,
        Field::CrcDelimiter => ErrorPlace::CrcDelimiter,
        Field::AckSlot => ErrorPlace::AckSlot,
        Field::AckDelimiter => ErrorPlace::AckDelimiter,
        Field::EndOfFrame(_) => ErrorPlace::EndOfFrame,
        Field::Intermission => ErrorPlace::Between,
        _ => ErrorPlace::Unknown,
    }
}

impl Controller for ReplayListener {
    type Error = LinkError;

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            rates: RateChoice::Between(SLOWEST, FASTEST),
            evidence: Evidence::Errors,
            fd: FdSupport::Fd,
            reconfiguration: Micros::from_ms(1),
            latency: LATENCY,
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, LinkError> {
        self.hearing = None;
        let timing = self.timing(candidate);
        self.setting = timing.map(|timing| (timing, Receiver::new(candidate, timing.ticks_q20)));
        match self.setting {
            Some(_) => Ok(Configured { nominal: candidate.nominal, data: candidate.data }),
            None => Err(LinkError::Rate {
                adapter: self.name.clone(),
                rate: candidate.nominal,
                reason: "the recorder was too slow for it".to_owned(),
            }),
        }
    }

    fn start_monitoring(&mut self) -> Result<(), LinkError> {
        let decoder =
            self.setting.and_then(|(timing, receiver)| Some((Decoder::new(&timing)?, receiver)));
        let Some((decoder, receiver)) = decoder else {
            return Err(self.misuse("it listens only behind being configured"));
        };
        self.hearing = Some(Hearing::start(&self.track, decoder, receiver, self.clock.now()));
        Ok(())
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, LinkError> {
        let Some(hearing) = &mut self.hearing else {
            return Err(self.misuse("it hears only while it listens"));
        };
        if hearing.told.is_empty() {
            hearing.advance(&self.track, now);
        }
        Ok(hearing.told.pop_front())
    }

    fn stop(&mut self) -> Result<(), LinkError> {
        self.hearing = None;
        Ok(())
    }
}

impl Listener for ReplayListener {
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError> {
        std::thread::sleep(timeout.min(LOOK));
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{} (replay)", self.name)
    }

    fn remarks(&self) -> Vec<String> {
        let level = match self.track.level {
            Level::Recessive => "high",
            Level::Dominant => "low",
        };
        vec![format!("a recording is replayed; high is taken for recessive, it begins {level}")]
    }

    fn restore(&mut self) -> Result<(), LinkError> {
        self.hearing = None;
        Ok(())
    }
}
