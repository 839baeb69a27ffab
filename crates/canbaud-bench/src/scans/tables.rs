//! The tables about scans.

use canbaud::detect::scan::{Evidence, Policy};
use canbaud::units::Micros;
use canbaud_link::sim::trial::{Audience, Load};
use canbaud_link::sim::{Adapter, SimError};

use super::{Campaign, Score};

/// A table: a name, how to make it.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// The section of the document.
    pub name: &'static str,
    /// Markdown.
    pub make: fn() -> Result<String, SimError>,
}

/// All of them, in the order of the document.
pub const TABLES: [Table; 4] = [
    Table { name: "scans-messages", make: messages },
    Table { name: "scans-loads", make: loads },
    Table { name: "scans-destroyed", make: destroyed },
    Table { name: "scans-alone", make: alone },
];

const POLICIES: [Policy; 3] = [Policy::Weighing, Policy::Koppe, Policy::FixedDwell];

const PLAIN: Campaign = Campaign {
    adapter: Adapter::embedded(),
    policy: Policy::Weighing,
    load: Load::Every(Micros::from_ms(100)),
    audience: Audience::Acknowledges,
    destroyed: 0,
    each: 50,
    limit: Micros::from_ms(30_000),
};

fn adapters() -> [(&'static str, Adapter); 4] {
    [
        ("errors, at once", Adapter::embedded()),
        ("errors, each 1 ms", Adapter::usb(Evidence::Errors)),
        ("counter, each 1 ms", Adapter::usb(Evidence::Counter)),
        ("frames only", Adapter::usb(Evidence::FramesOnly)),
    ]
}

fn head(columns: &[&str]) -> String {
    let line: Vec<_> = columns.iter().map(|_| "---").collect();
    format!("| {} |\n|{}|\n", columns.join(" | "), line.join("|"))
}

fn row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

fn found(score: &Score) -> String {
    if score.right == score.trials { "all".into() } else { score.percent(score.right) }
}

/// Frames further apart than T_cc, as Koppe's figure 2 wants them.
fn messages() -> Result<String, SimError> {
    let mut text = head(&["adapter", "T_cc", "policy", "found", "frames", "time", "wrong"]);
    for (name, adapter) in adapters() {
        for t_cc in [1, 10, 50] {
            let adapter = adapter.with_reconfiguration(Micros::from_ms(t_cc));
            for policy in POLICIES {
                if policy == Policy::Koppe && adapter.evidence == Evidence::FramesOnly {
                    continue;
                }
                let score = Campaign { adapter, policy, ..PLAIN }.run(1)?;
                text += &row(&[
                    name.into(),
                    format!("{t_cc} ms"),
                    policy.name().into(),
                    found(&score),
                    score.frames_text(),
                    score.time_text(),
                    score.wrong.to_string(),
                ]);
            }
        }
    }
    Ok(text)
}

fn loads() -> Result<String, SimError> {
    let mut text = head(&["adapter", "load", "policy", "found", "frames", "time", "wrong"]);
    for (name, adapter) in adapters().into_iter().take(3) {
        for percent in [1, 10, 50, 90] {
            for policy in [Policy::Weighing, Policy::Koppe] {
                let load = Load::Permille(percent * 10);
                let campaign = Campaign { adapter, policy, load, each: 20, ..PLAIN };
                let score = campaign.run(2)?;
                text += &row(&[
                    name.into(),
                    format!("{percent} %"),
                    policy.name().into(),
                    found(&score),
                    score.frames_text(),
                    score.time_text(),
                    score.wrong.to_string(),
                ]);
            }
        }
    }
    Ok(text)
}

fn destroyed() -> Result<String, SimError> {
    let columns = ["adapter", "destroyed", "policy", "left it", "found", "frames", "time", "wrong"];
    let mut text = head(&columns);
    for (name, adapter) in adapters().into_iter().take(3) {
        for percent in [5, 20] {
            for policy in [Policy::Weighing, Policy::Koppe] {
                let load = Load::Permille(100);
                let (destroyed, each) = (percent * 10, 250);
                let campaign = Campaign { adapter, policy, load, destroyed, each, ..PLAIN };
                let score = campaign.run(3)?;
                text += &row(&[
                    name.into(),
                    format!("{percent} %"),
                    policy.name().into(),
                    score.percent(score.left),
                    found(&score),
                    score.frames_text(),
                    score.time_text(),
                    score.wrong.to_string(),
                ]);
            }
        }
    }
    Ok(text)
}

/// A lone sender: it repeats its first frame, error active 16 times, error passive from then on.
fn alone() -> Result<String, SimError> {
    let mut text = head(&["adapter", "policy", "found", "left it", "time", "wrong"]);
    for (name, adapter) in adapters().into_iter().take(3) {
        for policy in [Policy::Weighing, Policy::Koppe] {
            let audience = Audience::Nobody;
            let limit = Micros::from_ms(5_000);
            let campaign = Campaign { adapter, policy, audience, each: 5, limit, ..PLAIN };
            let score = campaign.run(4)?;
            text += &row(&[
                name.into(),
                policy.name().into(),
                found(&score),
                score.percent(score.left),
                score.time_text(),
                score.wrong.to_string(),
            ]);
        }
    }
    Ok(text)
}
