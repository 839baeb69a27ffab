//! The scan, and what its outcome means.

use std::time::Duration;

use canbaud::detect::scan::{
    Activity, Driver, FdSeen, FdSupport, Found, Ground, Misfit, Outcome as Said, Policy, Progress,
    Scan, Settings, Standing,
};
use canbaud::rates;
use canbaud::units::{Bitrate, Micros};
use canbaud_link::{Clock, LinkError, Listener};

use super::plan::{List, Plan, ROOM};
use super::stop::Stop;
use super::watch::Watch;
use crate::output::{bitrate, count};
use crate::report::{Caveat, LiveRate, LiveReport, Outcome};

/// Signals are looked for this often at least.
const SLICE: Duration = Duration::from_millis(50);

/// How a run ended.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one")]
pub(super) enum Ended {
    Judged(LiveReport),
    /// By a signal.
    Stopped(u8),
    /// Nobody reads the events any more.
    Unread,
}

/// What every stage needs.
pub(super) struct Finding<'a> {
    pub(super) clock: Clock,
    pub(super) stop: &'a Stop,
    /// When to give up at the latest.
    pub(super) limit: Option<Micros>,
}

/// How one scan ended.
enum Stage {
    Said(Said),
    TimedOut,
    Stopped(u8),
    Unread,
}

/// One scan or several, with what they tried.
struct Stages {
    stage: Stage,
    tried: Vec<Standing>,
    bound: Option<Micros>,
    visits: u32,
    elapsed: Micros,
    /// The rate is known to about 2 % only.
    roughly: bool,
}

