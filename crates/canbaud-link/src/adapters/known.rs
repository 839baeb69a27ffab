//! What is known of each driver, from its source (Linux 6.1 and 6.12) and its maker's documents.

/// Whether the adapter can listen without disturbing the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListenOnly {
    /// Yes.
    Yes,
    /// Some models or firmwares; the kernel tells which.
    Some,
    /// No: canbaud does not use it.
    No,
}

/// What a listener at a wrong rate gets to see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WrongRate {
    /// An error frame for each error, if error reporting can be switched on.
    ErrorFramesOnRequest,
    /// An error frame for each error, always.
    ErrorFrames,
    /// A receive error counter.
    Counter,
    /// Nothing: a wrong rate looks like a silent bus.
    Silence,
    /// What the firmware of the adapter makes of it.
    Firmware,
}

/// One driver, or a family that behaves alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KnownDriver {
    /// Names of the kernel's drivers.
    pub drivers: &'static [&'static str],
    /// What people call it.
    pub title: &'static str,
    /// Whether it can listen.
    pub listen_only: ListenOnly,
    /// What it shows at a wrong rate.
    pub wrong_rate: WrongRate,
    /// What else to know.
    pub note: &'static str,
}

use ListenOnly::{No, Some as SomeModels, Yes};
use WrongRate::{Counter, ErrorFrames, ErrorFramesOnRequest, Firmware, Silence};

const fn driver(
    drivers: &'static [&'static str],
    title: &'static str,
    listen_only: ListenOnly,
    wrong_rate: WrongRate,
    note: &'static str,
) -> KnownDriver {
    KnownDriver { drivers, title, listen_only, wrong_rate, note }
}

const KNOWN: &[KnownDriver] = &[
    driver(
        &[
            "sja1000_platform",
            "sja1000_isa",
            "kvaser_pci",
            "peak_pci",
            "peak_pcmcia",
            "ems_pci",
            "ems_pcmcia",
            "plx_pci",
            "f81601",
            "tscan1",
        ],
        "SJA1000 cards",
        Yes,
        ErrorFramesOnRequest,
        "kind and place of every error",
    ),
    driver(
        &["m_can_platform", "m_can_pci", "tcan4x5x", "tcan4x5x-spi"],
        "Bosch M_CAN, TCAN4x5x",
        Yes,
        ErrorFramesOnRequest,
        "kind of every error",
    ),
    driver(
        &["flexcan"],
        "NXP FlexCAN",
        Yes,
        ErrorFramesOnRequest,
        "while it listens it receives only frames that another node acknowledges",
    ),
    driver(
        &["mcp251xfd"],
        "MCP2517FD, MCP2518FD",
        Yes,
        ErrorFramesOnRequest,
        "kind of every error",
    ),
    driver(
        &["c_can_platform", "c_can_pci"],
        "Bosch C_CAN, D_CAN",
        Yes,
        ErrorFramesOnRequest,
        "kind of every error",
    ),
    driver(
        &[
            "bxcan",
            "ctucanfd",
            "ctucanfd_pci",
            "ctucanfd_platform",
            "esd_usb",
            "esd_usb2",
            "esd_402_pci",
            "f81604",
            "ifi_canfd",
            "sun4i_can",
            "hi3110",
            "hi311x",
            "peak_pciefd",
            "ucan",
        ],
        "bxCAN, CTU CAN FD, esd, F81604, IFI, sun4i, HI-311x, PCAN-PCI Express FD, ucan",
        Yes,
        ErrorFramesOnRequest,
        "",
    ),
    driver(
        &["mcp251x"],
        "MCP2515, MCP2510",
        Yes,
        Silence,
        "reports no errors while it listens, and its counters stand still",
    ),
    driver(
        &["gs_usb"],
        "candleLight, CANable, CANtact and other gs_usb adapters",
        SomeModels,
        Firmware,
        "error frames need a Linux after 6.1 and a firmware that reports errors; older ones are silent",
    ),
    driver(
        &["peak_usb"],
        "PEAK PCAN-USB, PCAN-USB Pro, FD",
        Yes,
        Counter,
        "no error frames; PCAN-USB up to hardware revision 3 has no silent mode and is refused",
    ),
    driver(
        &["kvaser_usb", "kvaser_pciefd"],
        "Kvaser USB and PCI Express",
        SomeModels,
        ErrorFrames,
        "",
    ),
    driver(&["usb_8dev"], "8devices USB2CAN", Yes, ErrorFrames, "kind of every error"),
    driver(
        &["slcan"],
        "serial adapters attached by slcand",
        Yes,
        Firmware,
        "the driver never reads the adapter's answers: a firmware without L (CANable 1.x) stays \
         closed, which looks like a silent bus; slcan:/dev/tty... without slcand tells",
    ),
    driver(&["can327"], "ELM327 adapters", Yes, Silence, ""),
    driver(
        &["at91_can", "grcan", "mpc5xxx_can"],
        "AT91, GRCAN, MSCAN",
        Yes,
        Silence,
        "no error reporting on request",
    ),
    driver(
        &["etas_es58x", "es58x"],
        "ETAS ES58x",
        SomeModels,
        Silence,
        "ES582.1 and ES584.1 can listen, ES581.4 cannot",
    ),
    driver(
        &[
            "ems_usb",
            "cc770_platform",
            "cc770_isa",
            "softing",
            "softing_cs",
            "ti_hecc",
            "mcba_usb",
            "xilinx_can",
            "rockchip_canfd",
            "rcar_can",
            "rcar_canfd",
            "janz-ican3",
        ],
        "EMS CPC-USB, CC770, Softing, TI HECC, MCP CAN BUS Analyzer, Xilinx CAN, Rockchip CAN FD, \
         R-Car CAN, Janz ICAN3",
        No,
        Silence,
        "",
    ),
];

