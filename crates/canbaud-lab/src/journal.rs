//! What a device tells about itself, in words.

use canbaud::lss::{Configuration, LssState, Slave};
use canbaud::node::{Leds, NmtState, Node, Pattern, Stage};
use canbaud::units::Bitrate;

/// What was told last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Shown {
    stage: Stage,
    leds: Leds,
}

/// Lines for people; only of a device that somebody listens to.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    lines: Option<Vec<String>>,
    shown: Option<Shown>,
    listened: Option<Bitrate>,
    lss: Option<(LssState, Configuration)>,
}

const fn word(pattern: Pattern) -> &'static str {
    match pattern {
        Pattern::Off => "off",
        Pattern::On => "on",
        Pattern::Flickering => "flickering",
        Pattern::Blinking => "blinking",
        Pattern::SingleFlash => "single flash",
        Pattern::DoubleFlash => "double flash",
        Pattern::TripleFlash => "triple flash",
        Pattern::QuadrupleFlash => "quadruple flash",
    }
}

fn stage(stage: Stage) -> String {
    match stage {
        Stage::Detecting => "detects: listens, drives nothing".into(),
        Stage::Recovering => "bus-off: waits for 128 times 11 recessive bits".into(),
        Stage::TakingPart { bitrate, nmt: None } => format!("takes part at {bitrate}bit/s"),
        Stage::TakingPart { nmt: Some(NmtState::PreOperational), .. } => "pre-operational".into(),
        Stage::TakingPart { nmt: Some(NmtState::Operational), .. } => "operational".into(),
        Stage::TakingPart { nmt: Some(NmtState::Stopped), .. } => "stopped".into(),
    }
}

impl Journal {
    /// Somebody listens.
    pub(crate) fn open(&mut self) {
        self.lines = Some(Vec::new());
    }

    pub(crate) fn take(&mut self) -> Vec<String> {
        self.lines.as_mut().map(core::mem::take).unwrap_or_default()
    }

    pub(crate) fn tell(&mut self, what: impl FnOnce() -> String) {
        if let Some(lines) = &mut self.lines {
            lines.push(what());
        }
    }

    /// Power comes or goes: what was shown is gone.
    pub(crate) fn forget(&mut self) {
        (self.shown, self.listened, self.lss) = (None, None, None);
    }

    /// The controller is to listen; told once for each rate.
    pub(crate) fn listens(&mut self, rate: Bitrate) {
        if self.listened.replace(rate) != Some(rate) {
            self.tell(|| format!("listens at {rate}bit/s"));
        }
    }

    /// Stage and LEDs, where they have changed.
    pub(crate) fn look(&mut self, node: &Node) {
        let now = Shown { stage: node.stage(), leds: node.leds() };
        let before = self.shown.replace(now);
        let leds = || format!("RUN {}, ERROR {}", word(now.leds.run), word(now.leds.error));
        match before {
            Some(before) if before == now => {}
            Some(before) if before.stage == now.stage => self.tell(|| format!("LEDs: {}", leds())),
            _ => {
                if !matches!(now.stage, Stage::Detecting) {
                    self.listened = None;
                }
                self.tell(|| format!("{} ({})", stage(now.stage), leds()));
            }
        }
    }

    /// State and pending configuration of LSS, where they have changed.
    pub(crate) fn look_at_lss(&mut self, slave: &Slave) {
        let now = (slave.state(), slave.pending());
        let Some(before) = self.lss.replace(now) else { return };
        if before.0 != now.0 {
            let state = match now.0 {
                LssState::Waiting => "waiting",
                LssState::Configuration => "configuration",
            };
            self.tell(|| format!("LSS: {state}"));
        }
        if before.1.rate != now.1.rate {
            self.tell(|| format!("LSS: bit rate {} is pending", now.1.rate));
        }
        if before.1.node_id != now.1.node_id {
            self.tell(|| format!("LSS: node-ID {} is pending", now.1.node_id));
        }
    }
}
