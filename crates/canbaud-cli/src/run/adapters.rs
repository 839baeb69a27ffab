//! `canbaud adapters`: what there is, and what is known of it.

use std::io::{self, Write};

use canbaud::detect::scan::{Evidence, FdSupport};
use canbaud_link::LinkError;
use canbaud_link::adapters::{
    KnownDriver, ListenOnly, SerialAdapter, WrongRate, known_drivers, serial_adapters,
};
use clap::Args;
use serde::Serialize;

use super::failure::unwritable;
use super::live::link_error;
use crate::exit::Exit;
use crate::output::bitrate;
use crate::printable::printable;

/// Arguments of `canbaud adapters`.
#[derive(Debug, Args)]
pub(crate) struct AdaptersArgs {
    /// What is known of every driver, present or not
    #[arg(long)]
    pub(crate) known: bool,

    /// One JSON object a line
    #[arg(long)]
    pub(crate) json: bool,
}

/// One line of the list.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Entry {
    Interface {
        source: String,
        driver: Option<String>,
        title: Option<&'static str>,
        up: bool,
        bitrate: Option<u32>,
        listening: bool,
        usable: bool,
        reason: Option<String>,
        wrong_rate: Option<&'static str>,
        fd: Option<bool>,
        bitrate_min: Option<u32>,
        bitrate_max: Option<u32>,
        bitrates: Vec<u32>,
        note: Option<&'static str>,
    },
    Serial {
        source: String,
        product: Option<String>,
        usb: Option<String>,
        title: Option<&'static str>,
    },
    Driver {
        drivers: &'static [&'static str],
        title: &'static str,
        listen_only: &'static str,
        wrong_rate: &'static str,
        note: &'static str,
    },
}

/// Lists adapters; there is nothing to be found in an empty list.
pub(crate) fn adapters(args: &AdaptersArgs) -> Exit {
    let entries = match entries(args) {
        Ok(entries) => entries,
        Err(error) => return link_error(&error),
    };
    let mut text = String::new();
    for entry in &entries {
        if args.json {
            // Strings and numbers only.
            text.push_str(&serde_json::to_string(entry).unwrap_or_default());
            text.push('\n');
        } else {
            text.push_str(&describe(entry));
        }
    }
    if entries.is_empty() && !args.json {
        text.push_str(
            "no CAN interface and no USB serial port; canbaud adapters --known tells what is \
             known of each driver\n",
        );
    }
    match io::stdout().lock().write_all(text.as_bytes()) {
        Ok(()) => Exit::Found,
        Err(error) => unwritable("standard output", &error),
    }
}

fn entries(args: &AdaptersArgs) -> Result<Vec<Entry>, LinkError> {
    if args.known {
        return Ok(known_drivers().iter().map(driver).collect());
    }
    let mut entries = interfaces()?;
    entries.extend(serial_adapters().into_iter().map(serial));
    Ok(entries)
}

#[cfg(not(target_os = "linux"))]
fn interfaces() -> Result<Vec<Entry>, LinkError> {
    Ok(Vec::new())
}

#[cfg(target_os = "linux")]
fn interfaces() -> Result<Vec<Entry>, LinkError> {
    let adapters = canbaud_link::adapters::interface_adapters()?;
    Ok(adapters.into_iter().map(interface).collect())
}

#[cfg(target_os = "linux")]
fn interface(adapter: canbaud_link::adapters::InterfaceAdapter) -> Entry {
    let usable = adapter.usable.as_ref().ok();
    Entry::Interface {
        source: adapter.name,
        driver: adapter.driver,
        title: adapter.known.map(|known| known.title),
        up: adapter.up,
        bitrate: adapter.bitrate,
        listening: adapter.listens,
        usable: usable.is_some(),
        reason: adapter.usable.as_ref().err().cloned(),
        wrong_rate: usable.map(|usable| match usable.evidence {
            Evidence::Errors => "errors",
            Evidence::Counter => "counter",
            Evidence::FramesOnly => "silence",
        }),
        fd: usable.map(|usable| usable.fd == FdSupport::Fd),
        bitrate_min: usable.map(|usable| usable.range.0.bits_per_second()),
        bitrate_max: usable.map(|usable| usable.range.1.bits_per_second()),
        bitrates: usable
            .map(|usable| usable.rates.iter().map(|rate| rate.bits_per_second()).collect())
            .unwrap_or_default(),
        note: adapter.known.map(|known| known.note).filter(|note| !note.is_empty()),
    }
}

fn serial(adapter: SerialAdapter) -> Entry {
    Entry::Serial {
        source: format!("slcan:{}", adapter.port.display()),
        product: adapter.product,
        usb: adapter.usb.map(|(vendor, product)| format!("{vendor:04x}:{product:04x}")),
        title: adapter.known,
    }
}

fn driver(known: &KnownDriver) -> Entry {
    Entry::Driver {
        drivers: known.drivers,
        title: known.title,
        listen_only: match known.listen_only {
            ListenOnly::Yes => "yes",
            ListenOnly::Some => "some",
            ListenOnly::No => "no",
        },
        wrong_rate: match known.wrong_rate {
            WrongRate::ErrorFramesOnRequest => "errors_on_request",
            WrongRate::ErrorFrames => "errors",
            WrongRate::Counter => "counter",
            WrongRate::Silence => "silence",
            WrongRate::Firmware => "firmware",
        },
        note: known.note,
    }
}

