//! Instructions and registers, as far as listening needs them \[DS20001801\].

/// SPI instructions \[table 12-1\]. RTS and LOAD TX BUFFER are left out: nothing transmits.
pub(crate) mod instruction {
    pub(crate) const RESET: u8 = 0xC0;
    pub(crate) const READ: u8 = 0x03;
    pub(crate) const WRITE: u8 = 0x02;
    pub(crate) const BIT_MODIFY: u8 = 0x05;
    /// READ RX BUFFER from RXB0SIDH and from RXB1SIDH on; clears the buffer's flag at its end.
    pub(crate) const READ_RX0: u8 = 0x90;
    pub(crate) const READ_RX1: u8 = 0x94;
}

/// Filters 0 to 2 \[register 4-10 and on\], in front of CANSTAT.
pub(crate) const RXF0SIDH: u8 = 0x00;
/// CANSTAT and CANCTRL \[registers 10-1, 10-2\].
pub(crate) const CANSTAT: u8 = 0x0E;
pub(crate) const CANCTRL: u8 = 0x0F;
/// Filters 3 to 5.
pub(crate) const RXF3SIDH: u8 = 0x10;
/// Masks 0 and 1, four registers each \[register 4-14 and on\].
pub(crate) const RXM0SIDH: u8 = 0x20;
/// CNF3, CNF2, CNF1, in this order \[registers 5-1 to 5-3\].
pub(crate) const CNF3: u8 = 0x28;
/// CANINTE, CANINTF, EFLG, in this order.
pub(crate) const CANINTE: u8 = 0x2B;
pub(crate) const CANINTF: u8 = 0x2C;
pub(crate) const EFLG: u8 = 0x2D;
pub(crate) const RXB0CTRL: u8 = 0x60;
pub(crate) const RXB1CTRL: u8 = 0x70;

/// REQOP in CANCTRL and OPMOD in CANSTAT.
pub(crate) const MODE_MASK: u8 = 0b1110_0000;

/// The modes that this driver asks for. Normal mode (000) and loopback (010) are not among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Mode {
    ListenOnly = 0b0110_0000,
    Configuration = 0b1000_0000,
}

/// CANINTF \[register 7-2\].
pub(crate) const RX0IF: u8 = 0b0000_0001;
pub(crate) const RX1IF: u8 = 0b0000_0010;
pub(crate) const MERRF: u8 = 0b1000_0000;
/// EFLG \[register 6-3\]: RX1OVR and RX0OVR.
pub(crate) const OVERFLOW: u8 = 0b1100_0000;
/// RXFnSIDL: the filter is for extended frames.
pub(crate) const EXIDE: u8 = 0b0000_1000;
/// RXB0CTRL: what does not fit into buffer 0 goes on to buffer 1; RXM stays 00. RXM 11 ("receive any
/// message") would hand out the beginnings of frames with errors, too \[4.2.2\].
pub(crate) const BUKT: u8 = 0b0000_0100;
