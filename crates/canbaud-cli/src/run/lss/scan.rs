//! `canbaud lss scan`.

use std::io;
use std::time::Instant;

use canbaud::lss::{FastscanOptions, Found, LssAddress, LssState, NodeId, Service};
use serde_json::json;

use super::args::ScanArgs;
use super::session::Session;
use super::trouble::Trouble;
use crate::outlet::Outlet;

/// Finds devices until none answers; all are in waiting afterwards.
pub(super) fn scan(args: &ScanArgs, session: &mut Session) -> Result<(), Trouble> {
    let last = args.assign.map_or(0, |first| u16::from(first) + u16::from(args.max) - 1);
    let max = if last > 127 { args.max - (last - 127) as u8 } else { args.max };
    // Whoever is left in configuration would not take part.
    session.exchange(Service::SwitchStateGlobal(LssState::Waiting))?;
    let outcome = devices(args, session, max);
    // Also after trouble: nobody is left in configuration.
    let released = session.release();
    let count = outcome?;
    released?;
    if count == 0 && !session.is_dry() { Err(Trouble::NobodyFound) } else { Ok(()) }
}

fn devices(args: &ScanArgs, session: &mut Session, max: u8) -> Result<u8, Trouble> {
    let mut known = args.known.clone();
    let mut found: Vec<LssAddress> = Vec::new();
    for count in 0..max {
        let options = FastscanOptions {
            strategy: args.strategy.into(),
            known: &known,
            ..FastscanOptions::default()
        };
        let begin = Instant::now();
        let Some(device) = session.fastscan(options)? else { return Ok(count) };
        let address = device.address;
        if found.contains(&address) {
            return Err(Trouble::Again(address));
        }
        let node_id = match args.assign {
            Some(first) => Some(assign(args, session, first + count)?),
            None => None,
        };
        tell(args, &device, node_id, begin.elapsed().as_secs_f64())?;
        found.push(address);
        // The next device is likely to be of the same kind.
        known.retain(|other| *other != address);
        known.insert(0, address);
        known.truncate(8);
    }
    Ok(max)
}

/// The device found is the only one in configuration.
fn assign(args: &ScanArgs, session: &mut Session, id: u8) -> Result<u8, Trouble> {
    let Some(node_id) = NodeId::new(id) else { return Ok(id) };
    session.exchange(Service::ConfigureNodeId(node_id))?;
    if args.store {
        session.exchange(Service::StoreConfiguration)?;
    }
    session.release()?;
    Ok(id)
}

fn tell(args: &ScanArgs, found: &Found, node_id: Option<u8>, seconds: f64) -> io::Result<()> {
    let statistics = found.statistics;
    if args.line.json {
        let object = json!({
            "vendor_id": found.address.vendor_id,
            "product_code": found.address.product_code,
            "revision_number": found.address.revision_number,
            "serial_number": found.address.serial_number,
            "node_id": node_id,
            "requests": statistics.requests,
            "silences": statistics.silences,
            "restarts": statistics.restarts,
            "stray_answers": statistics.stray_answers,
            "longest_answer_s": statistics.longest_answer.0 as f64 / 1e6,
            "seconds": seconds,
        });
        return Outlet::Output.write(&format!("{object}\n"), None);
    }
    let given = node_id.map_or_else(String::new, |id| format!("  node-ID {id}"));
    let (address, requests) = (found.address, statistics.requests);
    let line = format!("{address}{given}  ({requests} requests, {seconds:.2} s)\n");
    Outlet::Output.write(&line, None)
}
