//! What is known about a live bus; text and JSON are made from this.

use canbaud::detect::scan::{Acknowledgement, FdSeen, Standing};
use canbaud::units::Micros;

use super::{Caveat, Outcome};

/// The rate that was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LiveRate {
    /// What the controller was set to, in bit/s.
    pub(crate) nominal: u32,
    /// The data bit rate, if frames switched to it.
    pub(crate) data: Option<u32>,
    /// Who uses the nominal rate.
    pub(crate) known_as: Option<&'static str>,
    pub(crate) frames: u32,
    /// How many of them differ, counted up to 2.
    pub(crate) distinct: u8,
    /// Bursts of errors at this rate.
    pub(crate) errors: u32,
    pub(crate) acknowledgement: Acknowledgement,
    pub(crate) fd: FdSeen,
}

impl LiveRate {
    /// Whether a node that takes part at this rate would destroy frames: there is CAN FD on the
    /// bus, and its data bit rate is not known.
    pub(crate) fn lacks_data_rate(&self) -> bool {
        match self.fd {
            FdSeen::No => false,
            FdSeen::NeverSwitched | FdSeen::Switched | FdSeen::Suspected => self.data.is_none(),
        }
    }
}

/// What a scan came to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LiveReport {
    pub(crate) source: String,
    pub(crate) adapter: String,
    pub(crate) outcome: Outcome,
    /// For `Undecided` and `NoTraffic`: what is missing, one sentence.
    pub(crate) need: Option<String>,
    pub(crate) found: Option<LiveRate>,
    pub(crate) elapsed: Micros,
    /// From the beginning to an outcome at most.
    pub(crate) bound: Option<Micros>,
    /// Candidates listened to; one that was listened to twice counts twice.
    pub(crate) visits: u32,
    pub(crate) tried: Vec<Standing>,
    pub(crate) caveats: Vec<Caveat>,
}
