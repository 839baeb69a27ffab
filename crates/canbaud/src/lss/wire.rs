//! Eight bytes on two identifiers.

use crate::wire::{Frame, FrameKind, Id};

/// COB-ID of what a master sends.
pub const MASTER_COB_ID: u16 = 0x7E5;
/// COB-ID of what a slave sends.
pub const SLAVE_COB_ID: u16 = 0x7E4;

/// The bytes of an LSS frame on `cob_id`: a classic data frame with a base identifier and DLC 8.
/// Whatever else has that identifier is no LSS frame.
pub(super) fn bytes_of(frame: &Frame, cob_id: u16) -> Option<[u8; 8]> {
    let is_lss =
        frame.id() == Id::Base(cob_id) && frame.kind() == FrameKind::Data && frame.dlc() == 8;
    if is_lss { frame.data().try_into().ok() } else { None }
}

/// Eight bytes that begin with the command specifier `cs` and, if any, a number.
pub(super) const fn command(cs: u8, number: u32) -> [u8; 8] {
    let [a, b, c, d] = number.to_le_bytes();
    [cs, a, b, c, d, 0, 0, 0]
}

/// The number behind the command specifier, least significant byte first.
pub(super) const fn number(bytes: [u8; 8]) -> u32 {
    let [_, a, b, c, d, ..] = bytes;
    u32::from_le_bytes([a, b, c, d])
}
