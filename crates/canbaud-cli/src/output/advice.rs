//! The ready command that sets a Linux interface to what was found.

use crate::report::{ChannelReport, Outcome};

/// The `ip link` line for a proven bus; `None` without a proven rate.
///
/// The sample points are those that the Linux kernel and CiA recommend for the rate: the capture
/// shows where bits begin, not where the nodes sample them.
pub(super) fn ip_link(report: &ChannelReport) -> Option<String> {
    let nominal = report.nominal.as_ref().filter(|_| report.outcome == Outcome::Found)?;
    let mut line = format!(
        "ip link set can0 type can bitrate {} sample-point {}",
        nominal.bitrate,
        sample_point(nominal.bitrate)
    );
    if report.frames.fd > 0 {
        match &report.data {
            Some(data) => {
                let bitrate = data.bitrate;
                let point = sample_point(bitrate);
                line.push_str(&format!(" dbitrate {bitrate} dsample-point {point}"));
            }
            None => line.push_str(" dbitrate RATE"),
        }
        line.push_str(" fd on");
        if report.frames.fd_non_iso > 0 {
            line.push_str(" fd-non-iso on");
        }
    }
    Some(line)
}

/// The recommended sample point [Linux `drivers/net/can/dev/calc_bittiming.c`, CiA 301].
pub(super) const fn sample_point(bitrate: u32) -> &'static str {
    match bitrate {
        800_001.. => "0.750",
        500_001..=800_000 => "0.800",
        _ => "0.875",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::{classic, fd, undecided};

    #[test]
    fn classic_bus_gets_its_rate_and_sample_point() {
        assert_eq!(
            ip_link(&classic()).unwrap(),
            "ip link set can0 type can bitrate 125000 sample-point 0.875"
        );
    }

    #[test]
    fn fd_bus_gets_both_rates() {
        assert_eq!(
            ip_link(&fd()).unwrap(),
            "ip link set can0 type can bitrate 500000 sample-point 0.875 \
             dbitrate 2000000 dsample-point 0.750 fd on"
        );
    }

    #[test]
    fn unknown_data_rate_is_left_to_the_user() {
        let mut report = fd();
        report.data = None;
        report.frames.fd_non_iso = 1;
        assert!(ip_link(&report).unwrap().ends_with(" dbitrate RATE fd on fd-non-iso on"));
    }

    #[test]
    fn nothing_proven_gives_no_command() {
        assert_eq!(ip_link(&undecided()), None);
    }

    #[test]
    fn sample_points_follow_the_rate() {
        assert_eq!(
            [500_000, 615_385, 800_000, 1_000_000].map(sample_point),
            ["0.875", "0.800", "0.800", "0.750"]
        );
    }
}
