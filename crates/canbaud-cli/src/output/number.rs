//! Numbers as people read them: units, thousands separators, no false digits.

/// `1234567` as `1,234,567`.
pub(super) fn thousands(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `500000` as `500 kbit/s`, exactly.
pub(crate) fn bitrate(bits_per_second: u32) -> String {
    let (unit, digits, word) = match bits_per_second {
        0..1_000 => (1, 0, "bit/s"),
        1_000..1_000_000 => (1_000, 3, "kbit/s"),
        _ => (1_000_000, 6, "Mbit/s"),
    };
    let whole = bits_per_second / unit;
    let fraction = format!("{:0digits$}", bits_per_second % unit);
    match fraction.trim_end_matches('0') {
        "" => format!("{whole} {word}"),
        fraction => format!("{whole}.{fraction} {word}"),
    }
}

/// A small positive quantity to two significant digits below 10, whole from there on.
pub(super) fn short(value: f64) -> String {
    match value.abs() {
        v if !v.is_finite() => "?".to_owned(),
        0.0 => "0".to_owned(),
        v if v < 0.01 => "<0.01".to_owned(),
        v if v < 1.0 => format!("{v:.2}"),
        v if v < 9.95 => format!("{v:.1}"),
        v => thousands(v.round() as u64),
    }
}

/// `+10 ppm`, `-478 ppm`, `+0.3 ppm`.
pub(super) fn signed_ppm(value: f64) -> String {
    let sign = if value < 0.0 { '-' } else { '+' };
    format!("{sign}{} ppm", short(value))
}

/// `+10.2 ± 3.1`: no more decimals than the uncertainty allows.
pub(super) fn with_uncertainty(value: f64, uncertainty: f64) -> String {
    let decimals = match uncertainty {
        u if u >= 10.0 => 0,
        u if u >= 1.0 => 1,
        _ => 2,
    };
    format!("{value:+.decimals$} ± {uncertainty:.decimals$}")
}

/// How far `measured` lies above `wanted`, in parts per million.
pub(super) fn deviation_ppm(measured: f64, wanted: u32) -> f64 {
    (measured / f64::from(wanted) - 1.0) * 1e6
}

/// `0.312` as `31.2 %`.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// Seconds with the unit that keeps the number between 1 and 1000.
pub(super) fn duration(seconds: f64) -> String {
    match seconds {
        s if s >= 60.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.2} ms", s * 1e3),
        s => format!("{:.1} us", s * 1e6),
    }
}

/// A bound on a probability, rounded up to a power of ten.
pub(super) fn bound(probability: f64) -> String {
    if probability <= 0.0 {
        // Smaller than a double can hold.
        return "< 1e-300".to_owned();
    }
    if probability > 0.1 {
        return format!("≤ {:.2}", probability.min(1.0));
    }
    format!("≤ 1e{}", (probability.log10() - 1e-9).ceil() as i32)
}

/// `1 frame`, `2 frames`.
pub(crate) fn count(value: u64, one: &str, many: &str) -> String {
    format!("{} {}", thousands(value), if value == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped_from_the_right() {
        let texts = [0, 999, 1_000, 85_806, 1_234_567].map(thousands);
        assert_eq!(texts, ["0", "999", "1,000", "85,806", "1,234,567"]);
    }

    #[test]
    fn rates_carry_the_unit_people_say() {
        let texts = [500_000, 33_333, 83_330, 1_000_000, 1_880_000, 950].map(bitrate);
        assert_eq!(
            texts,
            ["500 kbit/s", "33.333 kbit/s", "83.33 kbit/s", "1 Mbit/s", "1.88 Mbit/s", "950 bit/s"]
        );
    }

    #[test]
    fn no_digits_beyond_what_is_known() {
        assert_eq!(
            [0.0, 0.004, 0.123, 3.21, 12.7, 1_500.2].map(short),
            ["0", "<0.01", "0.12", "3.2", "13", "1,500"]
        );
        assert_eq!(signed_ppm(-478.2), "-478 ppm");
        assert_eq!(signed_ppm(0.31), "+0.31 ppm");
        assert_eq!(with_uncertainty(-477.96, 12.3), "-478 ± 12");
        assert_eq!(with_uncertainty(10.04, 0.5), "+10.04 ± 0.50");
    }

    #[test]
    fn a_bound_is_never_rounded_down() {
        assert_eq!(bound(2.1e-14), "≤ 1e-13");
        assert_eq!(bound(1e-14), "≤ 1e-14");
        assert_eq!(bound(0.0), "< 1e-300");
        assert_eq!(bound(0.5), "≤ 0.50");
    }

    #[test]
    fn durations_have_the_unit_that_fits() {
        let texts = [345.1, 1.748, 0.002, 0.000_265].map(duration);
        assert_eq!(texts, ["5 min 45 s", "1.75 s", "2.00 ms", "265.0 us"]);
    }

    #[test]
    fn deviation_is_signed() {
        assert!((deviation_ppm(499_761.0, 500_000) + 478.0).abs() < 0.01);
    }
}
