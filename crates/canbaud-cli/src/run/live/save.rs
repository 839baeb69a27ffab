//! A configuration that sets the interface up at every start.

use std::fmt::Write as _;

use canbaud_link::After;
use clap::ValueEnum;

use crate::output::live_text::ip_link;
use crate::report::LiveRate;

/// Who sets interfaces up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    Networkd,
    Ifupdown,
    Netplan,
    Nm,
}

impl Form {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Networkd => "networkd",
            Self::Ifupdown => "ifupdown",
            Self::Netplan => "netplan",
            Self::Nm => "nm",
        }
    }
}

/// The file, with its path in the first line.
pub(super) fn configuration(form: Form, interface: &str, rate: &LiveRate, after: After) -> String {
    match form {
        Form::Networkd => networkd(interface, rate, after),
        Form::Ifupdown => ifupdown(interface, rate, after),
        Form::Netplan => format!(
            "# netplan does not know CAN; with its renderer networkd this file works beside it.\n{}",
            networkd(interface, rate, after)
        ),
        Form::Nm => unit(interface, rate, after),
    }
}

fn networkd(interface: &str, rate: &LiveRate, after: After) -> String {
    let mut text = format!(
        "# /etc/systemd/network/80-{interface}.network\n[Match]\nName={interface}\n\n[CAN]\n\
         BitRate={}\n",
        rate.nominal
    );
    if let Some(data) = rate.data {
        let _ = writeln!(text, "DataBitRate={data}\nFDMode=yes");
    }
    if after == After::Listening {
        text.push_str("ListenOnly=yes\n");
    }
    text
}

fn ifupdown(interface: &str, rate: &LiveRate, after: After) -> String {
    format!(
        "# /etc/network/interfaces.d/{interface}\nauto {interface}\n\
         iface {interface} inet manual\n    pre-up {}\n    up ip link set {interface} up\n    \
         down ip link set {interface} down\n",
        command(interface, rate, after)
    )
}

/// NetworkManager has no CAN: a unit of systemd, which NetworkManager leaves alone.
fn unit(interface: &str, rate: &LiveRate, after: After) -> String {
    let device = format!("sys-subsystem-net-devices-{interface}.device");
    format!(
        "# NetworkManager does not set up CAN, and leaves the interface to this unit.\n\
         # /etc/systemd/system/{interface}-bitrate.service\n\
         [Unit]\nBindsTo={device}\nAfter={device}\n\n\
         [Service]\nType=oneshot\nRemainAfterExit=yes\nExecStart=/sbin/{}\n\
         ExecStart=/sbin/ip link set {interface} up\nExecStop=/sbin/ip link set {interface} down\n\n\
         [Install]\nWantedBy={device}\n",
        command(interface, rate, after)
    )
}

fn command(interface: &str, rate: &LiveRate, after: After) -> String {
    let mode = match after {
        After::Listening => " listen-only on",
        After::Normal => " listen-only off",
    };
    format!("{}{mode}", ip_link(interface, rate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud::detect::scan::{Acknowledgement, FdSeen};

    fn rate(data: Option<u32>) -> LiveRate {
        LiveRate {
            nominal: 500_000,
            data,
            known_as: None,
            frames: 2,
            distinct: 2,
            errors: 0,
            acknowledgement: Acknowledgement::Presumed,
            fd: FdSeen::No,
        }
    }

    /// Keys of systemd.network(5), section CAN.
    #[test]
    fn networkd_listens_unless_told_otherwise() {
        let text = networkd("can0", &rate(None), After::Listening);
        assert_eq!(
            text,
            "# /etc/systemd/network/80-can0.network\n[Match]\nName=can0\n\n[CAN]\n\
             BitRate=500000\nListenOnly=yes\n"
        );
        let text = networkd("can1", &rate(Some(2_000_000)), After::Normal);
        assert!(text.ends_with("BitRate=500000\nDataBitRate=2000000\nFDMode=yes\n"), "{text}");
    }

    #[test]
    fn others_run_ip_link() {
        let line = "ip link set can0 type can bitrate 500000 sample-point 0.875 listen-only on\n";
        for form in [Form::Ifupdown, Form::Nm] {
            let text = configuration(form, "can0", &rate(None), After::Listening);
            assert!(text.contains(line), "{text}");
        }
        assert!(configuration(Form::Netplan, "can0", &rate(None), After::Normal).contains("[CAN]"));
    }
}
