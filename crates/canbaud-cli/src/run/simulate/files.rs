//! The files that a run leaves.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::{Context, Result};
use canbaud_sim::scenario::Scenario;
use canbaud_sim::write::{Recorder, write_candump, write_sr, write_vcd};
use canbaud_sim::{Span, Time};

use super::args::SimulateArgs;

/// Whether any file was asked for.
pub(super) const fn any(args: &SimulateArgs) -> bool {
    args.vcd.is_some() || args.sr.is_some() || args.candump.is_some()
}

fn create(path: &Path) -> Result<BufWriter<File>> {
    let file = File::create(path).with_context(|| format!("cannot create {}", path.display()))?;
    Ok(BufWriter::new(file))
}

pub(super) fn write(
    args: &SimulateArgs,
    scenario: &Scenario,
    recorder: &Recorder,
    end: Time,
) -> Result<()> {
    if let Some(path) = &args.vcd {
        let names = scenario.node_names();
        write_vcd(&mut create(path)?, recorder, &names, Span::from_ns(1), end)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if let Some(path) = &args.sr {
        write_sr(create(path)?, &recorder.bus, "CAN", args.samplerate, end)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if let Some(path) = &args.candump {
        let frames = recorder.frames.iter().map(|(at, _, frame)| (*at, frame));
        write_candump(&mut create(path)?, "can0", frames)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}
