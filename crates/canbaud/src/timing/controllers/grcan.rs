//! Cobham GRCAN: CONF.
//!
//! PS1 > PS2 >= RSJ must hold; PROP_SEG is always 1. The factor 2^BPR doubles the prescaler up to three times.
//! CONF also enables the controller: those bits must be kept.
//!
//! Source: Linux 6.12 grcan.c.

use super::register::{Content, Encoding, Field, Part, Register, Scale};
use super::{Controller, Phase};
use crate::timing::{Limits, Prescalers, Span};

/// Limits.
pub const NOMINAL: Limits = Limits::new(
    Span::new(2, 16),
    Span::new(2, 8),
    4,
    Prescalers::range(1, 256).and(2, 512, 2).and(4, 1024, 4).and(8, 2048, 8),
)
.with_segments(Span::new(1, 1), Span::new(1, 15))
.with_tseg1_excess(2);

/// The register CONF.
pub const CONF: Register = Register::new(
    "CONF",
    Some(0x00),
    32,
    &[
        Field::other("abort", (0, 1), Content::Other),
        Field::other("enable0", (1, 1), Content::Other),
        Field::other("enable1", (2, 1), Content::Other),
        Field::other("selection", (3, 1), Content::Other),
        Field::other("silent", (4, 1), Content::Other),
        Field::other("sam", (5, 1), Content::Other),
        Field::timing("bpr", (8, 2), (Phase::Nominal, Part::PrescalerScale), Encoding::Raw),
        Field::timing("rsj", (12, 3), (Phase::Nominal, Part::Sjw), Encoding::Raw),
        Field::timing("ps2", (16, 4), (Phase::Nominal, Part::Tseg2), Encoding::Raw),
        Field::timing("ps1", (20, 4), (Phase::Nominal, Part::PhaseSeg1), Encoding::Raw),
        Field::timing("scaler", (24, 8), (Phase::Nominal, Part::Prescaler), Encoding::MinusOne),
    ],
)
.with_scale(Scale { factors: &[1, 2, 4, 8], base_max: 256 });

/// The controller.
pub const CONTROLLER: Controller = Controller {
    aliases: &["gr712"],
    description: "Cobham GRCAN: CONF",
    clock: "system clock",
    registers: &[CONF],
    source: "Linux 6.12 grcan.c",
    ..Controller::classic("grcan", NOMINAL)
};
