//! `key = value` text in `[sections]`, as sigrok and DSView write it.

/// The pairs of a text: section, key and value, all trimmed; section and key in lower case.
pub(crate) struct Ini<'a> {
    pairs: Vec<(String, String, &'a str)>,
}

impl<'a> Ini<'a> {
    pub(crate) fn parse(text: &'a str) -> Self {
        let mut section = String::new();
        let mut pairs = Vec::new();
        for line in text.split(['\r', '\n']).map(str::trim) {
            if line.starts_with(['#', ';']) {
                continue;
            }
            if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                section = name.trim().to_ascii_lowercase();
            } else if let Some((key, value)) = line.split_once('=') {
                pairs.push((section.clone(), key.trim().to_ascii_lowercase(), value.trim()));
            }
        }
        Self { pairs }
    }

    /// The value of `key` in `section`.
    pub(crate) fn get(&self, section: &str, key: &str) -> Option<&'a str> {
        self.pairs.iter().find(|(s, k, _)| s == section && k == key).map(|&(_, _, value)| value)
    }

    /// Keys of `section` that are `prefix` and a number, with that number and the value.
    pub(crate) fn numbered<'s>(
        &'s self,
        section: &'s str,
        prefix: &'s str,
    ) -> impl Iterator<Item = (u32, &'a str)> + 's {
        self.pairs.iter().filter(move |(s, _, _)| s == section).filter_map(
            move |(_, key, value)| {
                let number = key.strip_prefix(prefix)?.trim();
                number
                    .bytes()
                    .all(|b| b.is_ascii_digit())
                    .then(|| number.parse().ok())?
                    .map(|n| (n, *value))
            },
        )
    }

    pub(crate) fn has_section(&self, section: &str) -> bool {
        self.pairs.iter().any(|(s, _, _)| s == section)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_both_spellings_and_every_line_end() {
        let ini = Ini::parse(
            "[global]\r\nsigrok version = 0.2.0\r[Device 1]\n# probe9=no\nProbe3=CAN_RX\n\rtotal probes=8\n",
        );
        assert_eq!(ini.get("global", "sigrok version"), Some("0.2.0"));
        assert_eq!(ini.get("device 1", "total probes"), Some("8"));
        assert_eq!(ini.numbered("device 1", "probe").collect::<Vec<_>>(), [(3, "CAN_RX")]);
    }
}