impl Finding<'_> {
    /// Scans in as many stages as needed.
    pub(super) fn run(
        &self,
        listener: &mut dyn Listener,
        plan: &Plan,
        watch: &mut Watch,
    ) -> Result<Ended, LinkError> {
        watch.start(&listener.describe(), plan, &listener.remarks());
        let mut all = self.stage(listener, &plan.candidates, plan.settings, watch)?;
        if plan.recentre {
            self.recentre(listener, plan, watch, &mut all)?;
        }
        let nominals = all.without_data_rate();
        if !plan.data.is_empty() && !nominals.is_empty() {
            let next = self.stage(listener, &plan.with_data(&nominals), plan.settings, watch)?;
            all.then(next);
        }
        Ok(match all.stage {
            Stage::Stopped(signal) => Ended::Stopped(signal),
            Stage::Unread => Ended::Unread,
            Stage::Said(_) | Stage::TimedOut => {
                Ended::Judged(self.report(listener, plan, &all, watch))
            }
        })
    }

    /// Behind a sweep: the known rates around what was caught; if it is none of them, every rate
    /// around it, the middle of which is the answer.
    fn recentre(
        &self,
        listener: &mut dyn Listener,
        plan: &Plan,
        watch: &mut Watch,
        all: &mut Stages,
    ) -> Result<(), LinkError> {
        let Stage::Said(Said::Found(caught)) = all.stage else { return Ok(()) };
        let known = Plan::around(caught.nominal());
        if !known.as_slice().is_empty() {
            let next = self.stage(listener, &known, plan.settings, watch)?;
            let nearer = next.ends();
            all.then(next);
            if nearer {
                return Ok(());
            }
        }
        // A receiver with the widest bit timing caught it: no more is known yet.
        all.roughly = true;
        // Seventeen of a hundred and twenty-eight.
        let Ok(around) = List::around(&caught) else { return Ok(()) };
        let settings = Settings { policy: Policy::Survey, ..plan.settings };
        let next = self.stage(listener, &around, settings, watch)?;
        all.then(next);
        Ok(())
    }

    fn stage(
        &self,
        listener: &mut dyn Listener,
        candidates: &List,
        settings: Settings,
        watch: &mut Watch,
    ) -> Result<Stages, LinkError> {
        let clock = self.clock;
        let scan: Scan<ROOM> = Scan::new(candidates, &listener.capabilities(), settings);
        let bound = scan.bound();
        let mut driver = Driver::new(listener, scan, |_: &&mut dyn Listener| clock.now());
        let stage = loop {
            if let Some(signal) = self.stop.signal() {
                break Stage::Stopped(signal);
            }
            let progress = driver.turn()?;
            let now = clock.now();
            watch.look(driver.scan(), now);
            if watch.is_unread() {
                break Stage::Unread;
            }
            let until = match progress {
                Progress::Done(outcome) => break Stage::Said(outcome),
                Progress::Listening(until) => until,
            };
            if self.limit.is_some_and(|limit| now >= limit) {
                break Stage::TimedOut;
            }
            let nearest = [until, self.limit].into_iter().flatten().min();
            let left = nearest.map_or(SLICE, |at| Duration::from_micros((at - now).0));
            driver.controller_mut().wait(left.min(SLICE))?;
        };
        let now = clock.now();
        let status = driver.scan().status(now);
        let tried = driver.scan().standings().filter(|one| one.visits > 0 || one.refused);
        let tried = match status.activity {
            Activity::Listening(_) | Activity::Confirming(_) => {
                tried.map(|one| watch.at_the_end(one, now)).collect()
            }
            Activity::Waiting | Activity::Switching(_) | Activity::Done => tried.collect(),
        };
        Ok(Stages {
            stage,
            tried,
            bound,
            visits: status.visits,
            elapsed: status.elapsed,
            roughly: false,
        })
    }

    fn report(
        &self,
        listener: &dyn Listener,
        plan: &Plan,
        all: &Stages,
        watch: &Watch,
    ) -> LiveReport {
        let mut report = LiveReport {
            source: watch.source().to_owned(),
            adapter: listener.describe(),
            outcome: Outcome::Undecided,
            need: None,
            found: None,
            elapsed: all.elapsed,
            bound: all.bound,
            visits: all.visits,
            tried: all.tried.clone(),
            caveats: Vec::new(),
        };
        match &all.stage {
            Stage::Said(Said::Found(found)) => {
                judge_found(&mut report, found);
                if all.roughly {
                    let text = "This is no known rate: it is right to a few percent, and nothing takes part in the traffic at it.";
                    caveat(&mut report, "roughly", text);
                }
            }
            Stage::Said(Said::Silent) => {
                report.outcome = Outcome::NoTraffic;
                report.need = Some("nothing was heard at any of the rates".to_owned());
            }
            Stage::Said(Said::NoCandidateFits(misfit)) => judge_misfit(&mut report, *misfit),
            Stage::Said(Said::StillOpen) => {
                report.need = Some(still_open(&all.tried));
                caveat(
                    &mut report,
                    "cannot_tell",
                    "--timeout 5min listens longer; --pause 10s stays longer at each rate.",
                );
            }
            Stage::Said(Said::Refused) => {
                report.need = Some("the adapter can be set to none of the rates".to_owned());
            }
            Stage::TimedOut | Stage::Stopped(_) | Stage::Unread => {
                report.need = Some("no verdict in the time that was given".to_owned());
            }
        }
        if plan.data.is_empty() && listener.capabilities().fd == FdSupport::Fd {
            match &report.found {
                None => caveat(&mut report, "no_fd", "CAN FD was not tried: --fd does."),
                Some(found) if found.errors > 0 => caveat(
                    &mut report,
                    "no_fd",
                    "CAN FD was not tried, and its frames look like errors here: --fd does.",
                ),
                Some(_) => {}
            }
        }
        if report.found.is_none() && !plan.left_out.is_empty() {
            let rates: Vec<String> =
                plan.left_out.iter().map(|rate| bitrate(rate.bits_per_second())).collect();
            let text = format!("This adapter cannot be set to {}.", rates.join(", "));
            report.caveats.push(Caveat { code: "rates_left_out", text });
        }
        report
    }
}

/// Nominal rates that are tried with every data bit rate where none was found.
const LIKELIEST: usize = 4;

impl Stages {
    /// Nominal rates at which frames may have been lost for another data bit rate.
    fn without_data_rate(&self) -> Vec<Bitrate> {
        match &self.stage {
            Stage::Said(Said::Found(found)) if found.fd != FdSeen::Switched && found.errors > 0 => {
                vec![found.nominal()]
            }
            Stage::Said(Said::NoCandidateFits(_)) => {
                let mut tried = self.tried.clone();
                tried.sort_by_key(|one| std::cmp::Reverse(one.weight));
                tried.iter().take(LIKELIEST).map(|one| one.candidate.nominal).collect()
            }
            Stage::Said(_) | Stage::TimedOut | Stage::Stopped(_) | Stage::Unread => Vec::new(),
        }
    }

