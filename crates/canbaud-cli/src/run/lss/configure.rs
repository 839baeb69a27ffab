//! The commands about one device.

use std::io;
use std::time::{Duration, Instant};

use canbaud::lss::{LssAddress, RateSetting, Service, ServiceError};
use canbaud::units::Bitrate;
use canbaud_link::lss::Activated;
use serde_json::json;

use super::args::{AutoArgs, InquireArgs, SetBitrateArgs, SetNodeIdArgs, StoreArgs};
use super::parse::TableIndex;
use super::session::Session;
use super::trouble::Trouble;
use crate::outlet::Outlet;
use crate::tell::tell;

/// How long a device with a fixed bit rate may take to be back.
const BACK: Duration = Duration::from_secs(10);
/// Between two questions whether a device is back.
const ASK_AGAIN: Duration = Duration::from_millis(200);

/// `inquire`.
pub(super) fn inquire(args: &InquireArgs, session: &mut Session) -> Result<(), Trouble> {
    session.select(&args.device)?;
    let answer = session.inquire();
    session.release()?;
    let (address, node_id) = answer?;
    if session.is_dry() {
        return Ok(());
    }
    tell(args.line.json, address, node_id)?;
    Ok(())
}

fn tell(as_json: bool, address: LssAddress, node_id: u8) -> io::Result<()> {
    if as_json {
        let object = json!({
            "vendor_id": address.vendor_id,
            "product_code": address.product_code,
            "revision_number": address.revision_number,
            "serial_number": address.serial_number,
            "node_id": node_id,
        });
        return Outlet::Output.write(&format!("{object}\n"), None);
    }
    let line = match node_id {
        255 => format!("{address}  no node-ID\n"),
        id => format!("{address}  node-ID {id}\n"),
    };
    Outlet::Output.write(&line, None)
}

/// `set-node-id`.
pub(super) fn set_node_id(args: &SetNodeIdArgs, session: &mut Session) -> Result<(), Trouble> {
    session.select(&args.device)?;
    let done = configure(session, Service::ConfigureNodeId(args.node_id), args.store);
    session.release()?;
    done?;
    session.say(&format!("node-ID {} is set{}", args.node_id, kept(args.store)));
    Ok(())
}

/// `store`.
pub(super) fn store(args: &StoreArgs, session: &mut Session) -> Result<(), Trouble> {
    session.select(&args.device)?;
    let done = session.exchange(Service::StoreConfiguration);
    session.release()?;
    done?;
    session.say("stored");
    Ok(())
}

/// `set-bitrate`.
pub(super) fn set_bitrate(args: &SetBitrateArgs, session: &mut Session) -> Result<(), Trouble> {
    let Timing { table_selector, table_index, own, shown, goes_along } = timing(args);
    if args.activate.is_some() && !goes_along {
        let what = format!("{shown} stands for no bit rate to go along to");
        return Err(Trouble::Usage(what));
    }
    session.select(&args.device)?;
    let service = Service::ConfigureBitTiming { table_selector, table_index };
    if let Err(trouble) = configure(session, service, args.store) {
        session.release()?;
        return Err(trouble);
    }
    session.say(&format!("bit rate {shown} is set{}", kept(args.store)));
    let Some(delay) = args.activate else { return session.release() };
    let activated = session.activate(delay, own)?;
    warn(session, activated);
    let back = wait_until_back(session, BACK);
    let released = session.release();
    let after = back?;
    released?;
    if let Some(bitrate) = own {
        session.keep(bitrate);
    }
    session.say(&format!("activated; the device answers after {:.1} s", after.as_secs_f64()));
    Ok(())
}

/// What `set-bitrate` sets.
struct Timing {
    table_selector: u8,
    table_index: u8,
    /// Where the own channel goes along to; without a fixed bit rate it stays where the device will
    /// find it.
    own: Option<Bitrate>,
    /// For people.
    shown: String,
    /// Whether it is known what the own channel has to do.
    goes_along: bool,
}

fn timing(args: &SetBitrateArgs) -> Timing {
    if let (Some(table_selector), Some(table_index)) = (args.table, args.index) {
        let shown = format!("index {table_index} of table {table_selector}");
        let (own, goes_along) = (args.to, args.to.is_some());
        return Timing { table_selector, table_index, own, shown, goes_along };
    }
    let table_index = args.rate.map_or(0, |TableIndex(index)| index);
    let setting = RateSetting::from_index(table_index);
    Timing {
        table_selector: 0,
        table_index,
        own: setting.and_then(RateSetting::bitrate),
        shown: setting.map_or_else(|| format!("index {table_index}"), |rate| rate.to_string()),
        goes_along: setting.is_some(),
    }
}

/// `auto`.
pub(super) fn auto(args: &AutoArgs, session: &mut Session) -> Result<(), Trouble> {
    session.select(&args.device)?;
    let service = Service::ConfigureBitTiming { table_selector: 0, table_index: 9 };
    if let Err(trouble) = configure(session, service, args.store) {
        session.release()?;
        return Err(trouble);
    }
    session.say(&format!("automatic detection is set{}", kept(args.store)));
    session.activate(args.delay, None)?;
    // The questions are the traffic by which it finds the bit rate.
    let back = wait_until_back(session, args.wait);
    let released = session.release();
    let after = back?;
    released?;
    session.say(&format!("the device found the bit rate after {:.1} s", after.as_secs_f64()));
    Ok(())
}

fn configure(session: &mut Session, service: Service, store: bool) -> Result<(), Trouble> {
    session.exchange(service)?;
    if store {
        session.exchange(Service::StoreConfiguration)?;
    }
    Ok(())
}

/// Asks the device in configuration until it answers.
fn wait_until_back(session: &mut Session, until: Duration) -> Result<Duration, Trouble> {
    let (begin, pace) = (Instant::now(), session.pace());
    session.with_timeout(ASK_AGAIN);
    let result = loop {
        match session.inquire_node_id() {
            Ok(_) => break Ok(begin.elapsed()),
            Err(Trouble::Service(_, ServiceError::NoAnswer(_))) => {}
            Err(other) => break Err(other),
        }
        if begin.elapsed() >= until {
            break Err(Trouble::NotBack(until));
        }
    };
    session.with_timeout(Duration::from_micros(pace.answer_timeout.0));
    result
}

/// What was late with the own channel.
pub(super) fn warn(session: &Session, activated: Activated) {
    if let (false, Some(took)) = (activated.in_time, activated.reconfiguration) {
        let ms = took.as_millis();
        tell!(
            "canbaud: {} took {ms} ms to change its bit rate, longer than the second period: \
             what devices sent by then is lost",
            session.channel()
        );
    }
}

const fn kept(store: bool) -> &'static str {
    if store { " and stored" } else { ", until the device is switched off" }
}
