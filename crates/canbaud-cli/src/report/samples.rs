//! Reports made by hand for the tests of the outputs.

use canbaud::detect::scan::{Acknowledgement, Candidate, FdSeen, Standing};
use canbaud::units::{Bitrate, Micros};

use super::{Caveat, ChannelReport, FrameCounts, LiveRate, LiveReport, Outcome, Rate};

fn rate(bitrate: u32, ppm: f64, known_as: Option<&'static str>) -> Rate {
    let measured = f64::from(bitrate) * (1.0 + ppm * 1e-6);
    Rate { bitrate, measured, uncertainty_ppm: 0.5, known_as }
}

/// A classic bus at 125 kbit/s with nothing special.
pub(crate) fn classic() -> ChannelReport {
    ChannelReport {
        channel: "CAN_RX".to_owned(),
        inverted: false,
        outcome: Outcome::Found,
        need: None,
        nominal: Some(rate(125_000, -478.0, Some("CiA 301, DeviceNet"))),
        data: None,
        other: None,
        proven_frames: 286,
        frames: FrameCounts { classic: 286, ..FrameCounts::default() },
        error_probability: 3.2e-14,
        bus_load: 0.037,
        asymmetry_ns: Some(0.4),
        clock_spread_ppm: Some(3.0),
        samples_per_bit: Some(32.0),
        duration_s: 3.0,
        edges: 12_398,
        caveats: Vec::new(),
    }
}

/// A mixed CAN FD bus at 500 kbit/s and 2 Mbit/s with trouble of every kind.
pub(crate) fn fd() -> ChannelReport {
    ChannelReport {
        inverted: true,
        nominal: Some(rate(500_000, 10.0, Some("CiA 301"))),
        data: Some(rate(2_000_000, 10.0, None)),
        proven_frames: 1_000,
        frames: FrameCounts {
            classic: 612,
            fd: 376,
            fd_brs: 370,
            remote: 12,
            extended: 30,
            error: 2,
            truncated: 1,
            overload: 1,
            unacknowledged: 7,
            fd_non_iso: 0,
        },
        error_probability: 0.0,
        bus_load: 0.312,
        asymmetry_ns: Some(20.2),
        clock_spread_ppm: Some(12.0),
        samples_per_bit: Some(200.0),
        duration_s: 1.748,
        edges: 593_018,
        caveats: vec![Caveat {
            code: "missing_acknowledge",
            text: "7 frames were not acknowledged: check that a second node is on the bus and \
                   runs at this rate."
                .to_owned(),
        }],
        ..classic()
    }
}

/// Edges, but no complete frame.
pub(crate) fn undecided() -> ChannelReport {
    ChannelReport {
        channel: "D1".to_owned(),
        outcome: Outcome::Undecided,
        need: Some("no complete frame between two idle stretches: capture 3 ms more".to_owned()),
        nominal: None,
        proven_frames: 0,
        frames: FrameCounts::default(),
        error_probability: 1.0,
        bus_load: 0.5,
        asymmetry_ns: None,
        clock_spread_ppm: None,
        samples_per_bit: None,
        duration_s: 0.002,
        edges: 41,
        ..classic()
    }
}

/// A line that never changes.
pub(crate) fn silent() -> ChannelReport {
    ChannelReport {
        channel: "D2".to_owned(),
        outcome: Outcome::NoTraffic,
        need: None,
        bus_load: 0.0,
        edges: 0,
        ..undecided()
    }
}

/// Two proven rates on one line.
pub(crate) fn conflict() -> ChannelReport {
    ChannelReport { outcome: Outcome::Conflict, other: Some(rate(250_000, 0.0, None)), ..classic() }
}

/// A live bus at 250 kbit/s, found at the second rate.
pub(crate) fn live() -> LiveReport {
    let standing = |rate, frames, errors| Standing {
        candidate: Candidate::classic(Bitrate::new(rate).unwrap()),
        refused: false,
        visits: 1,
        listened: Micros(20_000),
        frames,
        distinct: 2,
        errors,
        unacknowledged: 0,
        weight: 0,
    };
    LiveReport {
        source: "can0".to_owned(),
        adapter: "can0 (gs_usb)".to_owned(),
        outcome: Outcome::Found,
        need: None,
        found: Some(LiveRate {
            nominal: 250_000,
            data: None,
            known_as: Some("SAE J1939"),
            frames: 2,
            distinct: 2,
            errors: 0,
            acknowledgement: Acknowledgement::Presumed,
            fd: FdSeen::No,
        }),
        elapsed: Micros(41_000),
        bound: Some(Micros(9_000_000)),
        visits: 2,
        tried: vec![standing(500_000, 0, 3), standing(250_000, 2, 0)],
        caveats: Vec::new(),
    }
}
