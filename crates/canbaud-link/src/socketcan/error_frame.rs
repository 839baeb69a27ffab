//! Error frames of Linux as observations [linux/can/error.h].

use canbaud::detect::scan::{ErrorClass, ErrorPlace, ErrorSeen, Observation};
use canbaud::units::Micros;

/// Bits of the class, in the identifier.
mod class {
    pub(super) const CONTROLLER: u32 = 0x04;
    pub(super) const PROTOCOL: u32 = 0x08;
    pub(super) const ACK: u32 = 0x20;
    pub(super) const BUS_ERROR: u32 = 0x80;
    pub(super) const COUNTERS: u32 = 0x200;
}

/// Bits of data byte 1 for [`class::CONTROLLER`].
const RX_OVERFLOW: u8 = 0x01;

/// Bits of data byte 2 for [`class::PROTOCOL`].
mod kind {
    pub(super) const BIT: u8 = 0x01;
    pub(super) const FORM: u8 = 0x02;
    pub(super) const STUFF: u8 = 0x04;
    pub(super) const BIT_0: u8 = 0x08;
    pub(super) const BIT_1: u8 = 0x10;
}

/// Values of data byte 3 for [`class::PROTOCOL`]; on SJA1000 the error code capture.
mod place {
    pub(super) const CRC_SEQUENCE: u8 = 0x08;
    pub(super) const CRC_DELIMITER: u8 = 0x18;
    pub(super) const ACK_SLOT: u8 = 0x19;
    pub(super) const ACK_DELIMITER: u8 = 0x1B;
    pub(super) const END_OF_FRAME: u8 = 0x1A;
}

/// What an error frame says to a scan; `None` if nothing.
///
/// State changes, lost arbitrations and the transmitter's troubles say nothing about the rate.
pub(super) fn observe(class: u32, data: [u8; 8], received: Option<Micros>) -> Option<Observation> {
    let [_, controller, kind, place, _, _, _, counter] = data;
    if class & (class::PROTOCOL | class::BUS_ERROR) != 0 {
        // Without the protocol class the bytes hold something else.
        let (kind, place) = if class & class::PROTOCOL != 0 { (kind, place) } else { (0, 0) };
        let error = ErrorSeen { class: class_of(kind, place), place: place_of(place), received };
        return Some(Observation::Error(error));
    }
    if class & class::ACK != 0 {
        let (class, place) = (ErrorClass::Acknowledge, ErrorPlace::AckSlot);
        return Some(Observation::Error(ErrorSeen { class, place, received }));
    }
    if class & class::CONTROLLER != 0 && controller & RX_OVERFLOW != 0 {
        return Some(Observation::Lost);
    }
    (class & class::COUNTERS != 0).then(|| Observation::ReceiveErrors(u16::from(counter)))
}

/// A wrong CRC has no bit of its own: drivers set the place, flexcan and slcan with the bit error.
const fn class_of(kind: u8, place: u8) -> ErrorClass {
    if kind & kind::STUFF != 0 {
        ErrorClass::Stuff
    } else if kind & kind::FORM != 0 {
        ErrorClass::Form
    } else if place == place::CRC_SEQUENCE {
        ErrorClass::Crc
    } else if kind & (kind::BIT | kind::BIT_0 | kind::BIT_1) != 0 {
        ErrorClass::Bit
    } else if place == place::ACK_SLOT {
        ErrorClass::Acknowledge
    } else {
        ErrorClass::Unknown
    }
}

