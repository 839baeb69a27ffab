//! What running a row shows.

use canbaud_sim::Span;

/// Figures, and what did not hold.
#[derive(Debug, Clone, Default)]
pub struct Finding {
    /// Text for people, in Markdown.
    pub lines: Vec<String>,
    /// Where a document is wrong.
    pub errata: Vec<String>,
    /// What should hold and did not.
    pub failures: Vec<String>,
}

impl Finding {
    pub(crate) fn line(&mut self, text: impl Into<String>) {
        self.lines.push(text.into());
    }

    pub(crate) fn erratum(&mut self, text: impl Into<String>) {
        self.errata.push(text.into());
    }

    /// Notes a failure unless `holds`.
    pub(crate) fn require(&mut self, holds: bool, what: impl Into<String>) {
        if !holds {
            self.failures.push(what.into());
        }
    }

    /// The value, or a failure.
    pub(crate) fn need<T>(&mut self, value: Option<T>, what: impl Into<String>) -> Option<T> {
        if value.is_none() {
            self.failures.push(what.into());
        }
        value
    }

    /// A table; the first row is its head.
    pub(crate) fn table(&mut self, rows: &[Vec<String>]) {
        let mut text: Vec<String> =
            rows.iter().map(|row| format!("| {} |", row.join(" | "))).collect();
        let columns = rows.first().map_or(0, Vec::len);
        text.insert(1.min(text.len()), format!("|{}", "---|".repeat(columns)));
        self.lines.push(format!("\n{}\n", text.join("\n")));
    }
}

/// Cells of a table row.
macro_rules! cells {
    ($($cell:expr),* $(,)?) => { vec![$(format!("{}", $cell)),*] };
}
pub(crate) use cells;

/// Milliseconds, or seconds from 1 s on, with two decimals.
pub(crate) fn ms(span: Span) -> String {
    let seconds = span.seconds();
    if seconds >= 1.0 { format!("{seconds:.2} s") } else { format!("{:.2} ms", seconds * 1e3) }
}

/// A bit rate in kbit/s.
pub(crate) fn kbits(bitrate: u32) -> String {
    format!("{} kbit/s", f64::from(bitrate) / 1e3)
}
