//! A candleLight adapter without hardware: its USB side is a port of the kernel's `vhci_hcd`
//! (USB/IP), its CAN side a node of a scenario. The kernel's own gs_usb driver binds to it.
//!
//!     gs_usb_device SCENARIO NODE [--reports on-request|always|states] [--fd]
//!                   [--without listen-only] [--without timestamps] [--stale N]
//!
//! Needs root and `modprobe vhci_hcd`. Every start, stop and sent frame is a line on stdout, and
//! so is the first error flag with which the adapter disturbs the bus.

mod descriptors;
mod device;
mod gs_usb;
mod reports;
mod usbip;

use std::collections::VecDeque;
use std::error::Error;
use std::io::{self, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use canbaud_sim::scenario::Scenario;
use canbaud_sim::{Span, Time};

use device::{Device, Firmware};
use gs_usb::feature;
use reports::Reports;
use usbip::{Reply, Request};

/// The bus runs this far at a time.
const SLICE: Span = Span::from_ms(1);

fn arguments() -> Result<(String, String, Firmware), String> {
    let mut arguments = std::env::args().skip(1);
    let (Some(scenario), Some(node)) = (arguments.next(), arguments.next()) else {
        return Err("needs a scenario and the name of a node".to_owned());
    };
    let features =
        feature::LISTEN_ONLY | feature::HW_TIMESTAMP | feature::BERR_REPORTING | feature::GET_STATE;
    let mut firmware = Firmware { reports: Reports::OnRequest, features, stale: 0 };
    while let Some(option) = arguments.next() {
        if option == "--fd" {
            firmware.features |= feature::FD | feature::BT_CONST_EXT;
            continue;
        }
        let value = arguments.next().ok_or_else(|| format!("{option} needs a value"))?;
        let wrong = || format!("{option} cannot be {value}");
        match (option.as_str(), value.as_str()) {
            ("--reports", name) => firmware.reports = Reports::parse(name).ok_or_else(wrong)?,
            ("--without", "listen-only") => firmware.features &= !feature::LISTEN_ONLY,
            ("--without", "timestamps") => firmware.features &= !feature::HW_TIMESTAMP,
            ("--stale", count) => firmware.stale = count.parse().map_err(|_| wrong())?,
            _ => return Err(format!("unknown option {option} {value}")),
        }
    }
    Ok((scenario, node, firmware))
}

/// Requests of the host as they come, read by a thread of their own.
fn requests(stream: &UnixStream) -> io::Result<Receiver<Request>> {
    let mut stream = stream.try_clone()?;
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        while let Ok(request) = usbip::read_request(&mut stream) {
            if sender.send(request).is_err() {
                break;
            }
        }
    });
    Ok(receiver)
}

struct Server {
    stream: UnixStream,
    device: Device,
    /// Bulk transfers that wait for data: the driver keeps 30 of them.
    waiting: VecDeque<u32>,
}

impl Server {
    fn serve(&mut self, request: Request) -> io::Result<()> {
        match request {
            Request::Control { number, setup, data } => {
                let reply = self.device.control(setup, &data);
                usbip::complete(&mut self.stream, number, &reply)?;
            }
            Request::BulkIn { number } => self.waiting.push_back(number),
            Request::BulkOut { number, data } => {
                self.device.send(&data);
                usbip::complete(&mut self.stream, number, &Reply::Taken(data.len()))?;
            }
            Request::Unlink { number, target } => {
                let place = self.waiting.iter().position(|waiting| *waiting == target);
                let was_waiting = place.and_then(|place| self.waiting.remove(place)).is_some();
                usbip::unlinked(&mut self.stream, number, was_waiting)?;
            }
        }
        self.deliver()
    }

    fn deliver(&mut self) -> io::Result<()> {
        while !self.waiting.is_empty() {
            let Some(data) = self.device.next_transfer() else { break };
            if let Some(number) = self.waiting.pop_front() {
                usbip::complete(&mut self.stream, number, &Reply::Data(data))?;
            }
        }
        Ok(())
    }

    /// Runs bus and USB side by side, in real time or as fast as this machine can.
    fn run(&mut self, requests: &Receiver<Request>) -> io::Result<()> {
        let mut now = Time::ZERO;
        let mut due = Instant::now();
        while !self.device.is_over() {
            now += SLICE;
            self.device.advance(now);
            self.deliver()?;
            // A bus that is too slow for this machine is late, not in a hurry.
            due = (due + Duration::from_millis(1)).max(Instant::now());
            loop {
                match requests.recv_timeout(due.saturating_duration_since(Instant::now())) {
                    Ok(request) => self.serve(request)?,
                    Err(RecvTimeoutError::Timeout) => break,
                    Err(RecvTimeoutError::Disconnected) => return Ok(()),
                }
            }
        }
        Ok(())
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let (path, node, firmware) = arguments()?;
    let scenario = Scenario::read(Path::new(&path))?;
    let device = Device::new(firmware, &scenario, &node)?;
    let stream = usbip::attach().map_err(|error| format!("vhci_hcd: {error}"))?;
    println!("attached");
    io::stdout().flush()?;
    let requests = requests(&stream)?;
    Server { stream, device, waiting: VecDeque::new() }.run(&requests)?;
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("gs_usb_device: {error}");
            ExitCode::FAILURE
        }
    }
}
