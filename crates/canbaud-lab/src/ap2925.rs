//! The procedure of Infineon's AP2925 with its timer: measure, look up, take part, verify.
//!
//! As it is described, for comparison: the controller has no analysing mode, so what verifies the
//! rate is an active node, and a wrong entry of the table costs the bus error frames.

use canbaud::detect::MinimumPulse;
use canbaud::timing::controllers::c167;
use canbaud::timing::tables::AP2925;
use canbaud::wire::{Frame, FrameKind, Id, Level};
use canbaud_sim::around::PollingLoop;
use canbaud_sim::{
    BitTiming, ClockError, Event, Mode, NodeConfig, NodeId, Observer, Oscillator, Simulation, Span,
    Time,
};

/// CPU clocks of one turn of the wait loop of measure.c.
const TURN: u64 = 4;
/// CPU clocks from the end of a pulse to the next poll.
const STORE: u64 = 20;

/// Whose registers to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ap2925Table {
    /// The table as it is printed.
    Printed,
    /// The program of the document.
    Code,
    /// The table with its misprints put right.
    Corrected,
}

/// Where the procedure is \[AP2925, figure 3\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// Takes 100 dominant levels, controller off.
    Measure,
    /// The controller is on; waits for RXOK or an error code.
    Verify { bitrate: u32 },
    /// Takes part.
    Run { bitrate: u32 },
}

/// A C167 with the program of AP2925.
#[derive(Debug)]
pub struct Ap2925 {
    id: NodeId,
    cpu_mhz: u16,
    table: Ap2925Table,
    polling: PollingLoop,
    minimum: MinimumPulse,
    step: Step,
    /// Shortest level of each measurement.
    measured: Vec<u32>,
    /// Errors that it noticed, and flagged, while it verified.
    errors: u32,
    found_at: Option<Time>,
}

impl Ap2925 {
    /// Puts it on the bus, controller off. `cpu_mhz` is one of 24, 20, 16, 10, 8 and 5.
    ///
    /// # Errors
    /// [`ClockError`] if there is no such clock.
    pub fn new(
        sim: &mut Simulation,
        cpu_mhz: u16,
        ppb: i64,
        table: Ap2925Table,
        phase: u64,
    ) -> Result<Self, ClockError> {
        let hertz = u64::from(cpu_mhz) * 1_000_000;
        let config = NodeConfig {
            mode: Mode::Disabled,
            oscillator: Oscillator { hertz, ppb },
            ..plain("ap2925")
        };
        let id = sim.add_node(config)?;
        sim.watch(id);
        Ok(Self {
            id,
            cpu_mhz,
            table,
            polling: PollingLoop::new(hertz, ppb, TURN, STORE, phase)?,
            minimum: MinimumPulse::new(),
            step: Step::Measure,
            measured: Vec::new(),
            errors: 0,
            found_at: None,
        })
    }

    /// Its node.
    #[must_use]
    pub const fn id(&self) -> NodeId {
        self.id
    }

    /// Shortest level of each measurement, in timer ticks.
    #[must_use]
    pub fn measured(&self) -> &[u32] {
        &self.measured
    }

    /// Errors that it noticed, and flagged, while it verified.
    #[must_use]
    pub const fn errors(&self) -> u32 {
        self.errors
    }

    /// When it was sure, and of which rate (by its table) in bit/s.
    #[must_use]
    pub const fn found(&self) -> Option<(Time, u32)> {
        match (self.step, self.found_at) {
            (Step::Run { bitrate }, Some(at)) => Some((at, bitrate)),
            _ => None,
        }
    }

