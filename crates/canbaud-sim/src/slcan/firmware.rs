//! Whose firmware the adapter runs, and how the firmwares differ.

use crate::node::MonitoringCounters;

/// Whose commands, answers, clock and flags an adapter has.
///
/// | firmware | answers | listen-only | registers | `F` | clock |
/// |---|---|---|---|---|---|
/// | `lawicel` | CR, BEL; `z`, `Z` | `L` | `sxxyy`: BTR0, BTR1 | bit 7 is a bus error | 8 MHz |
/// | `canable1` | none but to `V` | `M1`, then `O` | none | none | 48 MHz |
/// | `canable2` | CR, BEL; `z`, `Z` | `L` | `sddxxyyzz`, `yddxxyyzz` | bit 7: an error counter rose | 160 MHz |
/// | `canable2-stock` | none but to `V`, `E` | `M1`, then `O` | none | none | 160 MHz |
/// | `usbtin` | CR, BEL; `z`, `Z` | `L` | `sxxyyzz`: CNF1 to CNF3 | states alone, bit 7 is bus-off | 24 MHz |
///
/// | firmware | S7 | S9 | CAN FD | says of itself |
/// |---|---|---|---|---|
/// | `lawicel` | 800 kbit/s | | | `V1013`, `NCB01` |
/// | `canable1` | 750 kbit/s | ignored: the rate before stays | | version and address of the source |
/// | `canable2` | 800 kbit/s | | `Y`, `y`, `d`, `D`, `b`, `B` | `VL2K1`, `I30A0` |
/// | `canable2-stock` | 755 kbit/s | 83.333 kbit/s | `Y`, `d`, `D`, `b`, `B` | version and address of the source |
/// | `usbtin` | 800 kbit/s | | | `V0100`, `NFFFF` |
///
/// Sources: CAN232 manual; canable-fw and canable2-fw by normaldotcom, README and source;
/// canable2-fw by Nakakiyo092, its documents 1 to 3 and source; USBtin firmware 1.8, source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Firmware {
    /// CAN232 and CANUSB of Lawicel, a SJA1000.
    #[default]
    Lawicel,
    /// What CANable 1.x comes with (canable-fw), a bxCAN.
    Canable1,
    /// The other firmware for CANable 2.0 (Nakakiyo092/canable2-fw), a FDCAN of ST.
    Canable2,
    /// What CANable 2.0 comes with (normaldotcom/canable2-fw), a FDCAN of ST.
    Canable2Stock,
    /// USBtin, a MCP2515.
    Usbtin,
}

/// What the adapter says of errors on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorReports {
    /// `e` and `s` records beside frames, and `F`, if the firmware has it.
    Records,
    /// `F` alone, with the meaning that the firmware gives it.
    Flags,
    /// Nothing; `F` tells overruns alone.
    Silent,
}

/// What becomes of `M1` in a firmware that has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum SilentMode {
    /// The channel opens listen-only, as the README says.
    #[default]
    Honoured,
    /// `O` sets normal mode all the same, as the published sources of canable-fw and
    /// canable2-fw do (`can_enable` assigns the mode anew): the adapter disturbs the bus.
    Ignored,
}

/// Whether commands are answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Replies {
    /// CR or BEL to each.
    Always,
    /// Only what was asked for.
    Never,
}

impl Firmware {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Lawicel, Self::Canable1, Self::Canable2, Self::Canable2Stock, Self::Usbtin];

    /// What it says of errors unless it is told otherwise.
    #[must_use]
    pub const fn error_reports(self) -> ErrorReports {
        match self {
            Self::Lawicel | Self::Canable2 | Self::Usbtin => ErrorReports::Flags,
            Self::Canable1 | Self::Canable2Stock => ErrorReports::Silent,
        }
    }

    /// The clock that time quanta are made of, in Hz.
    #[must_use]
    pub const fn clock_hz(self) -> u64 {
        match self {
            // Both controllers halve their crystal: 16 and 24 MHz.
            Self::Lawicel => 8_000_000,
            Self::Usbtin => 12_000_000,
            Self::Canable1 => 48_000_000,
            Self::Canable2 | Self::Canable2Stock => 160_000_000,
        }
    }

    pub(super) const fn replies(self) -> Replies {
        match self {
            Self::Lawicel | Self::Canable2 | Self::Usbtin => Replies::Always,
            Self::Canable1 | Self::Canable2Stock => Replies::Never,
        }
    }

    pub(super) const fn has_fd(self) -> bool {
        matches!(self, Self::Canable2 | Self::Canable2Stock)
    }

    /// A SJA1000 and a MCP2515 stop their counters in listen-only mode; that of Bosch's M_CAN,
    /// which ST's FDCAN is, goes on.
    pub(super) const fn monitoring_counters(self) -> MonitoringCounters {
        match self {
            Self::Lawicel | Self::Canable1 | Self::Usbtin => MonitoringCounters::Frozen,
            Self::Canable2 | Self::Canable2Stock => MonitoringCounters::Counting,
        }
    }
}
