//! A device that is configured over the bus, as a scenario describes it.

use canbaud::lss::{
    Automatic, Configuration, LssAddress, NodeId, RateSetting, SlaveOptions, TABLE,
};
use canbaud::units::Bitrate;

use super::build::{Outcome, timing_for, usual_sample_point};
use super::model::{LssTable, StorageName};
use crate::lss_device::LssSetup;
use crate::software::LssStorage;
use crate::time::Span;

/// How long a device takes to answer where a scenario does not say.
const PROCESSING: Span = Span::from_us(1_000);
/// T_cc where a scenario does not say.
const RECONFIGURATION: Span = Span::from_us(100);

pub(super) const fn address(table: &LssTable) -> LssAddress {
    LssAddress::new(table.vendor_id, table.product_code, table.revision_number, table.serial_number)
}

pub(super) const fn storage(name: Option<StorageName>) -> LssStorage {
    match name {
        Some(StorageName::Works) | None => LssStorage::Works,
        Some(StorageName::Fails) => LssStorage::Fails,
        Some(StorageName::None) => LssStorage::Missing,
    }
}

pub(super) fn setup(table: &LssTable, bitrate: Option<Bitrate>, clock: u64) -> Outcome<LssSetup> {
    let node_id = table.node_id.map_or(Some(NodeId::UNCONFIGURED), NodeId::new);
    let node_id = node_id.ok_or("lss.node_id: allowed are 1 to 127, and 255 for none")?;
    let timings = TABLE
        .iter()
        .filter_map(|row| row.setting.and_then(RateSetting::bitrate))
        // A bit rate that its clock cannot make is none that it can be set to.
        .filter_map(|rate| Some((rate, timing_for(clock, rate, usual_sample_point(rate)).ok()?)))
        .collect::<Vec<_>>();
    let rates = LssSetup::rates(&timings);
    let rate = bitrate
        .filter(|rate| rates.has(*rate))
        .ok_or("a node with lss needs a bitrate of the table of CiA, 10k to 1M")?;
    let address = address(table);
    let automatic = if table.automatic { Automatic::Offered } else { Automatic::Refused };
    Ok(LssSetup {
        slave: SlaveOptions { address, rates, automatic },
        stored: Configuration { node_id, rate: RateSetting::Fixed(rate) },
        timings,
        storage: storage(table.storage),
        processing: table.processing.map_or(PROCESSING, |span| span.0),
        reconfiguration: table.reconfiguration.map_or(RECONFIGURATION, |span| span.0),
    })
}
