//! Rows D1 to D3: the DS80C390 guide.

use canbaud::fault::{ErrorConfinement, FlagCause, Occurrence, Role, State};
use canbaud::timing::tables::{DS80C390, Ds80c390Misprint};
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::{
    ErrorKind, Event, FaultState, NodeConfig, NodeId, Observer, Rule, Sample, Sampling, Time,
};

use super::finding::{Finding, cells};

/// Follows every node with [`ErrorConfinement`], and compares after each step.
#[derive(Debug, Default)]
struct Follower {
    nodes: Vec<ErrorConfinement>,
    roles: Vec<Role>,
    counted: u64,
    occurrences: u64,
    recoveries: u64,
    highest: (u16, u16),
    differences: Vec<String>,
}

impl Follower {
    fn with(nodes: usize) -> Self {
        Self {
            nodes: vec![ErrorConfinement::new(); nodes],
            roles: vec![Role::Receiver; nodes],
            ..Self::default()
        }
    }

    fn require(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds && self.differences.len() < 5 {
            self.differences.push(what());
        }
    }

    fn count(&mut self, at: Time, node: usize, rule: Rule, tec: u16, rec: u16) {
        let role = self.roles[node];
        let occurrence = match rule {
            Rule::ReceiverError => Occurrence::ReceiverError,
            Rule::DominantAfterFlag => Occurrence::DominantAfterFlag,
            Rule::TransmitterError => Occurrence::TransmitterError(FlagCause::Other),
            Rule::TransmitterFlagError => Occurrence::FlagBitError(Role::Transmitter),
            Rule::ReceiverFlagError => Occurrence::FlagBitError(Role::Receiver),
            Rule::DominantRun => Occurrence::DominantRun(role),
            Rule::Transmitted => Occurrence::Transmitted,
            Rule::Received => Occurrence::Received,
        };
        self.nodes[node].count(occurrence);
        let ours = &self.nodes[node];
        let (state, counters) = (ours.state(), (ours.tec(), ours.rec()));
        self.counted += 1;
        self.highest = (self.highest.0.max(tec), self.highest.1.max(rec));
        // At bus-off the counters are not defined \[DS80C390\].
        let same = state == State::BusOff || counters == (tec, rec);
        self.require(same, || format!("{at} node {node} {rule:?}: {counters:?}, bus {tec} {rec}"));
    }
}

impl Observer for Follower {
    const SAMPLING: Sampling = Sampling::InTime;

    fn sample(&mut self, _: Time, node: NodeId, sample: &Sample) {
        self.nodes[node.0].bit(sample.level);
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        let place = node.0;
        match event {
            Event::Counted { rule, tec, rec } => self.count(at, place, *rule, *tec, *rec),
            Event::Error { role, kind, .. } => {
                self.roles[place] = match role {
                    canbaud_sim::Role::Transmitter => Role::Transmitter,
                    canbaud_sim::Role::Receiver => Role::Receiver,
                };
                // Error passive and alone: no count follows.
                if (*kind, self.nodes[place].state()) == (ErrorKind::Ack, State::ErrorPassive) {
                    let cause = Occurrence::TransmitterError(FlagCause::NobodyThere);
                    self.nodes[place].count(cause);
                }
            }
            Event::TransmissionStarted { .. } => self.roles[place] = Role::Transmitter,
            Event::ArbitrationLost { .. } | Event::Received { .. } => {
                self.roles[place] = Role::Receiver;
            }
            Event::RecoverySequence(number) => {
                self.occurrences += 1;
                let ours = self.nodes[place].recovery().map_or(128, |r| r.occurrences());
                self.require(ours == *number, || format!("{at} node {place}: {ours}, {number}"));
            }
            Event::Fault(state) => {
                let want = match state {
                    FaultState::ErrorActive => State::ErrorActive,
                    FaultState::ErrorPassive => State::ErrorPassive,
                    FaultState::BusOff => State::BusOff,
                };
                self.recoveries += u64::from(want == State::BusOff);
                let ours = self.nodes[place].state();
                self.require(ours == want, || format!("{at} node {place}: {ours:?}, {want:?}"));
            }
            _ => {}
        }
    }

    fn reconfigured(&mut self, _: Time, node: NodeId, _: &NodeConfig) {
        self.nodes[node.0] = ErrorConfinement::new();
    }
}