    /// Whether nothing that follows says more.
    const fn ends(&self) -> bool {
        matches!(self.stage, Stage::Said(Said::Found(_)) | Stage::Stopped(_) | Stage::Unread)
    }

    /// Adds the next stage; the rate stands where that finds none.
    fn then(&mut self, next: Self) {
        let ends = next.ends();
        self.tried.extend(next.tried);
        self.visits = self.visits.saturating_add(next.visits);
        self.elapsed = self.elapsed + next.elapsed;
        self.bound = self.bound.zip(next.bound).map(|(first, second)| first + second);
        if ends {
            self.stage = next.stage;
        }
    }
}

fn caveat(report: &mut LiveReport, code: &'static str, text: &str) {
    report.caveats.push(Caveat { code, text: text.to_owned() });
}

fn judge_found(report: &mut LiveReport, found: &Found) {
    let nominal = found.nominal();
    let millibits = u64::from(nominal.bits_per_second()) * 1000;
    // Rates that registers make are within half a percent of what was asked for.
    let known = rates::nearest(rates::nominal(), millibits, 5_000_000);
    report.outcome = Outcome::Found;
    report.found = Some(LiveRate {
        nominal: nominal.bits_per_second(),
        data: found.data().map(Bitrate::bits_per_second),
        known_as: known.map(rates::KnownRate::users),
        frames: found.frames,
        distinct: found.distinct,
        errors: found.errors,
        acknowledgement: found.acknowledgement,
        fd: found.fd,
    });
    match found.fd {
        FdSeen::Suspected => caveat(
            report,
            "perhaps_fd",
            "There are frames that look like CAN FD, which this adapter does not receive; with an \
             adapter that does, --fd tells more. Nothing takes part in the traffic without it.",
        ),
        FdSeen::Switched | FdSeen::NeverSwitched if found.data().is_none() => caveat(
            report,
            "data_rate_unknown",
            "There are CAN FD frames, and their data bit rate is not known; --fd finds it if they \
             switch to it. A node without it would destroy them, so nothing takes part in the \
             traffic.",
        ),
        FdSeen::No | FdSeen::Switched | FdSeen::NeverSwitched => {}
    }
}

/// An adapter that tells frames only has confirmed none.
fn still_open(tried: &[Standing]) -> String {
    match tried.iter().filter(|one| one.frames > 0).max_by_key(|one| one.weight) {
        Some(one) => format!(
            "{} could be read at {}, too little to be sure of it",
            count(u64::from(one.frames), "frame", "frames"),
            bitrate(one.candidate.nominal.bits_per_second())
        ),
        None => "nothing was heard, and this adapter cannot tell a wrong rate from a silent bus"
            .to_owned(),
    }
}

fn judge_misfit(report: &mut LiveReport, misfit: Misfit) {
    let need = match misfit.ground {
        Ground::Refuted => "there is traffic, at none of the rates that were tried",
        Ground::OutOfTime => "there is traffic, and none of the rates was confirmed in this time",
    };
    report.need = Some(need.to_owned());
    match (misfit.perhaps_fd, misfit.ground) {
        (Some(candidate), _) => {
            let rate = bitrate(candidate.nominal.bits_per_second());
            let text = format!(
                "At {rate} every frame was read past its identifier and none to its end: perhaps \
                 CAN FD; with an adapter that receives it, --fd tells."
            );
            report.caveats.push(Caveat { code: "perhaps_fd", text });
        }
        (None, Ground::OutOfTime) => caveat(
            report,
            "rare_frames",
            "Frames may be rare, or mostly destroyed: --timeout 5min listens longer; --sweep 10k..1M \
             tries every rate.",
        ),
        (None, Ground::Refuted) => caveat(
            report,
            "other_rates",
            "--sweep 10k..1M tries every rate; wrong wiring, a missing termination or noise look \
             the same, and so do CAN FD frames to an adapter or a scan for classic ones.",
        ),
    }
}
