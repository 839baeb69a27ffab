//! The adapter: requests of the driver in, the node of the simulated bus behind it.

use std::collections::VecDeque;
use std::error::Error;

use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::{BitTiming, Blind, Event, FdSupport, Mode, NodeConfig, NodeId, Oscillator, Time};

use crate::descriptors;
use crate::gs_usb::{self, HostFrame, Request, feature};
use crate::reports::{Level, Reports};
use crate::usbip::{Reply, Setup};

/// Frames that wait for the host, as in candleLight.
const QUEUE: usize = 64;

/// What kind of adapter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Firmware {
    pub(super) reports: Reports,
    pub(super) features: u32,
    /// So many of the last frames are given to the host again after the next start.
    pub(super) stale: usize,
}

/// An adapter at a node of the bus.
#[derive(Debug)]
pub(super) struct Device {
    firmware: Firmware,
    run: Run,
    node: NodeId,
    config: NodeConfig,
    /// Mode flags while started.
    flags: Option<u32>,
    queue: VecDeque<(u32, HostFrame)>,
    /// The last frames that were received, for [`Firmware::stale`].
    last: VecDeque<(u32, HostFrame)>,
    overflow: bool,
    /// The error of this slice: firmware looks at its error register now and then.
    error: Option<HostFrame>,
    level: Level,
    echoes: VecDeque<u32>,
    /// Frames and errors since the start, and how often TXD had been dominant at the start.
    heard: (u64, u64, u64),
    disturbs: bool,
}

impl Device {
    pub(super) fn new(
        firmware: Firmware,
        scenario: &Scenario,
        name: &str,
    ) -> Result<Self, Box<dyn Error>> {
        let (node, config) = scenario.node(name).ok_or_else(|| format!("no node \"{name}\""))?;
        let clock = if firmware.features & feature::FD != 0 { 80_000_000 } else { 48_000_000 };
        let oscillator = Oscillator { hertz: clock, ..config.oscillator };
        let config = NodeConfig { oscillator, mode: Mode::Disabled, ..config.clone() };
        let mut run = Run::new(scenario, scenario.seed)?;
        run.sim_mut().reconfigure_at(Time::ZERO, node, config.clone())?;
        run.hold_news(node);
        Ok(Self {
            firmware,
            run,
            node,
            config,
            flags: None,
            queue: VecDeque::new(),
            last: VecDeque::new(),
            overflow: false,
            error: None,
            level: Level::default(),
            echoes: VecDeque::new(),
            heard: (0, 0, 0),
            disturbs: false,
        })
    }

    /// A transfer on endpoint 0.
    pub(super) fn control(&mut self, setup: Setup, data: &[u8]) -> Reply {
        if setup.request_type & 0x60 != 0x40 {
            return descriptors::standard(setup);
        }
        let clock = self.config.oscillator.hertz as u32;
        let features = self.firmware.features;
        let answer = match Request::new(setup.request) {
            Some(Request::BtConst) => Some(gs_usb::bt_const(features, clock)),
            Some(Request::BtConstExt) if features & feature::BT_CONST_EXT != 0 => {
                Some(gs_usb::bt_const_ext(features, clock))
            }
            Some(Request::DeviceConfig) => Some(gs_usb::device_config()),
            Some(Request::Timestamp) => Some(gs_usb::bytes(&[self.stamp(self.run.sim().now())])),
            Some(Request::GetState) if features & feature::GET_STATE != 0 => Some(self.state()),
            Some(request) => {
                let done = self.set(request, data);
                return done.map_or(Reply::Stall, |()| Reply::Taken(data.len()));
            }
            None => None,
        };
        answer.map_or(Reply::Stall, Reply::Data)
    }

    fn set(&mut self, request: Request, data: &[u8]) -> Option<()> {
        match request {
            Request::HostFormat => Some(()),
            Request::BitTiming => {
                self.config.nominal = timing(data)?;
                Some(())
            }
            Request::DataBitTiming => {
                self.config.data = Some(timing(data)?);
                Some(())
            }
            Request::Mode => match gs_usb::words(data)? {
                [0, _] => self.reset(),
                [1, flags] => self.start(flags),
                _ => None,
            },
            _ => None,
        }
    }

    /// Bit rate of the node as it is set up, in bit/s.
    fn bitrate(&self) -> u64 {
        let periods = u64::from(self.config.nominal.prescaler() * self.config.nominal.quanta());
        (self.config.oscillator.hertz + periods / 2) / periods
    }

    fn start(&mut self, flags: u32) -> Option<()> {
        let listens = flags & self.firmware.features & feature::LISTEN_ONLY != 0;
        self.config.mode = if listens { Mode::BusMonitoring } else { Mode::Normal };
        self.config.fd = match (self.firmware.features & feature::FD, flags & feature::FD) {
            (0, _) => FdSupport::None,
            (_, 0) => FdSupport::Tolerant,
            _ => FdSupport::Enabled,
        };
        let now = self.run.sim().now();
        self.run.sim_mut().reconfigure_at(now, self.node, self.config.clone()).ok()?;
        self.flags = Some(flags);
        self.heard = (0, 0, self.dominant());
        self.disturbs = false;
        let mode = if listens { "listen-only" } else { "normal" };
        println!("open {mode} {} flags {flags:#x}", self.bitrate());
        let stale = self.firmware.stale.min(self.last.len());
        self.queue.extend(self.last.drain(..).rev().take(stale).rev());
        Some(())
    }