/// Scenarios full of errors.
const SCENARIOS: [(&str, &str); 5] = [
    ("bus-off-and-back", include_str!("../../../canbaud-sim/scenarios/bus-off-and-back.toml")),
    (
        "hot-plug-wrong-rate",
        include_str!("../../../canbaud-sim/scenarios/hot-plug-wrong-rate.toml"),
    ),
    ("koppe-dead-lock", include_str!("../../../canbaud-sim/scenarios/koppe-dead-lock.toml")),
    ("lone-talker", include_str!("../../../canbaud-sim/scenarios/lone-talker.toml")),
    (
        "error-frames-at-the-worst-moment",
        include_str!("../../../canbaud-sim/scenarios/error-frames-at-the-worst-moment.toml"),
    ),
];

/// Runs the scenarios with several seeds.
fn follow(finding: &mut Finding) -> Follower {
    let mut total = Follower::default();
    for (name, text) in SCENARIOS {
        for seed in 0..3 {
            let run = Scenario::parse(name, text).ok().and_then(|s| Run::new(&s, seed).ok());
            let Some(mut run) = finding.need(run, name) else { continue };
            let mut follower = Follower::with(run.sim().nodes().len());
            run.finish(&mut follower);
            for difference in &follower.differences {
                finding.require(false, format!("{name}: {difference}"));
            }
            total.counted += follower.counted;
            total.occurrences += follower.occurrences;
            total.recoveries += follower.recoveries;
            total.highest =
                (total.highest.0.max(follower.highest.0), total.highest.1.max(follower.highest.1));
        }
    }
    total
}

pub(super) fn d1() -> Finding {
    let mut finding = Finding::default();
    let total = follow(&mut finding);
    finding.require(total.counted > 1000, format!("{} counts", total.counted));
    finding.line(format!("`fault::ErrorConfinement` beside the simulator's own counters in {} scenarios, three seeds each: {} counts by rules 1 to 8 and every change of state alike; highest TEC {}, highest REC {} (128 is the limit; the last step may be one of 8).", SCENARIOS.len(), total.counted, total.highest.0, total.highest.1));
    let mut receiver = ErrorConfinement::new();
    for _ in 0..1000 {
        receiver.count(Occurrence::ReceiverError);
    }
    let stays = receiver.rec();
    receiver.count(Occurrence::Received);
    finding.require((stays, receiver.rec()) == (128, 119), "REC");
    finding.line(format!(
        "After 1000 receive errors REC is {stays}, after the next good reception {}.",
        receiver.rec()
    ));
    finding
}

pub(super) fn d2() -> Finding {
    let mut finding = Finding::default();
    let total = follow(&mut finding);
    finding.require(total.recoveries > 0 && total.occurrences >= 128, "nobody was bus-off");
    finding.line(format!("The same runs: {} times bus-off, {} occurrences of 11 recessive bits counted alike bit by bit, every end of bus-off at the same bit.", total.recoveries, total.occurrences));
    finding.line("canbaud's node listens meanwhile at the same bit timing, counts in software what is certainly recessive (1408 bits and one frame on an idle bus), and takes part again only then: row K3, bus-off.");
    finding
}

pub(super) fn d3() -> Finding {
    let mut finding = Finding::default();
    let mut rows = vec![cells!["oscillator", "bit rate", "BRPV", "CCD", "quanta", "rate made"]];
    for row in &DS80C390 {
        let quanta = 1 + u32::from(row.tseg1) + u32::from(row.tseg2);
        let divider = u32::from(row.brpv()) * u32::from(row.ccd) * quanta;
        let made = u32::from(row.oscillator_mhz) * 1_000_000 / divider;
        let wanted = u32::from(row.kbits_per_second) * 1000;
        finding.require(made == wanted, format!("{row:?}"));
        rows.push(cells![
            format!("{} MHz", row.oscillator_mhz),
            format!("{} kbit/s", row.kbits_per_second),
            row.brpv(),
            row.ccd,
            quanta,
            made,
        ]);
        let place = format!("{} MHz, {} kbit/s", row.oscillator_mhz, row.kbits_per_second);
        match row.misprint() {
            Some(Ds80c390Misprint::Prescaler { right }) => finding.erratum(format!(
                "Page 155, {place}: BRPV {} is printed, {right} is right",
                row.printed_brpv
            )),
            Some(Ds80c390Misprint::Sjw { max }) => finding.erratum(format!(
                "Page 155, {place}: SJW {} is printed, at most {max} is allowed",
                row.printed_sjw
            )),
            None => {}
        }
    }
    finding.require(finding.errata.len() == 2, "two misprints");
    finding.table(&rows);
    finding
}