/// A block of lines for a person.
fn describe(entry: &Entry) -> String {
    match entry {
        Entry::Interface { source, driver, title, up, bitrate: set, listening, .. } => {
            let state = if *up { "up" } else { "down" };
            let rate = set.map_or_else(String::new, |rate| format!(", {}", bitrate(rate)));
            let mode = if *listening { ", listen-only" } else { "" };
            let what = match (title, driver) {
                (Some(title), Some(driver)) => format!("{title} ({driver})"),
                (None, Some(driver)) => driver.clone(),
                (_, None) => "unknown driver".to_owned(),
            };
            let head = format!("{}   {state}{rate}{mode}   {what}\n", printable(source));
            format!("{head}{}", interface_lines(entry))
        }
        Entry::Serial { source, product, usb, title } => {
            let words = [product.as_deref(), usb.as_deref(), *title];
            let words: Vec<&str> = words.into_iter().flatten().collect();
            format!("{}   {}\n", printable(source), printable(&words.join("   ")))
        }
        Entry::Driver { drivers, title, listen_only, wrong_rate, note } => {
            let mut text = format!(
                "{title}\n  drivers      {}\n  listen-only  {listen_only}\n",
                drivers.join(", ")
            );
            // Of what is never used there is nothing to see.
            if *listen_only != "no" {
                text.push_str(&format!("  wrong rate   {}\n", in_words(wrong_rate)));
            }
            if !note.is_empty() {
                text.push_str(&format!("  note         {note}\n"));
            }
            text
        }
    }
}

fn interface_lines(entry: &Entry) -> String {
    let Entry::Interface {
        reason, wrong_rate, fd, bitrate_min, bitrate_max, bitrates, note, ..
    } = entry
    else {
        return String::new();
    };
    let mut lines = Vec::new();
    if let Some(reason) = reason {
        lines.push(format!("not usable   {}", printable(reason)));
    }
    if let (Some(wrong_rate), Some(low), Some(high)) = (wrong_rate, bitrate_min, bitrate_max) {
        lines.push(format!("wrong rate   {}", in_words(wrong_rate)));
        let rates = if bitrates.is_empty() {
            format!("{} to {}", bitrate(*low), bitrate(*high))
        } else {
            bitrates.iter().map(|rate| bitrate(*rate)).collect::<Vec<_>>().join(", ")
        };
        let fd = if *fd == Some(true) { "; CAN FD" } else { "" };
        lines.push(format!("rates        {rates}{fd}"));
    }
    if let Some(note) = note {
        lines.push(format!("note         {note}"));
    }
    lines.iter().map(|line| format!("  {line}\n")).collect()
}

/// What a listener gets to see at a wrong rate.
fn in_words(wrong_rate: &str) -> &'static str {
    match wrong_rate {
        "errors" => "an error frame for each error",
        "errors_on_request" => "an error frame for each error, where the kernel offers reporting",
        "counter" => "a receive error counter moves",
        "firmware" => "what the adapter's firmware makes of it",
        _ => "nothing: it looks like a silent bus",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema;
    use canbaud_link::adapters::serial_adapters;

    fn value(entry: &Entry) -> serde_json::Value {
        let value = serde_json::to_value(entry).unwrap();
        schema::assert_valid(schema::ADAPTERS, &value);
        value
    }

    #[test]
    fn drivers_and_ports_are_as_the_schema_says() {
        for known in known_drivers() {
            value(&driver(known));
        }
        let mut ports = serial_adapters();
        ports.push(SerialAdapter {
            port: "/dev/ttyACM0".into(),
            usb: Some((0xAD50, 0x60C4)),
            product: None,
            known: None,
        });
        let all: Vec<_> = ports.into_iter().map(|port| value(&serial(port))).collect();
        let last = all.last().unwrap();
        assert_eq!(
            (&last["source"], &last["usb"]),
            (&"slcan:/dev/ttyACM0".into(), &"ad50:60c4".into())
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn interfaces_are_as_the_schema_says() {
        use canbaud::units::Bitrate;
        use canbaud_link::adapters::{InterfaceAdapter, InterfaceUse, known};
        let rates = [125_000, 250_000].map(|rate| Bitrate::new(rate).unwrap());
        let adapter = |usable| InterfaceAdapter {
            name: "can0".to_owned(),
            driver: Some("gs_usb".to_owned()),
            known: known("gs_usb"),
            up: true,
            bitrate: Some(125_000),
            listens: false,
            usable,
        };
        let can = InterfaceUse {
            evidence: Evidence::Counter,
            fd: FdSupport::Fd,
            rates: rates.to_vec(),
            range: (rates[0], rates[1]),
        };
        let good = value(&interface(adapter(Ok(can))));
        assert_eq!(good["wrong_rate"], "counter");
        assert_eq!(good["bitrates"], serde_json::json!([125_000, 250_000]));
        let bad = value(&interface(adapter(Err("no".to_owned()))));
        assert_eq!((&bad["usable"], &bad["reason"]), (&false.into(), &"no".into()));
    }
}
