//! Addresses, node-IDs and bit rates as the user writes them.

use canbaud::lss::{LssAddress, NodeId, RateSetting, TABLE};

/// What to set a device to: an index of bit timing table 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TableIndex(pub(crate) u8);

pub(super) fn address(text: &str) -> Result<LssAddress, String> {
    let numbers: Option<Vec<u32>> = text
        .split(':')
        .map(|part| {
            let digits = part.strip_prefix("0x").unwrap_or(part);
            let hex = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
            if hex { u32::from_str_radix(digits, 16).ok() } else { None }
        })
        .collect();
    match numbers.as_deref() {
        Some(&[vendor, product, revision, serial]) => {
            Ok(LssAddress::new(vendor, product, revision, serial))
        }
        _ => Err("four hexadecimal numbers up to FFFFFFFF are wanted: 29C:1:10002:1267".to_owned()),
    }
}

pub(super) fn node_id(text: &str) -> Result<NodeId, String> {
    let id = text.parse().ok().and_then(NodeId::new);
    id.ok_or_else(|| "allowed are 1 to 127, and 255 for none".to_owned())
}

pub(super) fn table_index(text: &str) -> Result<TableIndex, String> {
    if let Some(index) = text.strip_prefix("index:") {
        return index.parse().map(TableIndex).map_err(|_| "an index is 0 to 255".to_owned());
    }
    let setting = match text {
        "auto" | "automatic" => RateSetting::Automatic,
        _ => RateSetting::Fixed(text.parse().map_err(|error| format!("{error}"))?),
    };
    setting.index().map(TableIndex).ok_or_else(|| {
        let rates = TABLE.iter().filter_map(|row| row.setting).filter_map(RateSetting::bitrate);
        let rates: Vec<_> = rates.map(|rate| rate.to_string()).collect();
        format!("the bit timing table of CiA has {}, and auto", rates.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_four_hexadecimal_numbers() {
        let want = LssAddress::new(0x29C, 1, 0x1_0002, 0xFFFF_FFFF);
        assert_eq!(address("29c:0x1:10002:FFFFFFFF"), Ok(want));
        assert_eq!(address(&want.to_string()), Ok(want));
        for bad in ["", "1:2:3", "1:2:3:4:5", "1:2:3:+4", "1:2:3:100000000", "1:2::4"] {
            assert!(address(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn rates_are_those_of_the_table_and_5_is_sent_by_its_number_alone() {
        assert_eq!(table_index("500k"), Ok(TableIndex(2)));
        assert_eq!(table_index("auto"), Ok(TableIndex(9)));
        assert_eq!(table_index("index:5"), Ok(TableIndex(5)));
        let refused = table_index("100k").unwrap_err();
        assert!(
            refused.contains("1M, 800k, 500k, 250k, 125k, 50k, 20k, 10k, and auto"),
            "{refused}"
        );
    }

    #[test]
    fn node_ids_are_1_to_127_and_255() {
        assert!(node_id("127").is_ok() && node_id("255").is_ok());
        assert!(node_id("0").is_err() && node_id("128").is_err() && node_id("x").is_err());
    }
}
