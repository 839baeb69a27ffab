//! The tables of `docs/accuracy.md`: which cases are in them and how they read.

use canbaud_sim::benchmark::{
    ASYMMETRIES, BITRATES, Case, LOADS, PLAIN, PPM, SCENES, Scene, TIMERS, TRAFFIC, Traffic,
};

use crate::case::{Draw, scene_name, traffic_name};
use crate::tally::{Mistake, Tally};
use crate::work;

/// The seed that every other one is made of.
pub const SEED: u64 = 2925;
/// Frames asked for in one capture: more than a hundred dominant levels.
const FRAMES: u32 = 12;
/// Timer clocks of the tables whose rows are something else.
const CLOCKS: [u64; 3] = [2_000_000, 8_000_000, 72_000_000];
/// Timer clocks of the tables about CAN FD.
const FD_CLOCKS: [u64; 3] = [16_000_000, 24_000_000, 72_000_000];
/// Nominal rates of the tables about CAN FD.
const FD_BITRATES: [u32; 4] = [125_000, 250_000, 500_000, 1_000_000];
/// Jitters in ns.
const JITTERS: [u32; 5] = [0, 10, 50, 100, 200];
/// Captures of each rate in a row.
const PER_RATE: u64 = 20;
/// Captures of each cell of rates and clocks.
const PER_CELL: u64 = 40;

/// A table: a name, how to make it.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// The section of the document.
    pub name: &'static str,
    make: fn(&str) -> Made,
}

/// What a table looks like, and what was wrong in it.
#[derive(Debug, Clone)]
pub struct Made {
    /// Markdown.
    pub text: String,
    /// Every wrong answer.
    pub mistakes: Vec<Mistake>,
    /// Cases that were run.
    pub cases: u64,
}

/// All tables, in the order of the document.
pub const TABLES: [Table; 9] = [
    Table { name: "rates-and-clocks", make: rates_and_clocks },
    Table { name: "asymmetry", make: asymmetry },
    Table { name: "jitter", make: jitter },
    Table { name: "clock-error", make: clock_error },
    Table { name: "load", make: load },
    Table { name: "scenes", make: scenes },
    Table { name: "babbler", make: babbler },
    Table { name: "can-fd", make: can_fd },
    Table { name: "can-fd-asymmetry", make: can_fd_asymmetry },
];

impl Table {
    /// Runs its cases.
    #[must_use]
    pub fn make(&self) -> Made {
        (self.make)(self.name)
    }
}

/// Seeds differ from table to table, so that no two share their luck.
fn seed(table: &str, number: u64) -> u64 {
    let hash = table.bytes().fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    });
    // Short enough to type.
    (hash ^ SEED).wrapping_add(number.wrapping_mul(0x9E37_79B9_7F4A_7C15)) >> 32
}

/// `count` captures of each case.
fn draws(table: &str, row: usize, cases: &[Case], count: u64) -> Vec<Draw> {
    let all = cases.iter().flat_map(|case| (0..count).map(move |_| *case));
    let first = (row as u64) << 32;
    (first..)
        .zip(all)
        .map(|(number, case)| Draw { case, seed: seed(table, number), frames: FRAMES })
        .collect()
}

fn tally(draws: &[Draw]) -> Tally {
    let mut tally = Tally::default();
    for (draw, outcome) in draws.iter().zip(work::run(draws)) {
        if let Some(outcome) = outcome {
            tally.add(draw, &outcome);
        }
    }
    tally
}

/// Every rate of the grid with what `base` says otherwise.
fn all_rates(base: Case) -> Vec<Case> {
    BITRATES.map(|bitrate| Case { bitrate, ..base }).to_vec()
}

fn megahertz(hertz: u64) -> String {
    format!("{} MHz", hertz / 1_000_000)
}

fn kilobits(bitrate: u32) -> String {
    match bitrate % 1_000 {
        0 => format!("{}", bitrate / 1_000),
        rest => format!("{}.{rest:03}", bitrate / 1_000),
    }
}

/// A row: what it is about, its cases.
type Row = (Vec<String>, Vec<Case>);

/// A table with the usual columns after those of `heads`.
fn usual(table: &str, heads: &[&str], all: Vec<Row>) -> Made {
    rows(table, heads, (Tally::HEADING, Tally::COLUMNS), all, Tally::row)
}

fn rows(
    table: &str,
    heads: &[&str],
    (heading, columns): (&str, usize),
    all: Vec<Row>,
    print: fn(&Tally) -> String,
) -> Made {
    let mut text = format!("| {} | {heading} |\n", heads.join(" | "));
    text += &format!("|{}\n", "---|".repeat(heads.len() + columns));
    let (mut mistakes, mut cases) = (Vec::new(), 0);
    for (row, (labels, grid)) in all.into_iter().enumerate() {
        let tally = tally(&draws(table, row, &grid, PER_RATE));
        text += &format!("| {} | {} |\n", labels.join(" | "), print(&tally));
        cases += tally.cases;
        mistakes.extend(tally.wrong);
    }
    Made { text, mistakes, cases }
}

