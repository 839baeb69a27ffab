//! A master on a channel, or one that only shows its frames.

use std::io;
use std::time::Duration;

use canbaud::lss::{
    FastscanOptions, Found, LssAddress, LssState, NodeId, Pace, Part, Reply, Request, Service,
};
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::Frame;
use canbaud_link::LinkError;
use canbaud_link::bus::FrameBus;
use canbaud_link::lss::{Activated, Master, MasterError};
use serde_json::json;

use super::args::{DeviceArgs, LineArgs};
use super::channel::Channel;
use super::trouble::{Trouble, name};
use super::watched::Watched;
use crate::outlet::Outlet;
use crate::tell::tell;

/// What the frames go out on.
enum Line {
    Live(Watched),
    Dry,
}

/// A master at work.
pub(super) struct Session {
    line: Line,
    channel: Channel,
    pace: Pace,
    form: Form,
    /// Why something could not be said; what was begun goes on all the same.
    unsaid: Option<io::Error>,
}

impl Session {
    /// Opens the channel, if the user allows to transmit on it.
    pub(super) fn open(args: &LineArgs) -> Result<Self, Trouble> {
        let channel = args.on.clone();
        let pace = Pace { answer_timeout: args.timeout, inhibit: args.inhibit, ..Pace::default() };
        let line = if args.dry_run {
            Line::Dry
        } else if args.transmit {
            let bus = Watched::open(&channel, args.own_bitrate)?;
            tell!("canbaud: transmits on {channel}");
            Line::Live(bus)
        } else {
            return Err(Trouble::NotAllowed(channel.to_string()));
        };
        let form = if args.json { Form::Json } else { Form::Text };
        Ok(Self { line, channel, pace, form, unsaid: None })
    }

    /// What came of a step; whether anybody reads it must not keep the next step from being done.
    pub(super) fn say(&mut self, text: &str) {
        if !self.is_dry() {
            let line = match self.form {
                Form::Text => format!("{text}\n"),
                Form::Json => format!("{}\n", json!({ "done": text })),
            };
            self.unsaid = self.unsaid.take().or(Outlet::Output.write(&line, None).err());
        }
    }

    /// A bit rate that an interface was changed to stays behind the command.
    pub(super) fn keep(&mut self, bitrate: Bitrate) {
        if let Line::Live(bus) = &mut self.line
            && bus.keep()
        {
            tell!("canbaud: {} stays at {bitrate}bit/s", self.channel);
        }
    }

    /// Puts the channel back as it was found, and says what happened.
    pub(super) fn end(mut self) -> Result<(), Trouble> {
        if let Line::Live(bus) = &mut self.line {
            bus.put_back(&self.channel)?;
        }
        self.unsaid.map_or(Ok(()), |error| Err(error.into()))
    }

    /// What an error of the channel means: the signal, if one came.
    pub(super) fn trouble(&self, error: LinkError) -> Trouble {
        match &self.line {
            Line::Live(bus) => bus.trouble(error),
            Line::Dry => Trouble::Link(error),
        }
    }

    pub(super) const fn channel(&self) -> &Channel {
        &self.channel
    }

    pub(super) const fn pace(&self) -> Pace {
        self.pace
    }

    /// The same with another time-out.
    pub(super) fn with_timeout(&mut self, timeout: Duration) {
        let us = u64::try_from(timeout.as_micros()).unwrap_or(u64::MAX);
        self.pace.answer_timeout = Micros(us);
    }

    pub(super) const fn is_dry(&self) -> bool {
        matches!(self.line, Line::Dry)
    }

    /// The channel itself; `None` in a dry run.
    pub(super) fn bus(&mut self) -> Option<&mut dyn FrameBus> {
        match &mut self.line {
            Line::Live(bus) => Some(bus),
            Line::Dry => None,
        }
    }

