//! Which analogue channels are the two wires of one bus.

use crate::capture::{Channel, ChannelKind};

/// The differences worth trying: wires that pair by name; else the only two analogue channels.
///
/// Where names say nothing the sign is arbitrary: a difference the wrong way round is an inverted
/// bus, and the polarity is found anyway.
pub(crate) fn differences(channels: &[Channel]) -> Vec<Channel> {
    let analogue: Vec<(usize, &Channel)> =
        channels.iter().enumerate().filter(|(_, c)| c.kind == ChannelKind::Analogue).collect();
    let mut pairs = Vec::new();
    for &(high, channel) in &analogue {
        let Some((stem, Wire::High)) = wire(&channel.name) else { continue };
        let low =
            analogue.iter().find(|(_, other)| wire(&other.name) == Some((stem.clone(), Wire::Low)));
        if let Some(&(low, _)) = low {
            pairs.push((high, low));
        }
    }
    if let ([], [(first, _), (second, _)]) = (pairs.as_slice(), analogue.as_slice()) {
        pairs.push((*first, *second));
    }
    let difference = |(high, low): (usize, usize)| {
        let (a, b) = (channels.get(high)?, channels.get(low)?);
        let resolution = a.resolution_ticks.max(b.resolution_ticks);
        let name = format!("{}-{}", a.name, b.name);
        Some(Channel::new(name, ChannelKind::Difference(high, low), resolution))
    };
    pairs.into_iter().filter_map(difference).collect()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wire {
    High,
    Low,
}

/// The wire that a name ends with, and what precedes it: `CAN_H`, `can-l`, `CAN1H`, `CAN High`.
fn wire(name: &str) -> Option<(String, Wire)> {
    let letters: String =
        name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
    let endings = [
        ("high", Wire::High),
        ("low", Wire::Low),
        ("hi", Wire::High),
        ("lo", Wire::Low),
        ("h", Wire::High),
        ("l", Wire::Low),
    ];
    endings
        .into_iter()
        .find_map(|(ending, wire)| Some((letters.strip_suffix(ending)?.to_owned(), wire)))
        .filter(|(stem, _)| stem.is_empty() || stem.starts_with("can") || stem.ends_with("can"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(names: &[&str]) -> Vec<String> {
        let channels: Vec<Channel> =
            names.iter().map(|n| Channel::new(*n, ChannelKind::Analogue, 1)).collect();
        differences(&channels).into_iter().map(|c| c.name).collect()
    }

    #[test]
    fn wires_pair_by_name_whatever_the_order() {
        assert_eq!(pairs(&["CANL", "CANH"]), ["CANH-CANL"]);
        assert_eq!(pairs(&["can-h", "supply", "can-l"]), ["can-h-can-l"]);
        assert_eq!(
            pairs(&["CAN1_H", "CAN2_H", "CAN2_L", "CAN1_L"]),
            ["CAN1_H-CAN1_L", "CAN2_H-CAN2_L"]
        );
        assert_eq!(pairs(&["L", "H"]), ["H-L"]);
        assert_eq!(pairs(&["CAN High", "CAN Low"]), ["CAN High-CAN Low"]);
    }

    #[test]
    fn two_nameless_channels_pair_and_three_do_not() {
        assert_eq!(pairs(&["CH1", "CH2"]), ["CH1-CH2"]);
        assert!(pairs(&["CH1", "CH2", "CH3"]).is_empty());
        assert!(pairs(&["CH1"]).is_empty());
    }
}