/// One row for each value at each of the three clocks, over all rates.
fn by_value<T: Copy>(
    table: &str,
    head: &str,
    values: &[T],
    label: fn(T) -> String,
    set: fn(T, Case) -> Case,
) -> Made {
    let all = values.iter().flat_map(|value| CLOCKS.map(|timer_hz| (*value, timer_hz)));
    let grid = all.map(|(value, timer_hz)| {
        let base = set(value, Case { timer_hz, ..PLAIN });
        (vec![label(value), megahertz(timer_hz)], all_rates(base))
    });
    usual(table, &[head, "timer"], grid.collect())
}

fn asymmetry(table: &str) -> Made {
    let label = |ns: i32| format!("{ns} ns");
    let set = |asymmetry_ns, case| Case { asymmetry_ns, ..case };
    by_value(table, "dominant longer by", &ASYMMETRIES, label, set)
}

fn jitter(table: &str) -> Made {
    let set = |jitter_ns, case| Case { jitter_ns, ..case };
    by_value(table, "jitter up to", &JITTERS, |ns| format!("{ns} ns"), set)
}

fn clock_error(table: &str) -> Made {
    let set = |ppm, case| Case { ppm, ..case };
    by_value(table, "clock error", &PPM, |ppm| format!("{ppm} ppm"), set)
}

fn load(table: &str) -> Made {
    let label = |permille: u32| format!("{}.{} %", permille / 10, permille % 10);
    let set = |load_permille, case| Case { load_permille, ..case };
    by_value(table, "load", &LOADS, label, set)
}

fn scenes(table: &str) -> Made {
    let set = |scene: Scene, case| Case { scene, ..case };
    let one_rate: Vec<_> = SCENES.into_iter().filter(|scene| *scene != Scene::Babbler).collect();
    by_value(table, "scene", &one_rate, scene_name, set)
}

/// Two rates on one bus: which of them is said.
fn babbler(table: &str) -> Made {
    let grid = CLOCKS.map(|timer_hz| {
        let base = Case { scene: Scene::Babbler, timer_hz, ..PLAIN };
        (vec![megahertz(timer_hz)], all_rates(base))
    });
    let columns = (Tally::BABBLER_HEADING, Tally::BABBLER_COLUMNS);
    rows(table, &["timer"], columns, grid.to_vec(), Tally::babbler_row)
}

/// Nominal rates that are slower than the data rate.
fn fd_rates(base: Case) -> Vec<Case> {
    let slower = |bitrate: &u32| match base.traffic {
        Traffic::Classic | Traffic::Fd => true,
        Traffic::FdBrs(rate) | Traffic::FdBrsNonIso(rate) => *bitrate < rate,
    };
    let rates = FD_BITRATES.into_iter().filter(slower);
    rates.map(|bitrate| Case { bitrate, ..base }).collect()
}

fn can_fd(table: &str) -> Made {
    let all = TRAFFIC.iter().flat_map(|traffic| FD_CLOCKS.map(|timer_hz| (*traffic, timer_hz)));
    let grid = all.map(|(traffic, timer_hz)| {
        let base = Case { traffic, timer_hz, ..PLAIN };
        (vec![traffic_name(traffic), megahertz(timer_hz)], fd_rates(base))
    });
    usual(table, &["frames", "timer"], grid.collect())
}

fn can_fd_asymmetry(table: &str) -> Made {
    let all = [2_000_000, 5_000_000]
        .into_iter()
        .flat_map(|rate| ASYMMETRIES.map(|asymmetry_ns| (Traffic::FdBrs(rate), asymmetry_ns)));
    let grid = all.map(|(traffic, asymmetry_ns)| {
        let base = Case { traffic, asymmetry_ns, timer_hz: 72_000_000, ..PLAIN };
        (vec![traffic_name(traffic), format!("{asymmetry_ns} ns")], fd_rates(base))
    });
    usual(table, &["frames", "dominant longer by"], grid.collect())
}

/// Each rate with each clock: right answers of both methods, and wrong ones after a slash.
fn rates_and_clocks(table: &str) -> Made {
    let clocks = TIMERS.map(megahertz).join(" | ");
    let mut text = format!("Of {PER_CELL} captures each, right / wrong: ours, then AP2925.\n\n");
    text += &format!("| kbit/s | {clocks} |\n|{}\n", "---|".repeat(TIMERS.len() + 1));
    let (mut total, mut row) = (Tally::default(), 0);
    for bitrate in BITRATES {
        text += &format!("| {} |", kilobits(bitrate));
        for timer_hz in TIMERS {
            let cell = tally(&draws(table, row, &[Case { bitrate, timer_hz, ..PLAIN }], PER_CELL));
            let (right, wrong) = cell.minimum;
            text += &format!(" {}/{}, {right}/{wrong} |", cell.right, cell.wrong.len());
            total.merge(&cell);
            row += 1;
        }
        text.push('\n');
    }
    text += &format!("\n| | {} |\n|{}\n", Tally::HEADING, "---|".repeat(Tally::COLUMNS + 1));
    text += &format!("| all of them | {} |\n", total.row());
    Made { text, cases: total.cases, mistakes: total.wrong }
}

/// Every wrong answer with the command that repeats it.
#[must_use]
pub fn mistakes(made: &[(&str, &[Mistake])]) -> String {
    let mut text = String::new();
    for (table, mistakes) in made {
        for mistake in *mistakes {
            let Mistake { draw, what } = mistake;
            text += &format!(
                "- {table}, {what}: `cargo run --release -p canbaud-bench -- --case {draw}`\n"
            );
        }
    }
    if text.is_empty() { "None.\n".into() } else { text }
}