    /// The register for a count of ticks, with the rate that the table says.
    fn look_up(&self, ticks: u32) -> Option<(u16, u32)> {
        let row = AP2925.iter().filter(|row| row.cpu_mhz == self.cpu_mhz).find(|row| {
            let [low, _, high] = match self.table {
                Ap2925Table::Printed => row.printed_ticks,
                Ap2925Table::Code | Ap2925Table::Corrected => row.right_ticks(),
            };
            (u32::from(low)..=u32::from(high)).contains(&ticks)
        })?;
        let register = match self.table {
            Ap2925Table::Printed => row.printed_btr,
            Ap2925Table::Code => row.code_btr,
            Ap2925Table::Corrected => row.btr(),
        };
        Some((register, u32::from(row.kbits_per_second) * 1000))
    }

    /// Runs the bus and the procedure up to `until`.
    pub fn run<O: Observer>(&mut self, sim: &mut Simulation, until: Time, observer: &mut O) {
        let mut edges = Edges::default();
        while sim.now() < until {
            let next = (sim.now() + Span::from_us(200)).min(until);
            sim.run(next, &mut (&mut edges, &mut *observer));
            for (at, level) in edges.0.drain(..) {
                self.edge(at, level, sim);
            }
            for (at, node, event) in sim.take_news() {
                if node == self.id {
                    self.notice(at, &event, sim);
                }
            }
        }
    }

    fn edge(&mut self, at: Time, level: Level, sim: &mut Simulation) {
        let pulse = self.polling.edge(at, level);
        if self.step != Step::Measure {
            return;
        }
        if let Some(pulse) = pulse {
            self.minimum.push(u32::try_from(pulse.ticks).unwrap_or(u32::MAX));
        }
        let Some(shortest) = self.minimum.shortest() else { return };
        self.minimum = MinimumPulse::new();
        self.measured.push(shortest);
        if let Some((register, bitrate)) = self.look_up(shortest)
            && let Some(timing) = timing(register)
        {
            self.step = Step::Verify { bitrate };
            self.set_up(sim, Mode::Normal, Some(timing));
        }
    }

    fn notice(&mut self, at: Time, event: &Event, sim: &mut Simulation) {
        let Step::Verify { bitrate } = self.step else { return };
        match event {
            // LEC is not 0: measure again.
            Event::Error { .. } => {
                self.errors += 1;
                self.step = Step::Measure;
                self.set_up(sim, Mode::Disabled, None);
            }
            // RXOK: send message object 2, so that others have an acknowledge to measure.
            Event::Received { .. } => {
                self.step = Step::Run { bitrate };
                self.found_at = Some(at);
                if let Ok(frame) = Frame::new(Id::Base(2), FrameKind::Data, 8, &[0; 8]) {
                    sim.send_at(sim.now(), self.id, frame);
                }
            }
            _ => {}
        }
    }

    fn set_up(&self, sim: &mut Simulation, mode: Mode, timing: Option<BitTiming>) {
        let mut config = sim.node(self.id).config().clone();
        config.mode = mode;
        config.nominal = timing.unwrap_or(config.nominal);
        // The oscillator was checked when the device was made.
        let _ = sim.reconfigure_at(sim.now(), self.id, config);
    }
}

/// The bit timing of a register; the C167's CAN runs at half the CPU clock.
fn timing(register: u16) -> Option<BitTiming> {
    let unpacked = c167::CONTROLLER.unpack([(&c167::BTR, u32::from(register))]).ok()?;
    let nominal = unpacked.nominal;
    BitTiming::new(
        2 * u32::from(nominal.prescaler),
        nominal.prop_seg.into(),
        nominal.phase_seg1.into(),
        nominal.phase_seg2.into(),
        nominal.sjw.into(),
    )
    .ok()
}

fn plain(name: &str) -> NodeConfig {
    // 80 MHz makes 125 kbit/s.
    NodeConfig::at(name, 125_000).unwrap_or_else(|_| unreachable!())
}

/// Edges at the star point.
#[derive(Debug, Default)]
struct Edges(Vec<(Time, Level)>);

impl Observer for Edges {
    fn bus(&mut self, at: Time, level: Level) {
        self.0.push((at, level));
    }
}