    fn reset(&mut self) -> Option<()> {
        if self.flags.take().is_some() {
            let (frames, errors, before) = self.heard;
            let dominant = self.dominant() - before;
            println!("close {frames} frames {errors} errors {dominant} dominant");
        }
        self.config.mode = Mode::Disabled;
        let now = self.run.sim().now();
        self.run.sim_mut().reconfigure_at(now, self.node, self.config.clone()).ok()?;
        self.queue.clear();
        self.echoes.clear();
        self.error = None;
        self.level = Level::default();
        Some(())
    }

    /// How often the node has driven the bus dominant.
    fn dominant(&self) -> u64 {
        self.run.statistics().nodes[self.node.0].dominant
    }

    fn counters(&self) -> (u16, u16) {
        let fault = self.run.sim().node(self.node).fault();
        (fault.tec(), fault.rec())
    }

    fn state(&self) -> Vec<u8> {
        let (tec, rec) = self.counters();
        let state = match tec.max(rec) {
            _ if self.flags.is_none() => 4,
            256.. => 3,
            128.. => 2,
            96.. => 1,
            _ => 0,
        };
        gs_usb::bytes(&[state, u32::from(rec), u32::from(tec)])
    }

    /// The device's clock, in µs.
    const fn stamp(&self, at: Time) -> u32 {
        (at.femtoseconds() / 1_000_000_000) as u32
    }

    /// A frame that the host wants sent.
    pub(super) fn send(&mut self, wire: &[u8]) {
        let Some((echo_id, frame)) = gs_usb::to_send(wire) else { return };
        println!("send {frame:?}");
        self.echoes.push_back(echo_id);
        let now = self.run.sim().now();
        self.run.sim_mut().send_at(now, self.node, frame);
    }

    /// Lets the bus run up to `until`.
    pub(super) fn advance(&mut self, until: Time) {
        self.run.advance(until, &mut Blind);
        for (at, _, event) in self.run.take_held_news() {
            self.notice(at, &event);
        }
        if let Some(error) = self.error.take() {
            self.enqueue(self.stamp(until), error);
        }
    }

    fn notice(&mut self, at: Time, event: &Event) {
        let Some(flags) = self.flags else { return };
        match event {
            Event::Received { frame } => {
                self.heard.0 += 1;
                let frame = (self.stamp(at), HostFrame::received(frame));
                self.last.push_back(frame.clone());
                if self.last.len() > self.firmware.stale {
                    self.last.pop_front();
                }
                self.enqueue(frame.0, frame.1);
            }
            Event::Transmitted { .. } => {
                if let Some(echo_id) = self.echoes.pop_front() {
                    self.enqueue(self.stamp(at), HostFrame::echo(echo_id));
                }
            }
            Event::Counted { tec, rec, .. } if Level::of(*rec) != self.level => {
                self.level = Level::of(*rec);
                self.enqueue(self.stamp(at), self.level.report((*tec, *rec)));
            }
            Event::Error { kind, place, .. } => {
                self.heard.1 += 1;
                let berr = flags & feature::BERR_REPORTING != 0;
                let report = self.firmware.reports.report(*kind, *place, self.counters(), berr);
                self.error = report.or(self.error.take());
                if self.config.mode == Mode::Normal && !self.disturbs {
                    self.disturbs = true;
                    println!("bus disturbed: error flag ({kind}) at {} bit/s", self.bitrate());
                }
            }
            _ => {}
        }
    }

    fn enqueue(&mut self, stamp: u32, frame: HostFrame) {
        if self.queue.len() < QUEUE {
            let overflow = core::mem::take(&mut self.overflow);
            self.queue.push_back((stamp, if overflow { frame.after_overflow() } else { frame }));
        } else {
            self.overflow = true;
        }
    }

    /// The next bulk transfer to the host.
    pub(super) fn next_transfer(&mut self) -> Option<Vec<u8>> {
        let stamped = self.flags? & feature::HW_TIMESTAMP != 0;
        let (stamp, frame) = self.queue.pop_front()?;
        Some(frame.encode(stamped.then_some(stamp)))
    }

    /// Whether the scenario is over.
    pub(super) fn is_over(&self) -> bool {
        self.run.sim().now() >= self.run.end()
    }
}

/// PROP_SEG, PHASE_SEG1, PHASE_SEG2, SJW, prescaler.
fn timing(data: &[u8]) -> Option<BitTiming> {
    let [prop_seg, phase_seg1, phase_seg2, sjw, prescaler] = gs_usb::words(data)?;
    BitTiming::new(prescaler, prop_seg, phase_seg1, phase_seg2, sjw).ok()
}
