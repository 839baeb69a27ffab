//! What can be said about a live bus.

use std::str::FromStr;

use canbaud::detect::scan::Policy;
use canbaud::units::{Bitrate, Micros};
use canbaud_link::After;
use clap::Args;

use super::save::Form;
use super::source::LiveSource;
use crate::args::DetectArgs;
use crate::values::{bus_rate, time};

/// How to look for the rate of a live bus.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "On a live bus")]
pub(crate) struct LiveArgs {
    /// Rates to try, or canopen, j1939, devicenet, known: 125k,250k [default: the usual twelve]
    #[arg(long, value_name = "RATES", value_delimiter = ',', conflicts_with = "sweep")]
    pub(crate) rates: Vec<RateName>,

    /// Any rate in this range: 10k..1M
    #[arg(long, value_name = "LOW..HIGH")]
    pub(crate) sweep: Option<Sweep>,

    /// Receive CAN FD, and find its data bit rate
    #[arg(long)]
    pub(crate) fd: bool,

    /// How to go from rate to rate: weighing, koppe (the first message without an error), fixed-dwell,
    /// survey
    #[arg(long, value_name = "NAME", default_value = "weighing", value_parser = policy)]
    pub(crate) policy: Policy,

    /// Listen this long, also beyond the bound: 30s, 500ms, never
    #[arg(long, value_name = "TIME")]
    pub(crate) timeout: Option<Timeout>,

    /// The longest pause between frames that has to be sat out [default: 1s]
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) pause: Option<Micros>,

    /// Leave the interface set to the found rate, listening only
    #[arg(long)]
    pub(crate) apply: bool,

    /// Print a permanent configuration: networkd, ifupdown, netplan, nm
    #[arg(long, value_name = "FORM", hide_possible_values = true)]
    pub(crate) save: Option<Form>,

    /// With --apply or --save: not listening only, but taking part in the traffic
    #[arg(long)]
    pub(crate) normal: bool,

    /// A slcan adapter that has only M1 to be silent: rely on it (most forget it, and disturb)
    #[arg(long)]
    pub(crate) trust_m1: bool,
}

impl LiveArgs {
    /// How long to listen at most.
    pub(super) fn limit(&self) -> Option<Micros> {
        match self.timeout {
            Some(Timeout::After(time)) => Some(time),
            Some(Timeout::Never) | None => None,
        }
    }

    pub(super) const fn after(&self) -> After {
        if self.normal { After::Normal } else { After::Listening }
    }

    /// Whether anything was said that only a live bus has.
    pub(crate) fn is_used(&self) -> bool {
        let Self { rates, sweep, fd, policy, timeout, pause, apply, save, normal, trust_m1 } = self;
        !rates.is_empty()
            || sweep.is_some()
            || timeout.is_some()
            || pause.is_some()
            || save.is_some()
            || *policy != Policy::default()
            || [fd, apply, normal, trust_m1].into_iter().any(|flag| *flag)
    }

    /// What does not go together with a live bus, or with this one.
    pub(super) fn refusal(&self, all: &DetectArgs, source: &LiveSource) -> Option<&'static str> {
        let slcan = matches!(source, LiveSource::Slcan { .. });
        let interface = matches!(source, LiveSource::Interface(_));
        if all.sources.len() > 1 {
            Some("a live bus is looked at alone: one source")
        } else if all.reading.is_used() || all.expected.is_some() || all.jobs.is_some() {
            Some("an option for capture files was given with a live bus")
        } else if !interface && (self.apply || self.save.is_some()) {
            Some("--apply and --save need an interface of Linux, such as can0")
        } else if self.trust_m1 && !slcan {
            Some("--trust-m1 is for slcan adapters")
        } else if self.normal && !self.apply && self.save.is_none() {
            Some("--normal needs --apply or --save")
        } else {
            None
        }
    }
}

/// A policy by its one name.
fn policy(text: &str) -> Result<Policy, String> {
    Policy::ALL.into_iter().find(|policy| policy.name() == text).ok_or_else(|| {
        let names = Policy::ALL.map(Policy::name);
        format!("no such policy; there are {}", names.join(", "))
    })
}

/// A rate, or a list with a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RateName {
    Rate(Bitrate),
    Canopen,
    J1939,
    Devicenet,
    Known,
}

impl FromStr for RateName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "canopen" => Self::Canopen,
            "j1939" => Self::J1939,
            "devicenet" => Self::Devicenet,
            "known" => Self::Known,
            _ => {
                Self::Rate(bus_rate(text).map_err(|error| {
                    format!("{error}; or one of canopen, j1939, devicenet, known")
                })?)
            }
        })
    }
}

/// Two rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sweep {
    pub(crate) low: Bitrate,
    pub(crate) high: Bitrate,
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (low, high) = text.split_once("..").ok_or("two rates are wanted, such as 10k..1M")?;
        let (low, high) = (bus_rate(low)?, bus_rate(high)?);
        if low > high {
            return Err(format!("{low} is above {high}"));
        }
        Ok(Self { low, high })
    }
}

/// When to give up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Timeout {
    After(Micros),
    Never,
}

impl FromStr for Timeout {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "never" => Ok(Self::Never),
            _ => time(text).map(Self::After).map_err(|error| format!("{error}, or never")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_ranges_are_read() {
        assert_eq!("2min".parse(), Ok(Timeout::After(Micros(120_000_000))));
        assert_eq!("never".parse(), Ok(Timeout::Never));
        assert!("5".parse::<Timeout>().is_err());
        let sweep: Sweep = "10k..1M".parse().unwrap();
        assert_eq!((sweep.low.to_string(), sweep.high.to_string()), ("10k".into(), "1M".into()));
        for wrong in ["10k", "1M..10k", "..", "a..b", "10..1000"] {
            assert!(wrong.parse::<Sweep>().is_err(), "{wrong}");
        }
    }
}
