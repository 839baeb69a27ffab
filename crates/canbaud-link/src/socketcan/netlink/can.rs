//! What `IFLA_INFO_DATA` and `IFLA_INFO_XSTATS` say of a CAN interface.

use super::attribute::{Attribute, Attributes};

/// Types of the attributes.
pub(super) mod attr {
    pub(in super::super) const BITTIMING: u16 = 1;
    pub(super) const BITTIMING_CONST: u16 = 2;
    pub(super) const CLOCK: u16 = 3;
    pub(super) const STATE: u16 = 4;
    pub(in super::super) const CTRLMODE: u16 = 5;
    pub(in super::super) const RESTART_MS: u16 = 6;
    pub(super) const BERR_COUNTER: u16 = 8;
    pub(in super::super) const DATA_BITTIMING: u16 = 9;
    pub(super) const DATA_BITTIMING_CONST: u16 = 10;
    pub(super) const BITRATE_CONST: u16 = 13;
    pub(super) const DATA_BITRATE_CONST: u16 = 14;
    pub(super) const BITRATE_MAX: u16 = 15;
    pub(in super::super) const TDC: u16 = 16;
    pub(in super::super) const TDC_TDCV: u16 = 7;
    pub(in super::super) const TDC_TDCO: u16 = 8;
    pub(in super::super) const TDC_TDCF: u16 = 9;
    pub(super) const CTRLMODE_EXT: u16 = 17;
    pub(super) const CTRLMODE_SUPPORTED: u16 = 1;
}

/// Bits of the control mode [linux/can/netlink.h].
pub mod ctrlmode {
    /// What is sent comes back.
    pub const LOOPBACK: u32 = 0x01;
    /// Bus monitoring: nothing is sent, not even an acknowledge.
    pub const LISTEN_ONLY: u32 = 0x02;
    /// Three samples a bit.
    pub const TRIPLE_SAMPLING: u32 = 0x04;
    /// No retransmission.
    pub const ONE_SHOT: u32 = 0x08;
    /// An error frame for each error of the bus.
    pub const BERR_REPORTING: u32 = 0x10;
    /// CAN FD.
    pub const FD: u32 = 0x20;
    /// A missing acknowledge is no error.
    pub const PRESUME_ACK: u32 = 0x40;
    /// CAN FD with the CRC of its first publication.
    pub const FD_NON_ISO: u32 = 0x80;
    /// Classic frames tell DLC 9 to 15.
    pub const CC_LEN8_DLC: u32 = 0x100;
    /// Transmitter delay compensation by the controller.
    pub const TDC_AUTO: u32 = 0x200;
    /// Transmitter delay compensation by hand.
    pub const TDC_MANUAL: u32 = 0x400;
}

/// `struct can_bittiming`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TimingInfo {
    /// In bit/s; 0: not set.
    pub bitrate: u32,
    /// In permille.
    pub sample_point: u32,
    /// Time quantum in ns.
    pub tq: u32,
    /// In TQ.
    pub prop_seg: u32,
    /// In TQ.
    pub phase_seg1: u32,
    /// In TQ.
    pub phase_seg2: u32,
    /// In TQ.
    pub sjw: u32,
    /// Prescaler.
    pub brp: u32,
}

impl TimingInfo {
    fn parse(attribute: Attribute<'_>) -> Option<Self> {
        let [bitrate, sample_point, tq, prop_seg, phase_seg1, phase_seg2, sjw, brp] =
            *attribute.u32s().first_chunk()?;
        Some(Self { bitrate, sample_point, tq, prop_seg, phase_seg1, phase_seg2, sjw, brp })
    }

    /// As the kernel takes it.
    #[must_use]
    pub fn to_bytes(self) -> [u8; 32] {
        let words = [
            self.bitrate,
            self.sample_point,
            self.tq,
            self.prop_seg,
            self.phase_seg1,
            self.phase_seg2,
            self.sjw,
            self.brp,
        ];
        let mut bytes = [0; 32];
        for (room, word) in bytes.chunks_exact_mut(4).zip(words) {
            room.copy_from_slice(&word.to_ne_bytes());
        }
        bytes
    }

    /// TQ of one bit.
    #[must_use]
    pub const fn quanta(&self) -> u32 {
        self.prop_seg
            .saturating_add(self.phase_seg1)
            .saturating_add(self.phase_seg2)
            .saturating_add(1)
    }
}

/// `struct can_bittiming_const`: the limits of the controller.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TimingConst {
    /// What the driver calls the controller.
    pub name: String,
    /// PROP_SEG and PHASE_SEG1 together, least and most.
    pub tseg1: (u32, u32),
    /// PHASE_SEG2, least and most.
    pub tseg2: (u32, u32),
    /// Largest SJW.
    pub sjw_max: u32,
    /// Prescaler, least and most.
    pub brp: (u32, u32),
    /// Step of the prescaler.
    pub brp_inc: u32,
}

impl TimingConst {
    fn parse(attribute: Attribute<'_>) -> Option<Self> {
        let (name, rest) = attribute.payload.split_at_checked(16)?;
        let words = Attribute { kind: attribute.kind, payload: rest }.u32s();
        let [t1_min, t1_max, t2_min, t2_max, sjw_max, brp_min, brp_max, brp_inc] =
            *words.first_chunk()?;
        Some(Self {
            name: Attribute { kind: 0, payload: name }.text(),
            tseg1: (t1_min, t1_max),
            tseg2: (t2_min, t2_max),
            sjw_max,
            brp: (brp_min, brp_max),
            brp_inc,
        })
    }
}

