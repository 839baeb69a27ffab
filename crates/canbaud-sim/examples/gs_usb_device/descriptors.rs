//! What the device tells about itself as a USB device [USB 2.0, 9.4 and 9.6].

use crate::usbip::{Reply, Setup};

/// Largest packet of the bulk endpoints and of endpoint 0.
const PACKET: u8 = 64;

const GET_STATUS: u8 = 0;
const SET_ADDRESS: u8 = 5;
const GET_DESCRIPTOR: u8 = 6;
const GET_CONFIGURATION: u8 = 8;
const SET_CONFIGURATION: u8 = 9;
const SET_INTERFACE: u8 = 11;

const DEVICE: [u8; 18] = [
    18, 1, 0x00, 0x02, 0, 0, 0, PACKET, // USB 2.0
    0x50, 0x1D, 0x6F, 0x60, // 1d50:606f: gs_usb, candleLight, CANable
    0x00, 0x01, 1, 2, 3, 1,
];

const CONFIGURATION: [u8; 32] = [
    9, 2, 32, 0, 1, 1, 0, 0x80, 75, // one interface, 150 mA
    9, 4, 0, 0, 2, 0xFF, 0xFF, 0xFF, 0, // vendor class, two endpoints
    7, 5, 0x81, 2, PACKET, 0, 0, // bulk in
    7, 5, 0x02, 2, PACKET, 0, 0, // bulk out
];

fn string(index: u8) -> Option<Vec<u8>> {
    let text = match index {
        // The languages: English (United States).
        0 => return Some(vec![4, 3, 0x09, 0x04]),
        1 => "canbaud",
        2 => "simulated candleLight",
        3 => "000000000001",
        _ => return None,
    };
    let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let length = u8::try_from(units.len() + 2).ok()?;
    Some([vec![length, 3], units].concat())
}

/// Answers a standard request.
pub(super) fn standard(setup: Setup) -> Reply {
    let [index, kind] = setup.value.to_le_bytes();
    let answer = match (setup.request, kind) {
        (GET_DESCRIPTOR, 1) => Some(DEVICE.to_vec()),
        (GET_DESCRIPTOR, 2) => Some(CONFIGURATION.to_vec()),
        (GET_DESCRIPTOR, 3) => string(index),
        (GET_STATUS, _) => Some(vec![0, 0]),
        (GET_CONFIGURATION, _) => Some(vec![1]),
        (SET_ADDRESS | SET_CONFIGURATION | SET_INTERFACE, _) => return Reply::Taken(0),
        _ => None,
    };
    answer.map_or(Reply::Stall, |mut data| {
        data.truncate(usize::from(setup.length));
        Reply::Data(data)
    })
}
