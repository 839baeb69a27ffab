//! Controllers by name, and the names nearest to a wrong one.

use canbaud::timing::controllers::{self, ALL, Controller};
use canbaud::timing::{Limits, Prescalers, Span};

use super::refusal::Refusal;

/// What every controller after ISO 11898-1 can hold: 8 to 25 quanta and prescalers to 32 in
/// classic CAN; 8 to 80 and 5 to 25 quanta in CAN FD.
pub(super) const ANY: Controller = Controller {
    description: "what any ISO 11898-1 controller can hold",
    clock: "CAN clock",
    data: Some(
        Limits::new(Span::new(1, 16), Span::new(2, 8), 8, Prescalers::range(1, 32))
            .with_bit_quanta(Span::new(5, 25)),
    ),
    source: "ISO 11898-1 as python-can quotes it",
    ..CLASSIC
};

const CLASSIC: Controller = Controller {
    name: "any",
    aliases: &[],
    description: "",
    clock: "",
    nominal: Limits::new(Span::new(2, 16), Span::new(2, 8), 4, Prescalers::range(1, 32))
        .with_bit_quanta(Span::new(8, 25)),
    data: None,
    xl: None,
    prescalers: controllers::PrescalerSharing::OnePerPhase,
    tdc_offset_max: 0,
    registers: &[],
    source: "",
    unconfirmed: None,
};

/// The controller that the user named.
pub(super) fn find(name: &str) -> Result<&'static Controller, Refusal> {
    controllers::find(name).ok_or_else(|| {
        let nearest = nearest(name).join(", ");
        Refusal::usage(
            format!("unknown controller {name:?}; did you mean {nearest}?"),
            Some("canbaud controllers lists all".to_owned()),
        )
    })
}

/// The names or aliases with the fewest differing letters, at most three.
fn nearest(name: &str) -> Vec<&'static str> {
    let given = name.to_ascii_lowercase();
    let mut names: Vec<(usize, &'static str)> = ALL
        .iter()
        .flat_map(|c| c.aliases.iter().copied().chain([c.name]))
        .map(|known| (distance(&given, known), known))
        .collect();
    names.sort_unstable();
    // What differs by much more than the nearest is no help.
    let limit = names.first().map_or(0, |(distance, _)| distance + 1);
    names.into_iter().take(3).filter(|(d, _)| *d <= limit).map(|(_, name)| name).collect()
}

/// Letters to insert, delete or replace (Levenshtein); a name that contains the other is near.
fn distance(a: &str, b: &str) -> usize {
    if a.len() >= 3 && b.contains(a) {
        return 1;
    }
    let a: Vec<char> = a.chars().take(40).collect();
    let mut row: Vec<usize> = (0..=a.len()).collect();
    for (i, letter) in b.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in a.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[a.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_name_gets_the_nearest_ones() {
        assert_eq!(nearest("sja100"), ["sja1000"]);
        assert_eq!(nearest("mcp2516")[..2], ["mcp2510", "mcp2515"]);
        assert!(nearest("STM32").contains(&"stm32f0"));
        assert!(!nearest("").is_empty());
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
