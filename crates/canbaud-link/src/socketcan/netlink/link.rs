//! A link: `struct ifinfomsg` and its attributes.

use super::attribute::{Attribute, Attributes};
use super::can::{CanInfo, XStats};

/// Bytes of `struct ifinfomsg`.
const IFINFOMSG: usize = 16;
/// ARPHRD_CAN.
const HARDWARE_CAN: u16 = 280;

mod attr {
    pub(super) const IFNAME: u16 = 3;
    pub(super) const MTU: u16 = 4;
    pub(super) const TXQLEN: u16 = 13;
    pub(super) const LINKINFO: u16 = 18;
    pub(super) const INFO_KIND: u16 = 1;
    pub(super) const INFO_DATA: u16 = 2;
    pub(super) const INFO_XSTATS: u16 = 3;
}

/// Bits of the flags of a link [linux/if.h].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinkFlags(pub u32);

impl LinkFlags {
    const UP: u32 = 1;
    const ECHO: u32 = 1 << 18;

    /// Set up, whether there is a carrier or not.
    #[must_use]
    pub const fn is_up(self) -> bool {
        self.0 & Self::UP != 0
    }

    /// The driver hands back what was really sent; without it the network stack does, sent or not.
    #[must_use]
    pub const fn driver_echoes(self) -> bool {
        self.0 & Self::ECHO != 0
    }
}

/// One interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Link {
    /// Its number.
    pub index: u32,
    /// Its name.
    pub name: String,
    /// Its flags.
    pub flags: LinkFlags,
    /// ARPHRD number.
    pub hardware: u16,
    /// 16 for classic CAN, 72 for CAN FD.
    pub mtu: u32,
    /// Frames that may wait to be sent.
    pub txqueuelen: u32,
    /// `can`, `vcan`, `vxcan`; `None` for most that are no CAN.
    pub kind: Option<String>,
    /// For kind `can`.
    pub can: Option<CanInfo>,
}

impl Link {
    /// Reads the body of a message; `None` if it has no header.
    #[must_use]
    pub fn parse(body: &[u8]) -> Option<Self> {
        let header: &[u8; IFINFOMSG] = body.first_chunk()?;
        let [_, _, h0, h1, i0, i1, i2, i3, f0, f1, f2, f3, ..] = *header;
        let mut link = Self {
            index: u32::from_ne_bytes([i0, i1, i2, i3]),
            name: String::new(),
            flags: LinkFlags(u32::from_ne_bytes([f0, f1, f2, f3])),
            hardware: u16::from_ne_bytes([h0, h1]),
            mtu: 0,
            txqueuelen: 0,
            kind: None,
            can: None,
        };
        for attribute in Attributes::new(body.get(IFINFOMSG..)?) {
            link.take(attribute);
        }
        Some(link)
    }

    fn take(&mut self, attribute: Attribute<'_>) {
        match attribute.kind {
            attr::IFNAME => self.name = attribute.text(),
            attr::MTU => self.mtu = attribute.u32().unwrap_or(0),
            attr::TXQLEN => self.txqueuelen = attribute.u32().unwrap_or(0),
            attr::LINKINFO => self.take_info(attribute.nested()),
            _ => {}
        }
    }

    fn take_info(&mut self, info: Attributes<'_>) {
        self.kind = info.find(attr::INFO_KIND).map(Attribute::text);
        if self.kind.as_deref() == Some("can") {
            let data = info.find(attr::INFO_DATA).map(|data| CanInfo::parse(data.nested()));
            let mut can = data.unwrap_or_default();
            can.xstats = info.find(attr::INFO_XSTATS).and_then(XStats::parse);
            self.can = Some(can);
        }
    }

    /// Whether it has no bit rate at all; the name says nothing.
    #[must_use]
    pub fn is_virtual(&self) -> bool {
        matches!(self.kind.as_deref(), Some("vcan" | "vxcan"))
    }

    /// Whether it is a CAN interface of any kind.
    #[must_use]
    pub const fn is_can(&self) -> bool {
        self.hardware == HARDWARE_CAN
    }
}