/// Transmitter delay compensation, in clocks of the controller; what is not set is absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TdcInfo {
    /// The measured or given delay.
    pub tdcv: Option<u32>,
    /// The offset of the secondary sample point.
    pub tdco: Option<u32>,
    /// The filter window.
    pub tdcf: Option<u32>,
}

impl TdcInfo {
    fn parse(attributes: Attributes<'_>) -> Self {
        let number = |kind| attributes.find(kind).and_then(Attribute::u32);
        Self {
            tdcv: number(attr::TDC_TDCV),
            tdco: number(attr::TDC_TDCO),
            tdcf: number(attr::TDC_TDCF),
        }
    }
}

/// `struct can_berr_counter`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorCounters {
    /// TEC.
    pub transmit: u16,
    /// REC.
    pub receive: u16,
}

/// `struct can_device_stats`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct XStats {
    /// Errors of the bus that the driver counted; some drivers never do.
    pub bus_error: u32,
    /// Changes to error warning.
    pub error_warning: u32,
    /// Changes to error passive.
    pub error_passive: u32,
    /// Changes to bus-off.
    pub bus_off: u32,
    /// Arbitrations lost.
    pub arbitration_lost: u32,
    /// Restarts.
    pub restarts: u32,
}

impl XStats {
    pub(super) fn parse(attribute: Attribute<'_>) -> Option<Self> {
        let [bus_error, error_warning, error_passive, bus_off, arbitration_lost, restarts] =
            *attribute.u32s().first_chunk()?;
        Some(Self { bus_error, error_warning, error_passive, bus_off, arbitration_lost, restarts })
    }
}

/// Everything that the kernel says of a CAN interface.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CanInfo {
    /// Nominal bit timing; absent or with bit rate 0 until it is set.
    pub timing: Option<TimingInfo>,
    /// Its limits; absent where the driver offers fixed rates only.
    pub timing_const: Option<TimingConst>,
    /// Clock of the controller in Hz.
    pub clock: Option<u32>,
    /// 0 error active, 1 warning, 2 error passive, 3 bus-off, 4 stopped, 5 sleeping.
    pub state: Option<u32>,
    /// Which bits of [`ctrlmode`] are set.
    pub ctrlmode: u32,
    /// Which of them can be set; kernels before 5.17 do not say.
    pub ctrlmode_supported: Option<u32>,
    /// Restart after bus-off, in ms; 0: by hand.
    pub restart_ms: Option<u32>,
    /// The error counters, where driver and controller can tell them.
    pub counters: Option<ErrorCounters>,
    /// Bit timing of the data phase.
    pub data_timing: Option<TimingInfo>,
    /// Its limits.
    pub data_timing_const: Option<TimingConst>,
    /// The only nominal bit rates, if not empty.
    pub bitrates: Vec<u32>,
    /// The only data bit rates, if not empty.
    pub data_bitrates: Vec<u32>,
    /// The highest bit rate that the transceiver can; 0: not known.
    pub bitrate_max: u32,
    /// Transmitter delay compensation as it is set up.
    pub tdc: Option<TdcInfo>,
    /// Statistics.
    pub xstats: Option<XStats>,
}

impl CanInfo {
    /// Reads `IFLA_INFO_DATA`.
    #[must_use]
    pub fn parse(attributes: Attributes<'_>) -> Self {
        let mut info = Self::default();
        for attribute in attributes {
            info.take(attribute);
        }
        info
    }

    fn take(&mut self, attribute: Attribute<'_>) {
        match attribute.kind {
            attr::BITTIMING => self.timing = TimingInfo::parse(attribute),
            attr::BITTIMING_CONST => self.timing_const = TimingConst::parse(attribute),
            attr::CLOCK => self.clock = attribute.u32(),
            attr::STATE => self.state = attribute.u32(),
            // Mask, then flags.
            attr::CTRLMODE => {
                self.ctrlmode = attribute.u32s().get(1).copied().unwrap_or(0);
            }
            attr::RESTART_MS => self.restart_ms = attribute.u32(),
            attr::BERR_COUNTER => {
                let pair = attribute.payload.first_chunk().map(|[a, b, c, d]| ErrorCounters {
                    transmit: u16::from_ne_bytes([*a, *b]),
                    receive: u16::from_ne_bytes([*c, *d]),
                });
                self.counters = pair;
            }
            attr::DATA_BITTIMING => self.data_timing = TimingInfo::parse(attribute),
            attr::DATA_BITTIMING_CONST => self.data_timing_const = TimingConst::parse(attribute),
            attr::BITRATE_CONST => self.bitrates = attribute.u32s(),
            attr::DATA_BITRATE_CONST => self.data_bitrates = attribute.u32s(),
            attr::BITRATE_MAX => self.bitrate_max = attribute.u32().unwrap_or(0),
            attr::TDC => self.tdc = Some(TdcInfo::parse(attribute.nested())),
            attr::CTRLMODE_EXT => {
                let supported = attribute.nested().find(attr::CTRLMODE_SUPPORTED);
                self.ctrlmode_supported = supported.and_then(Attribute::u32);
            }
            _ => {}
        }
    }

    /// Whether `mode` of [`ctrlmode`] can be set; `None` if the kernel does not say.
    #[must_use]
    pub fn supports(&self, mode: u32) -> Option<bool> {
        self.ctrlmode_supported.map(|supported| supported & mode == mode)
    }

    /// The nominal bit timing, if it was ever set.
    #[must_use]
    pub fn set_timing(&self) -> Option<TimingInfo> {
        self.timing.filter(|timing| timing.bitrate > 0)
    }

    /// The data bit timing, if it was ever set.
    #[must_use]
    pub fn set_data_timing(&self) -> Option<TimingInfo> {
        self.data_timing.filter(|timing| timing.bitrate > 0)
    }
}
