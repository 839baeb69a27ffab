//! What the three source documents describe, row by row, run on the simulator.
//!
//! Each row of [`ROWS`] runs its scenario and gives a [`Finding`]: the figures, and what did not
//! hold. The tests (`tests/mission.rs`) want nothing of the latter; `examples/mission` writes the
//! figures into `docs/mission.md`.

mod ap2925;
mod bench;
mod ds80c390;
mod finding;
mod koppe;
mod koppe_demands;
mod koppe_scan;
mod page;

pub use finding::Finding;
pub use page::page;

/// One row: something that a document describes.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Letter of the document and number.
    pub number: &'static str,
    /// What the document describes.
    pub describes: &'static str,
    /// Where else it is tested, beside `tests/mission.rs`.
    pub tested: &'static str,
    /// Runs it.
    pub run: fn() -> Finding,
}

const fn row(
    number: &'static str,
    describes: &'static str,
    tested: &'static str,
    run: fn() -> Finding,
) -> Row {
    Row { number, describes, tested, run }
}

/// All rows.
pub const ROWS: [Row; 22] = [
    row(
        "A1",
        "Analysing mode: step through a bit timing table, listening only, until there is no error.",
        "`detect::scan`",
        ap2925::a1,
    ),
    row(
        "A2",
        "Controller off, each dominant level timed with the CPU clock, 100 times, take the shortest.",
        "`detect::MinimumPulse`",
        ap2925::a2,
    ),
    row(
        "A3",
        "The acknowledge bit is the one lone dominant bit; that takes two other nodes.",
        "`tests/trials.rs` of canbaud",
        ap2925::a3,
    ),
    row(
        "A4",
        "Calculation tables for f_CPU 24/16/8 and 20/10/5 MHz.",
        "`timing::tables::ap2925`",
        ap2925::a4,
    ),
    row(
        "A5",
        "m = f_CPU · t_CAN, t_CAN = 2 (BRP+1) (1 + (TSEG1+1) + (TSEG2+1)) / f_CPU.",
        "`timing::tables::ap2925`, `timing_registers.rs`",
        ap2925::a5,
    ),
    row(
        "A6",
        "Initialise, wait for RXOK or an error code; on error measure again; then take part and send.",
        "`node::machine`",
        ap2925::a6,
    ),
    row(
        "A7",
        "The polling loop deviates: that is why the table has ranges.",
        "`tests/around.rs` of canbaud-sim",
        ap2925::a7,
    ),
    row(
        "A8",
        "Hot plug into a running system, which is not disturbed.",
        "the checker `silence` of canbaud-sim",
        ap2925::a8,
    ),
    row(
        "K1",
        "CANopen bit rates with quanta and sample points (table 1).",
        "`timing::tables::canopen`",
        koppe::k1,
    ),
    row(
        "K2",
        "LSS, and the dead-lock of a device that is configured by LSS only.",
        "`lss`; scenarios koppe-dead-lock and koppe-dead-lock-cured",
        koppe::k2,
    ),
    row("K3", "Six demands.", "one scenario each", koppe_demands::k3),
    row(
        "K4",
        "Default fallback bit rate, and its drawbacks.",
        "scenario koppe-fallback",
        koppe::k4,
    ),
    row(
        "K5",
        "The timer method wants two active nodes or special data and 10 MHz (table 2).",
        "`timing::tables::canopen`",
        koppe::k5,
    ),
    row(
        "K6",
        "The algorithm of figure 1 takes at most 8 messages.",
        "`detect::scan` with the policy koppe",
        koppe_scan::k6,
    ),
    row(
        "K7",
        "T_cc: the time to set the controller to another rate.",
        "`scan::Capabilities::reconfiguration`",
        koppe_scan::k7,
    ),
    row(
        "K8",
        "AND/OR gate for controllers without bus monitoring (table 3).",
        "`tests/around.rs` of canbaud-sim",
        koppe::k8,
    ),
    row(
        "K9",
        "Traffic needs in three configurations; a mini-master must not detect.",
        "scenarios koppe-configuration-1 to -3, koppe-all-automatic",
        koppe::k9,
    ),
    row(
        "K10",
        "Error frames make the simple algorithm lose the right rate.",
        "scenario error-frames-at-the-worst-moment",
        koppe_scan::k10,
    ),
    row("K11", "Index 9 of the bit timing table: automatic detection.", "`lss::TABLE`", koppe::k11),
    row(
        "D1",
        "Error passive at 128, bus-off at TEC 256, REC stays past the limit and returns to 119 to 127.",
        "`tests/fault.rs` of canbaud, `tests/confinement.rs` of canbaud-sim",
        ds80c390::d1,
    ),
    row(
        "D2",
        "Bus-off ends after 128 times 11 recessive bits; counters cleared, bit timing kept.",
        "`tests/fault.rs` of canbaud, `node::recovering`",
        ds80c390::d2,
    ),
    row(
        "D3",
        "Nominal bit time, quanta from oscillator, BPR7..0 and SCD2..0; examples of page 155.",
        "`timing::tables::ds80c390`",
        ds80c390::d3,
    ),
];
