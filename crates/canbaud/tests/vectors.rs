//! The encoder against the vectors in `vectors/bits`, which an independent reference made, and
//! the CRCs against the CRC catalogue.

use canbaud::wire::{Crc, CrcKind, EncodedFrame, FdCrc, Frame, FrameKind, Id, Level, encode};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use serde::Deserialize;
use std::fs;
use std::path::Path;

#[derive(Deserialize)]
struct File {
    frame: Vec<Vector>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Vector {
    name: String,
    id: u32,
    extended: bool,
    kind: String,
    dlc: u8,
    data: String,
    #[serde(default)]
    brs: bool,
    #[serde(default)]
    esi: bool,
    iso: Option<bool>,
    crc: String,
    bits: String,
    stuff_bits: usize,
    crc_delimiter: usize,
    brs_index: Option<usize>,
}

impl Vector {
    fn frame(&self) -> Frame {
        let id = if self.extended {
            Id::extended(self.id)
        } else {
            Id::base(u16::try_from(self.id).expect("a base identifier"))
        };
        let kind = match self.kind.as_str() {
            "data" => FrameKind::Data,
            "remote" => FrameKind::Remote,
            "fd" => FrameKind::Fd { brs: self.brs, esi: self.esi },
            other => panic!("unknown kind {other}"),
        };
        let data: Vec<u8> = (0..self.data.len() / 2)
            .map(|i| u8::from_str_radix(&self.data[2 * i..2 * i + 2], 16).expect("hex"))
            .collect();
        Frame::new(id.expect("an identifier in range"), kind, self.dlc, &data).expect("a frame")
    }

    fn fd_crc(&self) -> FdCrc {
        if self.iso == Some(false) { FdCrc::NonIso } else { FdCrc::Iso }
    }

    /// The CRC that the bits between the end of the data and the CRC delimiter carry.
    fn crc_on_the_wire(&self, encoded: &EncodedFrame) -> u32 {
        let bits: Vec<u32> =
            encoded.bits.iter().map(|level| (level == Level::Recessive).into()).collect();
        let bits = &bits[..encoded.crc_delimiter];
        match self.frame().kind() {
            FrameKind::Fd { .. } => {
                let width: usize = if self.data.len() / 2 <= 16 { 17 } else { 21 };
                let count = if self.fd_crc() == FdCrc::Iso { 4 } else { 0 };
                let length = count + width + (count + width).div_ceil(4);
                let field = &bits[bits.len() - length..];
                let plain =
                    field.iter().enumerate().filter(|(i, _)| i % 5 != 0).map(|(_, bit)| bit);
                plain.skip(count).fold(0, |value, bit| value << 1 | bit)
            }
            FrameKind::Data | FrameKind::Remote => {
                let plain = unstuff(bits);
                plain[plain.len() - 15..].iter().fold(0, |value, bit| value << 1 | bit)
            }
        }
    }

    /// Everything in which the encoder differs from the vector.
    fn differences(&self) -> Vec<String> {
        let encoded = encode(&self.frame(), self.fd_crc());
        let bits: String = encoded
            .bits
            .iter()
            .map(|level| if level == Level::Dominant { '0' } else { '1' })
            .collect();
        let mut differences = Vec::new();
        let mut compare = |what: &str, got: String, wanted: String| {
            if got != wanted {
                differences.push(format!("{what}: {got}, wanted {wanted}"));
            }
        };
        compare("bits", bits, self.bits.clone());
        compare("stuff bits", encoded.stuff_bits.to_string(), self.stuff_bits.to_string());
        let delimiter = encoded.crc_delimiter;
        compare("CRC delimiter", delimiter.to_string(), self.crc_delimiter.to_string());
        compare("BRS", format!("{:?}", encoded.brs), format!("{:?}", self.brs_index));
        compare("CRC", format!("{:x}", self.crc_on_the_wire(&encoded)), self.crc.clone());
        differences
    }
}

/// Classic bits without their stuff bits.
fn unstuff(bits: &[u32]) -> Vec<u32> {
    let mut plain = Vec::new();
    let mut run = 0;
    let mut last = None;
    for &bit in bits {
        if run == 5 {
            run = 1;
        } else {
            plain.push(bit);
            run = if last == Some(bit) { run + 1 } else { 1 };
        }
        last = Some(bit);
    }
    plain
}

#[test]
fn encoder_agrees_with_every_vector() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vectors/bits");
    let mut count = 0;
    let mut wrong = Vec::new();
    for entry in fs::read_dir(&folder).expect("the vectors are part of the project") {
        let path = entry.expect("a readable folder").path();
        let text = fs::read_to_string(&path).expect("a readable vector file");
        let file: File =
            toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let file_name = path.file_name().expect("a file").to_string_lossy();
        for vector in file.frame {
            count += 1;
            let differences = vector.differences();
            wrong.extend(differences.iter().map(|d| format!("{file_name}, {}: {d}", vector.name)));
        }
    }
    assert!(wrong.is_empty(), "{} of {count} differ:\n{}", wrong.len(), wrong.join("\n"));
    assert!(count >= 400, "only {count} vectors in {}", folder.display());
}

fn ours(kind: CrcKind, bytes: &[u8]) -> u32 {
    let mut crc = Crc::new(kind);
    for byte in bytes {
        crc.push_bits(u32::from(*byte), 8);
    }
    crc.value()
}

/// The CRC-17 and CRC-21 of ISO 11898-1 start with a one in the highest place, which the
/// catalogue (it describes the original definition) does not.
const ISO_17: crc::Algorithm<u32> = crc::Algorithm { init: 1 << 16, ..crc::CRC_17_CAN_FD };
const ISO_21: crc::Algorithm<u32> = crc::Algorithm { init: 1 << 20, ..crc::CRC_21_CAN_FD };

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(11898),
        ..ProptestConfig::default()
    })]

    #[test]
    fn crcs_agree_with_the_catalogue(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
        let crc15 = crc::Crc::<u16>::new(&crc::CRC_15_CAN).checksum(&bytes);
        prop_assert_eq!(ours(CrcKind::CRC15, &bytes), u32::from(crc15));
        let pairs = [
            (CrcKind::CRC17_NON_ISO, &crc::CRC_17_CAN_FD),
            (CrcKind::CRC21_NON_ISO, &crc::CRC_21_CAN_FD),
            (CrcKind::CRC17, &ISO_17),
            (CrcKind::CRC21, &ISO_21),
        ];
        for (kind, algorithm) in pairs {
            let wanted = crc::Crc::<u32>::new(algorithm).checksum(&bytes);
            prop_assert_eq!(ours(kind, &bytes), wanted, "{}", algorithm.width);
        }
    }

    /// However the bits are handed over, the CRC is the same.
    #[test]
    fn crc_does_not_depend_on_how_the_bits_are_cut(
        bits in any::<u64>(),
        cuts in proptest::collection::vec(1_u32..=32, 2..8),
    ) {
        for kind in [CrcKind::CRC15, CrcKind::CRC17, CrcKind::CRC21] {
            let mut whole = Crc::new(kind);
            let mut parts = Crc::new(kind);
            let mut left = 64;
            for cut in cuts.iter().chain([&32, &32, &32]) {
                let count = (*cut).min(left);
                left -= count;
                let part = (bits >> left) & ((1 << count) - 1);
                parts.push_bits(part as u32, count);
            }
            for place in (0..64).rev() {
                whole.push_bits((bits >> place) as u32 & 1, 1);
            }
            prop_assert_eq!(left, 0);
            prop_assert_eq!(whole.value(), parts.value());
        }
    }
}
