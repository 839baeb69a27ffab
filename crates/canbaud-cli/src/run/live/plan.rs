//! From what the user said to what the scan is told.

use canbaud::detect::scan::{
    Candidate, Candidates, Capabilities, End, FdSupport, RateChoice, Settings, TooMany,
};
use canbaud::rates;
use canbaud::units::Bitrate;

use super::LiveArgs;
use super::args::RateName;

/// Rates that a scan takes at most: a sweep from 5 kbit/s to 1 Mbit/s has 110.
pub(super) const ROOM: usize = 128;

/// The list of candidates of the command.
pub(super) type List = Candidates<ROOM>;

/// What is usual, the most common first.
const USUAL: [u32; 12] = [
    500_000, 250_000, 125_000, 1_000_000, 100_000, 50_000, 20_000, 10_000, 800_000, 83_333, 33_333,
    666_667,
];

/// The data bit rate that is tried first with every nominal one.
const DATA: Bitrate = Bitrate::new(2_000_000).unwrap();

/// What to try, and how.
#[derive(Debug)]
pub(super) struct Plan {
    /// Nominal rates that the adapter can be set to.
    pub(super) candidates: List,
    /// Nominal rates that it cannot be set to.
    pub(super) left_out: Vec<Bitrate>,
    pub(super) settings: Settings,
    /// Data bit rates for the second stage.
    pub(super) data: Vec<Bitrate>,
    /// Behind a sweep, the rate is measured again.
    pub(super) recentre: bool,
}

impl Plan {
    pub(super) fn new(args: &LiveArgs, can: &Capabilities<'_>) -> Result<Self, String> {
        let list = list(args, &can.rates).map_err(|error| error.to_string())?;
        if args.fd && can.fd == FdSupport::Classic {
            return Err("--fd was given, but this adapter receives classic frames only".to_owned());
        }
        let within = list.within(&can.rates);
        let left_out = list.as_slice().iter().filter(|one| !within.as_slice().contains(one));
        let left_out = left_out.map(|candidate| candidate.nominal).collect();
        let mut settings = Settings { policy: args.policy, ..Settings::default() };
        settings.pause = args.pause.unwrap_or(settings.pause);
        if args.timeout.is_some() {
            settings.end = End::Never;
        }
        let data = match args.fd {
            true => rates::data().iter().map(rates::KnownRate::bitrate).collect(),
            false => Vec::new(),
        };
        let candidates = match args.fd {
            true => within.with_data(&[DATA]).map_err(|error| error.to_string())?,
            false => within,
        };
        let recentre = args.sweep.is_some() && matches!(can.rates, RateChoice::Between(..));
        Ok(Self { candidates, left_out, settings, data, recentre })
    }

    /// What to try behind a sweep that caught something at `caught`: the rates that the wide bit
    /// timing may have caught.
    pub(super) fn around(caught: Bitrate) -> List {
        let caught = u64::from(caught.bits_per_second());
        let mut list = List::new();
        let near = rates::nominal().iter().map(rates::KnownRate::bitrate).filter(|rate| {
            // One step of the sweep to either side.
            u64::from(rate.bits_per_second()).abs_diff(caught) * 20 <= caught
        });
        for rate in near {
            // A handful.
            let _ = list.push(Candidate::classic(rate));
        }
        list
    }

    /// All data bit rates at each of these nominal ones.
    pub(super) fn with_data(&self, nominals: &[Bitrate]) -> List {
        let mut list = List::new();
        for nominal in nominals {
            for data in self.data.iter().filter(|data| *data >= nominal) {
                // Thirteen for each of four at most.
                let _ = list.push(Candidate { data: Some(*data), ..Candidate::classic(*nominal) });
            }
        }
        list
    }
}

fn list(args: &LiveArgs, choice: &RateChoice<'_>) -> Result<List, TooMany> {
    if let (Some(sweep), RateChoice::Only(rates)) = (args.sweep, choice) {
        // There are no others to sweep over.
        let within = rates.iter().filter(|rate| (sweep.low..=sweep.high).contains(rate));
        return List::of_rates(&within.copied().collect::<Vec<_>>());
    }
    if let Some(sweep) = args.sweep {
        return List::sweep(sweep.low, sweep.high);
    }
    if args.rates.is_empty() {
        let usual: Vec<Bitrate> = USUAL.into_iter().filter_map(Bitrate::new).collect();
        return List::of_rates(&usual);
    }
    let mut list = List::new();
    for name in &args.rates {
        let named = match name {
            RateName::Rate(rate) => List::of_rates(&[*rate])?,
            RateName::Canopen => List::canopen()?,
            RateName::J1939 => List::j1939()?,
            RateName::Devicenet => List::devicenet()?,
            RateName::Known => List::known()?,
        };
        for candidate in named.as_slice() {
            list.push(*candidate)?;
        }
    }
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_rates_are_those_of_the_guide() {
        let usual: Vec<String> =
            USUAL.into_iter().filter_map(Bitrate::new).map(|rate| rate.to_string()).collect();
        let row = format!("| (none) | {} |", usual.join(", "));
        assert!(include_str!("../../../../../docs/live.md").contains(&row), "{row}");
        assert_eq!(usual.len(), USUAL.len());
    }
}
