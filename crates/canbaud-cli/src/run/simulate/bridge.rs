//! The bus behind a channel of this machine: vcan, an interface, an adapter, UDP multicast.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use canbaud::lss::{RateSetting, Request};
use canbaud::timing::default_sample_point;
use canbaud::units::{Bitrate, Permille};
use canbaud::wire::Frame;
use canbaud_lab::Autonomous;
use canbaud_link::LinkError;
use canbaud_link::bus::FrameBus;
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::{BitTiming, Event, Mode, NodeConfig, NodeId, Span, Time};

use super::Outcome;
use super::args::SimulateArgs;
use super::told::Told;
use crate::outlet::Outlet;
use crate::run::lss::{Channel, Trouble, Watched, report};
use crate::tell::tell;

/// The bus runs this far at a time.
const SLICE: Span = Span::from_us(500);

/// Serves until the end of the scenario, or until a signal comes; the channel is put back.
pub(super) fn serve(
    args: &SimulateArgs,
    scenario: &Scenario,
    name: &str,
    channel: &Channel,
) -> Result<Outcome> {
    let Some((node, config)) = scenario.node(name) else {
        bail!("no node \"{name}\", there are: {}", scenario.node_names().join(", "));
    };
    if scenario.is_autonomous(node) {
        bail!("node \"{name}\" is autonomous, the bridge needs one without software");
    }
    let config = NodeConfig { mode: Mode::Normal, ..config.clone() };
    let mut run = Run::with(scenario, args.seed.unwrap_or(scenario.seed), &Autonomous)?;
    run.sim_mut().reconfigure_at(Time::ZERO, node, config)?;
    run.hold_news(node);
    let bus = match Watched::open(channel, args.bitrate) {
        Ok(bus) => bus,
        Err(trouble) => return Ok(Outcome::Channel(report(&trouble))),
    };
    tell!("canbaud: transmits on {channel} what node \"{name}\" receives");
    let follow = if bus.is_virtual() { Follow::Activations } else { Follow::Nothing };
    let told = Told::new(scenario.node_names());
    let mut bridge = Bridge { run, node, bus, follow, pending: None, told };
    let served = bridge.serve();
    // Before anything is said: who reads may be slow, or gone.
    let put_back = bridge.bus.put_back(channel);
    let ended = bridge.ended(served);
    match put_back {
        Ok(()) => ended,
        Err(trouble) => {
            // Of two troubles both are said.
            if let Err(error) = &ended {
                tell!("canbaud: {error:#}");
            }
            Ok(Outcome::Channel(report(&trouble)))
        }
    }
}

/// What the node in the scenario goes along with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Follow {
    /// The channel has no bit rate, so the master cannot change it: the node does, as the master's
    /// own interface would.
    Activations,
    /// The channel has a bit rate of its own.
    Nothing,
}

struct Bridge {
    run: Run,
    node: NodeId,
    bus: Watched,
    follow: Follow,
    /// The bit rate that a device was set to last.
    pending: Option<Bitrate>,
    told: Told,
}

impl Bridge {
    fn serve(&mut self) -> Result<()> {
        let (began, end) = (Instant::now(), self.run.end());
        while self.run.sim().now() < end {
            let until = (self.run.sim().now() + SLICE).min(end);
            self.run.advance(until, &mut self.told);
            for (_, _, event) in self.run.take_held_news() {
                if let Event::Received { frame } = event {
                    self.bus.send(&frame)?;
                }
            }
            self.show()?;
            let due = began + Duration::from_nanos(until.femtoseconds() / 1_000_000);
            loop {
                let left = due.saturating_duration_since(Instant::now());
                match self.bus.receive(left)? {
                    Some(frame) => self.forward(frame)?,
                    None => break,
                }
            }
        }
        Ok(())
    }

    /// What it came to; what a signal interrupted is its doing.
    fn ended(&self, served: Result<()>) -> Result<Outcome> {
        if let Some(signal) = self.bus.signal() {
            return Ok(Outcome::Channel(report(&Trouble::Stopped(signal))));
        }
        match served.map_err(anyhow::Error::downcast::<LinkError>) {
            Ok(()) => Ok(Outcome::Good),
            Err(Ok(error)) => Ok(Outcome::Channel(report(&Trouble::Link(error)))),
            Err(Err(other)) => Err(other),
        }
    }

    fn forward(&mut self, frame: Frame) -> Result<()> {
        let now = self.run.sim().now();
        self.run.sim_mut().send_at(now, self.node, frame);
        match Request::from_frame(&frame) {
            Some(Request::ConfigureBitTiming { table_selector: 0, table_index }) => {
                self.pending = RateSetting::from_index(table_index).and_then(RateSetting::bitrate);
            }
            Some(Request::ActivateBitTiming { switch_delay_ms })
                if self.follow == Follow::Activations =>
            {
                self.go_along(Span::from_ms(switch_delay_ms.into()))?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Off when the devices switch, on again in the middle of their silence.
    fn go_along(&mut self, delay: Span) -> Result<()> {
        let Some(rate) = self.pending.take() else { return Ok(()) };
        let at = self.run.sim().now() + delay;
        let mut config = self.run.sim().node(self.node).config().clone();
        let point = Permille::new(default_sample_point(rate).permille()).unwrap_or_default();
        let hertz = config.oscillator.hertz;
        config.nominal = BitTiming::find(hertz, rate.bits_per_second(), point)?;
        let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
        let sim = self.run.sim_mut();
        sim.reconfigure_at(at, self.node, off)?;
        sim.reconfigure_at(at + Span::from_fs(delay.femtoseconds() / 2), self.node, config)?;
        Ok(())
    }

    fn show(&mut self) -> Result<()> {
        let lines: String = self.told.take().iter().map(|line| format!("{line}\n")).collect();
        Ok(Outlet::Output.write(&lines, None)?)
    }
}