    /// One service. A dry run shows its frames and takes it for done.
    pub(super) fn exchange(&mut self, service: Service) -> Result<Reply, Trouble> {
        let Line::Live(bus) = &mut self.line else {
            let frames = (0..).map_while(|place| service.request(place));
            for request in frames {
                show(self.form, &request.to_frame(), name(&service))?;
            }
            return Ok(match service {
                Service::InquireIdentity(_) => Reply::Number(0),
                Service::InquireNodeId => Reply::NodeId(NodeId::UNCONFIGURED.get()),
                _ => Reply::Done,
            });
        };
        let result = Master::new(bus, self.pace).exchange(service);
        result.map_err(|error| match error {
            MasterError::Service(error) => Trouble::Service(service, error),
            MasterError::Fastscan(error) => Trouble::Fastscan(error),
            MasterError::Link(error) => self.trouble(error),
        })
    }

    /// One scan. A dry run shows the first request: the others depend on the answers.
    pub(super) fn fastscan(
        &mut self,
        options: FastscanOptions<'_>,
    ) -> Result<Option<Found>, Trouble> {
        let Line::Live(bus) = &mut self.line else {
            let begin = Request::Fastscan {
                id_number: 0,
                bit_checked: Request::FASTSCAN_BEGIN,
                lss_sub: 0,
                lss_next: 0,
            };
            show(self.form, &begin.to_frame(), "fastscan; what follows depends on the answers")?;
            return Ok(None);
        };
        let options = FastscanOptions { pace: self.pace, ..options };
        Master::new(bus, self.pace).fastscan(options).map_err(|error| match error {
            MasterError::Fastscan(error) => Trouble::Fastscan(error),
            MasterError::Service(error) => Trouble::Service(Service::InquireNodeId, error),
            MasterError::Link(error) => self.trouble(error),
        })
    }

    /// Activates what was configured; the own channel goes along to `own`.
    pub(super) fn activate(
        &mut self,
        switch_delay_ms: u16,
        own: Option<Bitrate>,
    ) -> Result<Activated, Trouble> {
        let Line::Live(bus) = &mut self.line else {
            let command = Request::ActivateBitTiming { switch_delay_ms };
            show(
                self.form,
                &command.to_frame(),
                "activate bit timing; silence for twice the delay",
            )?;
            return Ok(Activated { reconfiguration: None, in_time: true });
        };
        Master::new(bus, self.pace).activate(switch_delay_ms, own).map_err(|e| self.trouble(e))
    }

    /// Puts the device that the user means, and no other, in configuration.
    pub(super) fn select(&mut self, device: &DeviceArgs) -> Result<(), Trouble> {
        self.exchange(Service::SwitchStateGlobal(LssState::Waiting))?;
        self.exchange(match device.address {
            Some(address) => Service::SwitchStateSelective(address),
            None => Service::SwitchStateGlobal(LssState::Configuration),
        })?;
        Ok(())
    }

    /// All devices go back to waiting.
    pub(super) fn release(&mut self) -> Result<(), Trouble> {
        self.exchange(Service::SwitchStateGlobal(LssState::Waiting)).map(|_| ())
    }

    /// Address and node-ID of the device in configuration, the node-ID as it says it.
    pub(super) fn inquire(&mut self) -> Result<(LssAddress, u8), Trouble> {
        let mut address = LssAddress::new(0, 0, 0, 0);
        for part in Part::ALL {
            if let Reply::Number(number) = self.exchange(Service::InquireIdentity(part))? {
                address = address.with_part(part, number);
            }
        }
        Ok((address, self.inquire_node_id()?))
    }

    /// The node-ID of the device in configuration, as it says it.
    pub(super) fn inquire_node_id(&mut self) -> Result<u8, Trouble> {
        match self.exchange(Service::InquireNodeId)? {
            Reply::NodeId(id) => Ok(id),
            // The reply is that of the service.
            Reply::Done | Reply::Number(_) => Ok(NodeId::UNCONFIGURED.get()),
        }
    }
}

/// A frame as candump writes it, and what it is.
fn show(form: Form, frame: &Frame, what: &str) -> io::Result<()> {
    let bytes: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    let frame = format!("{}#{bytes}", frame.id());
    let line = match form {
        Form::Text => format!("{frame}  {what}\n"),
        Form::Json => format!("{}\n", json!({ "frame": frame, "service": what })),
    };
    Outlet::Output.write(&line, None)
}

/// How it is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Text,
    Json,
}