const fn place_of(place: u8) -> ErrorPlace {
    match place {
        // SOF, identifier, SRTR, IDE, RTR.
        0x02..=0x07 | 0x0C | 0x0E | 0x0F => ErrorPlace::Arbitration,
        // Reserved bits, DLC, data, CRC sequence.
        0x08..=0x0B | 0x0D => ErrorPlace::BeforeCrcEnd,
        place::CRC_DELIMITER => ErrorPlace::CrcDelimiter,
        place::ACK_SLOT => ErrorPlace::AckSlot,
        place::ACK_DELIMITER => ErrorPlace::AckDelimiter,
        place::END_OF_FRAME => ErrorPlace::EndOfFrame,
        // Active and passive flag, intermission, tolerated dominant bits, delimiter, overload.
        0x11 | 0x12 | 0x13 | 0x16 | 0x17 | 0x1C => ErrorPlace::Between,
        _ => ErrorPlace::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(class: u32, data: [u8; 8]) -> Option<(ErrorClass, ErrorPlace)> {
        match observe(class, data, None) {
            Some(Observation::Error(error)) => Some((error.class, error.place)),
            _ => None,
        }
    }

    /// Name, class bits, data, and what they mean.
    type Case = (&'static str, u32, [u8; 8], (ErrorClass, ErrorPlace));

    /// What each driver makes of an error, from its source in Linux 6.12.
    #[test]
    fn drivers_say_the_same_thing_in_their_ways() {
        use ErrorClass::{Acknowledge, Bit, Crc, Form, Stuff, Unknown};
        let cases: [Case; 12] = [
            // gs_usb of candleLight as candump showed it: PROT | BUSERROR | CNT, stuff, REC 6.
            ("gs_usb", 0x288, [0, 0, 4, 0, 0, 0, 0, 6], (Stuff, ErrorPlace::Unknown)),
            (
                "sja1000 stuff in data",
                0x88,
                [0, 0, 4, 0x0A, 0, 0, 0, 0],
                (Stuff, ErrorPlace::BeforeCrcEnd),
            ),
            ("sja1000 form", 0x88, [0, 0, 2, 0x18, 0, 0, 0, 0], (Form, ErrorPlace::CrcDelimiter)),
            (
                "sja1000 ack del",
                0x88,
                [0, 0, 2, 0x1B, 0, 0, 0, 0],
                (Form, ErrorPlace::AckDelimiter),
            ),
            ("sja1000 bit", 0x88, [0, 0, 1, 0x11, 0, 0, 0, 0], (Bit, ErrorPlace::Between)),
            ("m_can crc", 0x88, [0, 0, 0, 8, 0, 0, 0, 0], (Crc, ErrorPlace::BeforeCrcEnd)),
            ("flexcan crc", 0x88, [0, 0, 1, 8, 0, 0, 0, 0], (Crc, ErrorPlace::BeforeCrcEnd)),
            ("m_can ack", 0x88, [0, 0, 0, 0x19, 0, 0, 0, 0], (Acknowledge, ErrorPlace::AckSlot)),
            ("slcan e1b", 0x88, [0, 0, 8, 0, 0, 0, 0, 0], (Bit, ErrorPlace::Unknown)),
            ("slcan e1a", 0xA8, [0, 0, 0, 0, 0, 0, 0, 0], (Unknown, ErrorPlace::Unknown)),
            ("kvaser hydra", 0x280, [0, 0, 0, 0, 0, 0, 3, 9], (Unknown, ErrorPlace::Unknown)),
            ("ack alone", 0x20, [0; 8], (Acknowledge, ErrorPlace::AckSlot)),
        ];
        for (name, class, data, want) in cases {
            assert_eq!(error(class, data), Some(want), "{name}");
        }
    }

    #[test]
    fn states_and_the_transmitters_troubles_say_nothing_about_the_rate() {
        // Error warning; lost arbitration (also what m_can makes of a protocol exception); restart.
        for (class, data) in
            [(0x04, [0, 0x04, 0, 0, 0, 0, 0, 0]), (0x02, [0; 8]), (0x100, [0; 8]), (0x40, [0; 8])]
        {
            assert_eq!(observe(class, data, None), None, "{class:#x}");
        }
        // Counters and overflow are something else.
        let passive = [0, 0x10, 0, 0, 0, 0, 0, 130];
        assert_eq!(observe(0x204, passive, None), Some(Observation::ReceiveErrors(130)));
        assert_eq!(observe(0x04, [0, 1, 0, 0, 0, 0, 0, 0], None), Some(Observation::Lost));
    }
}
