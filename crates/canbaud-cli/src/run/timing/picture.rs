//! A small picture of the bit.

use canbaud::timing::BitTiming;

/// Characters for a whole bit.
const WIDTH: u32 = 64;

/// Two lines: the segments to scale, and an arrow at the sample point.
pub(super) fn picture(timing: &BitTiming) -> [String; 2] {
    let quanta = timing.quanta();
    let prop = u32::from(timing.prop_seg);
    let ends = [1, 1 + prop, 1 + timing.tseg1(), quanta];
    let names = ["SYNC", "PROP", "PS1", "PS2"];
    let mut line = String::from("|");
    let mut column = 0;
    let mut arrow = 0;
    for (index, (end, name)) in ends.into_iter().zip(names).enumerate() {
        let start = if index == 0 { 0 } else { ends[index - 1] };
        if end == start {
            continue;
        }
        // Never too narrow for the name, so that no segment disappears.
        let scaled = (end - start) * WIDTH / quanta;
        let width = scaled.max(name.len() as u32);
        line.push_str(&centred(name, width as usize));
        line.push('|');
        column += width + 1;
        if index == 2 {
            arrow = column;
        }
    }
    let label = format!("sample point {}", timing.sample_point());
    [line, format!("{}^ {label}", " ".repeat(arrow as usize))]
}

fn centred(name: &str, width: usize) -> String {
    format!("{name:-^width$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_to_scale_and_the_arrow_stands_before_phase_seg2() {
        let timing = BitTiming { prescaler: 1, prop_seg: 7, phase_seg1: 4, phase_seg2: 4, sjw: 1 };
        let [line, arrow] = picture(&timing);
        assert_eq!(
            line,
            format!(
                "|SYNC|{}PROP{}|------PS1-------|------PS2-------|",
                "-".repeat(12),
                "-".repeat(12)
            )
        );
        assert_eq!(arrow.find('^'), line.find("|------PS2"));
        assert!(arrow.ends_with("sample point 75.0%"));
    }

    #[test]
    fn a_missing_prop_seg_is_left_out() {
        let timing = BitTiming { prescaler: 1, prop_seg: 0, phase_seg1: 1, phase_seg2: 1, sjw: 1 };
        assert!(!picture(&timing)[0].contains("PROP"));
    }
}
