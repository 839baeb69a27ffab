//! The codec against `vectors/lss/codec.toml`, which an independent reference made.

use canbaud::lss::{Bound, Outcome, Part, Request, Response};
use canbaud::wire::{Frame, FrameKind, Id};
use serde::Deserialize;

#[derive(Deserialize)]
struct File {
    unknown_requests: Vec<u8>,
    unknown_responses: Vec<u8>,
    request: Vec<Entry>,
    response: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    name: String,
    fields: toml::Table,
    bytes: String,
}

impl Entry {
    fn number<T: TryFrom<i64>>(&self, field: &str) -> T {
        let value = self.fields[field].as_integer().expect("a number");
        T::try_from(value).unwrap_or_else(|_| panic!("{field} of {} is out of range", self.name))
    }

    fn word(&self, field: &str) -> &str {
        self.fields[field].as_str().expect("a word")
    }

    fn part(&self) -> Part {
        match self.word("part") {
            "vendor_id" => Part::VendorId,
            "product_code" => Part::ProductCode,
            "revision_number" => Part::RevisionNumber,
            "serial_number" => Part::SerialNumber,
            other => panic!("no part {other}"),
        }
    }

    fn bound(&self) -> Bound {
        match self.word("bound") {
            "vendor_id" => Bound::VendorId,
            "product_code" => Bound::ProductCode,
            "revision_number_low" => Bound::RevisionNumberLow,
            "revision_number_high" => Bound::RevisionNumberHigh,
            "serial_number_low" => Bound::SerialNumberLow,
            "serial_number_high" => Bound::SerialNumberHigh,
            other => panic!("no bound {other}"),
        }
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            error_code: self.number("error_code"),
            specific_error: self.number("specific_error"),
        }
    }

    fn bytes(&self) -> [u8; 8] {
        let byte = |at: usize| u8::from_str_radix(&self.bytes[2 * at..2 * at + 2], 16).unwrap();
        std::array::from_fn(byte)
    }

    fn request(&self) -> Request {
        match self.name.as_str() {
            "switch_state_global" => Request::SwitchStateGlobal { mode: self.number("mode") },
            "switch_state_selective" => {
                Request::SwitchStateSelective { part: self.part(), number: self.number("number") }
            }
            "configure_node_id" => Request::ConfigureNodeId { node_id: self.number("node_id") },
            "configure_bit_timing" => Request::ConfigureBitTiming {
                table_selector: self.number("table_selector"),
                table_index: self.number("table_index"),
            },
            "activate_bit_timing" => {
                Request::ActivateBitTiming { switch_delay_ms: self.number("switch_delay_ms") }
            }
            "store_configuration" => Request::StoreConfiguration,
            "identify_remote_slave" => {
                Request::IdentifyRemoteSlave { bound: self.bound(), number: self.number("number") }
            }
            "identify_non_configured_remote_slave" => Request::IdentifyNonConfiguredRemoteSlave,
            "fastscan" => Request::Fastscan {
                id_number: self.number("id_number"),
                bit_checked: self.number("bit_checked"),
                lss_sub: self.number("lss_sub"),
                lss_next: self.number("lss_next"),
            },
            "inquire_identity" => Request::InquireIdentity { part: self.part() },
            "inquire_node_id" => Request::InquireNodeId,
            other => panic!("no request {other}"),
        }
    }

    fn response(&self) -> Response {
        match self.name.as_str() {
            "configure_node_id" => Response::ConfigureNodeId(self.outcome()),
            "configure_bit_timing" => Response::ConfigureBitTiming(self.outcome()),
            "store_configuration" => Response::StoreConfiguration(self.outcome()),
            "switch_state_selective" => Response::SwitchStateSelective,
            "identify_slave" => Response::IdentifySlave,
            "identify_non_configured_slave" => Response::IdentifyNonConfiguredSlave,
            "inquire_identity" => {
                Response::InquireIdentity { part: self.part(), number: self.number("number") }
            }
            "inquire_node_id" => Response::InquireNodeId { node_id: self.number("node_id") },
            other => panic!("no response {other}"),
        }
    }
}

fn file() -> File {
    toml::from_str(include_str!("../../../vectors/lss/codec.toml")).expect("a sound vector file")
}

fn data(id: u16, bytes: &[u8]) -> Frame {
    Frame::new(Id::Base(id), FrameKind::Data, bytes.len() as u8, bytes).unwrap()
}

#[test]
fn requests_have_the_bytes_of_the_reference() {
    for entry in file().request {
        let request = entry.request();
        assert_eq!(request.to_bytes(), entry.bytes(), "{}", entry.name);
        assert_eq!(request.to_frame(), data(0x7E5, &entry.bytes()));
        assert_eq!(Request::from_frame(&data(0x7E5, &entry.bytes())), Some(request));
    }
}

#[test]
fn responses_have_the_bytes_of_the_reference() {
    for entry in file().response {
        let response = entry.response();
        assert_eq!(response.to_bytes(), entry.bytes(), "{}", entry.name);
        assert_eq!(response.to_frame(), data(0x7E4, &entry.bytes()));
        assert_eq!(Response::from_frame(&data(0x7E4, &entry.bytes())), Some(response));
    }
}

#[test]
fn other_command_specifiers_are_no_commands() {
    let file = file();
    assert!(file.unknown_requests.len() > 200 && file.unknown_responses.len() > 200);
    for cs in file.unknown_requests {
        assert_eq!(Request::from_bytes([cs, 1, 2, 3, 4, 5, 6, 7]), None, "{cs:02X}h");
    }
    for cs in file.unknown_responses {
        assert_eq!(Response::from_bytes([cs, 1, 2, 3, 4, 5, 6, 7]), None, "{cs:02X}h");
    }
}

#[test]
fn reserved_bytes_are_not_looked_at() {
    let bytes = [0x5E, 9, 9, 9, 9, 9, 9, 9];
    assert_eq!(Request::from_bytes(bytes), Some(Request::InquireNodeId));
    assert_eq!(
        Response::from_bytes([0x44, 9, 9, 9, 9, 9, 9, 9]),
        Some(Response::SwitchStateSelective)
    );
}

#[test]
fn frames_that_are_not_lss_are_none() {
    let bytes = Request::InquireNodeId.to_bytes();
    for dlc in 0..8 {
        assert_eq!(Request::from_frame(&data(0x7E5, &bytes[..dlc])), None, "DLC {dlc}");
    }
    // DLC 9 to 15 of a classic frame carry eight bytes, but are not DLC 8.
    let long = Frame::new(Id::Base(0x7E5), FrameKind::Data, 9, &bytes).unwrap();
    let remote = Frame::new(Id::Base(0x7E5), FrameKind::Remote, 8, &[]).unwrap();
    let extended = Frame::new(Id::Extended(0x7E5), FrameKind::Data, 8, &bytes).unwrap();
    let fd = FrameKind::Fd { brs: false, esi: false };
    let fd = Frame::new(Id::Base(0x7E5), fd, 8, &bytes).unwrap();
    for frame in [long, remote, extended, fd, data(0x7E4, &bytes), data(0x7E6, &bytes)] {
        assert_eq!(Request::from_frame(&frame), None, "{frame:?}");
    }
    let answer = Response::IdentifySlave.to_bytes();
    assert_eq!(Response::from_frame(&data(0x7E5, &answer)), None);
}