/// All that is known.
#[must_use]
pub const fn known_drivers() -> &'static [KnownDriver] {
    KNOWN
}

/// What is known of the kernel's driver `name`.
#[must_use]
pub fn known(name: &str) -> Option<&'static KnownDriver> {
    KNOWN.iter().find(|known| known.drivers.contains(&name))
}

/// Beginnings of the names that drivers give their controllers in `struct can_bittiming_const`, and
/// a driver that does so, longest first.
const CONTROLLERS: &[(&str, &str)] = &[
    ("pcan_chip_usb", "peak_usb"),
    ("pcan_usb", "peak_usb"),
    ("peak_canfd", "peak_pciefd"),
    ("kvaser_pciefd", "kvaser_pciefd"),
    ("kvaser_usb", "kvaser_usb"),
    ("gs_usb", "gs_usb"),
    ("usb_8dev", "usb_8dev"),
    ("mcp251xfd", "mcp251xfd"),
    ("mcp251x", "mcp251x"),
    ("sja1000", "sja1000_platform"),
    ("tcan4x5x", "tcan4x5x"),
    ("m_can", "m_can_platform"),
    ("flexcan", "flexcan"),
    ("c_can", "c_can_platform"),
    ("bxcan", "bxcan"),
    ("ctu_can_fd", "ctucanfd"),
    ("ctucanfd", "ctucanfd"),
    ("esd_usb", "esd_usb"),
    ("esd_402", "esd_402_pci"),
    ("f81604", "f81604"),
    ("ifi_canfd", "ifi_canfd"),
    ("sun4i_can", "sun4i_can"),
    ("hi3110", "hi3110"),
    ("hi311x", "hi311x"),
    ("ucan", "ucan"),
    ("at91_can", "at91_can"),
    ("grcan", "grcan"),
    ("mscan", "mpc5xxx_can"),
    ("ES58", "etas_es58x"),
    ("ems_usb", "ems_usb"),
    ("cc770", "cc770_platform"),
    ("softing", "softing"),
    ("ti_hecc", "ti_hecc"),
    ("xilinx_can", "xilinx_can"),
    ("rockchip_canfd", "rockchip_canfd"),
    ("rcar_canfd", "rcar_canfd"),
    ("rcar_can", "rcar_can"),
    ("janz-ican3", "janz-ican3"),
];

/// A kernel's driver that calls its controller `name`, as the kernel tells with its limits: this is
/// known also where sysfs is hidden. Of a family that behaves alike it is any one.
#[must_use]
pub fn driver_of_controller(name: &str) -> Option<&'static str> {
    CONTROLLERS.iter().find(|(begin, _)| name.starts_with(begin)).map(|(_, driver)| *driver)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_controllers_are_called_leads_to_a_driver_that_is_known() {
        for (begin, driver) in CONTROLLERS {
            assert!(known(driver).is_some(), "{driver}");
            // None hides behind a shorter one.
            assert_eq!(driver_of_controller(begin), Some(*driver), "{begin}");
        }
        // Names in Linux 6.12.
        for (name, driver) in [
            ("pcan_usb", Some("peak_usb")),
            ("pcan_usb_pro_fd", Some("peak_usb")),
            ("kvaser_usb_flex", Some("kvaser_usb")),
            ("mcp251xfd", Some("mcp251xfd")),
            ("ES582.1/ES584.1", Some("etas_es58x")),
            ("rcar_canfd", Some("rcar_canfd")),
            ("", None),
            ("test", None),
        ] {
            assert_eq!(driver_of_controller(name), driver, "{name}");
        }
    }

    #[test]
    fn no_driver_is_listed_twice() {
        let mut names: Vec<_> = KNOWN.iter().flat_map(|known| known.drivers).collect();
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all);
    }

    #[test]
    fn traps_are_known() {
        assert_eq!(known("mcp251x").unwrap().wrong_rate, Silence);
        assert_eq!(known("peak_usb").unwrap().wrong_rate, Counter);
        assert_eq!(known("mcba_usb").unwrap().listen_only, No);
        assert_eq!(known("e1000e"), None);
    }
}
