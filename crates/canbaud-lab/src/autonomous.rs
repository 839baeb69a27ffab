//! [`Device`] as the software of a node in a scenario.

use canbaud::detect::scan::Evidence;
use canbaud::node::{NmtState, Silence, Stage, Startup};
use canbaud::units::Micros;
use canbaud::wire::Level;
use canbaud_sim::software::{
    AutonomousPlan, Listening, Software, Stage as SimStage, Standing, StartUp, Supplier,
};
use canbaud_sim::{ClockError, Event, NodeConfig, NodeId, Simulation, Span, Time};

use crate::config::{DeviceConfig, Listener};
use crate::device::Device;
use crate::time::FS_PER_US;

/// Supplies the autonomous nodes of scenarios with [`canbaud::node::Node`].
///
/// ```
/// use canbaud_lab::Autonomous;
/// use canbaud_sim::Blind;
/// use canbaud_sim::scenario::{Run, Scenario};
/// let text = "title = 'two'\nduration = '300ms'\n\
///     [[node]]\nname = 'manager'\nbitrate = '250k'\n\
///     autonomous = { node_id = 1, start_up = 'mini-master', sync = '10ms' }\n\
///     [[node]]\nname = 'device'\nautonomous = { node_id = 2, timer = '8M' }\n";
/// let scenario = Scenario::parse("two.toml", text).unwrap();
/// let mut run = Run::with(&scenario, 1, &Autonomous).unwrap();
/// run.finish(&mut Blind);
/// assert_eq!(run.statistics().nodes[1].found_bitrate, Some(250_000));
/// assert_eq!(run.statistics().nodes[1].stage.as_deref(), Some("operational"));
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct Autonomous;

impl Supplier for Autonomous {
    fn software(
        &self,
        plan: &AutonomousPlan,
        node: NodeId,
        config: &NodeConfig,
        seed: u64,
    ) -> Result<Box<dyn Software>, ClockError> {
        let mut device = Device::at(device(plan, config, seed), node, config.clone())?;
        if let Some(rate) = plan.remembers {
            let bytes = rate.bits_per_second().to_le_bytes();
            // A memory that has power takes it.
            let _ = canbaud::node::save(device.memory(), &bytes);
        }
        device.journal().open();
        Ok(Box::new(device))
    }
}

const fn micros(span: Span) -> Micros {
    Micros(span.femtoseconds() / FS_PER_US)
}

fn device(plan: &AutonomousPlan, config: &NodeConfig, seed: u64) -> DeviceConfig {
    let listener = match plan.listening {
        Listening::Errors => Listener::Monitoring(Evidence::Errors),
        Listening::Counter => Listener::Monitoring(Evidence::Counter),
        Listening::FramesOnly => Listener::Monitoring(Evidence::FramesOnly),
        Listening::Gate => Listener::Gate,
        Listening::None => Listener::None,
    };
    let mut device = DeviceConfig::automatic(plan.node_id.get());
    device.name.clone_from(&config.name);
    device.clock_hz = config.oscillator.hertz;
    device.ppb = config.oscillator.ppb;
    device.reconfiguration = plan.reconfiguration;
    let settings = &mut device.settings;
    settings.rate = plan.rate;
    settings.startup = match plan.start_up {
        StartUp::Slave => Startup::Slave,
        StartUp::MiniMaster => Startup::MiniMaster,
    };
    if let Some(silence) = &plan.silence {
        settings.silence = Silence::Break {
            default: silence.default,
            after: micros(silence.after),
            spread: micros(silence.spread),
            hold: micros(silence.hold),
        };
    }
    settings.heartbeat = plan.heartbeat.map(micros);
    settings.seed = seed;
    (device.pdo, device.sync) = (plan.pdo, plan.sync);
    if let Some(lss) = &plan.lss {
        device.lss = Some(lss.address);
        device.lss_processing = lss.processing;
        device.lss_storage = lss.storage;
        device.lss_automatic = lss.automatic;
    }
    device.with(listener, plan.timer_hz)
}

impl Software for Device {
    fn power_on(&mut self, sim: &mut Simulation) {
        Self::power_on(self, sim);
    }

    fn power_off(&mut self, sim: &mut Simulation) {
        Self::power_off(self, sim);
    }

    fn notice(&mut self, at: Time, event: &Event, sim: &mut Simulation) {
        Self::notice(self, at, event, sim);
    }

    fn follows_edges(&self) -> bool {
        Self::follows_edges(self)
    }

    fn edge(&mut self, at: Time, level: Level) {
        Self::edge(self, at, level);
    }

    fn deadline(&self) -> Time {
        self.wake()
    }

    fn wake(&mut self, sim: &mut Simulation) {
        self.turn(sim);
    }

    fn take_told(&mut self) -> Vec<String> {
        self.journal().take()
    }

    fn standing(&self) -> Standing {
        let stage = self.software().map(|node| node.stage());
        let joined = self.joined().last();
        let takes_part = joined.filter(|_| !self.must_be_silent());
        Standing {
            stage: match stage {
                None => SimStage::Off,
                Some(Stage::Detecting) => SimStage::Detecting,
                Some(Stage::Recovering) => SimStage::Recovering,
                Some(Stage::TakingPart { nmt, .. }) => match nmt {
                    None => SimStage::Initialising,
                    Some(NmtState::PreOperational) => SimStage::PreOperational,
                    Some(NmtState::Operational) => SimStage::Operational,
                    Some(NmtState::Stopped) => SimStage::Stopped,
                },
            },
            takes_part: takes_part.map(|joined| (joined.bitrate, joined.at)),
        }
    }
}
