//! The state machine of a slave.

use super::action::SlaveAction;
use super::activation::{Activation, Step};
use super::options::{Automatic, Configuration, SlaveOptions, Storage, StoreError};
use super::selection::{Progress, Sequence};
use super::tables::{NoTables, Tables};
use crate::lss::{LssAddress, LssState, NodeId, Outcome, Part, RateSetting, Request, Response};
use crate::units::Micros;
use crate::wire::Frame;

/// The LSS slave of a device [CiA 305].
///
/// After each [`Slave::handle`], [`Slave::reset_communication`] and [`Slave::rate_found`], and when
/// [`Slave::deadline`] has come, call [`Slave::poll`] until it returns `None`; a command that is
/// handled with an answer still to be sent takes the place of that answer.
///
/// ```
/// use canbaud::lss::{
///     Automatic, Configuration, LssAddress, NodeId, RateSet, RateSetting, Request, Response, Slave,
///     SlaveAction, SlaveOptions, Storage, StoreError,
/// };
/// use canbaud::units::{Bitrate, Micros};
///
/// struct Flash;
/// impl Storage for Flash {
///     fn store(&mut self, _: Configuration) -> Result<(), StoreError> {
///         Ok(())
///     }
/// }
///
/// let options = SlaveOptions {
///     address: LssAddress::new(0x29C, 1, 0x10002, 4711),
///     rates: RateSet::ALL,
///     automatic: Automatic::Offered,
/// };
/// let rate = RateSetting::Fixed(Bitrate::new(250_000).unwrap());
/// let stored = Configuration { node_id: NodeId::UNCONFIGURED, rate };
/// let mut slave = Slave::new(options, stored);
///
/// let now = Micros(0);
/// slave.handle(now, &Request::SwitchStateGlobal { mode: 1 }.to_frame(), &mut Flash);
/// assert_eq!(slave.poll(now), None);
/// slave.handle(now, &Request::InquireNodeId.to_frame(), &mut Flash);
/// let answer = Response::InquireNodeId { node_id: 255 }.to_frame();
/// assert_eq!(slave.poll(now), Some(SlaveAction::Send(answer)));
/// ```
#[derive(Debug, Clone)]
pub struct Slave<T = NoTables> {
    options: SlaveOptions,
    /// The manufacturer's.
    tables: T,
    state: LssState,
    active: Configuration,
    pending: Configuration,
    sequence: Sequence,
    /// LSSPos: the part of the address that fastscan is at.
    fastscan_part: Part,
    activation: Activation,
    reply: Option<Response>,
    reset_due: bool,
}

impl Slave {
    /// A slave in waiting, at power-on: what is `stored` is active and pending.
    #[must_use]
    pub const fn new(options: SlaveOptions, stored: Configuration) -> Self {
        Self::with_tables(options, stored, NoTables)
    }
}

impl<T: Tables> Slave<T> {
    /// The same with bit timing tables of the manufacturer. What they name the device can be set to,
    /// beside `options.rates`; automatic detection only if `options.automatic` offers it.
    #[must_use]
    pub const fn with_tables(options: SlaveOptions, stored: Configuration, tables: T) -> Self {
        Self {
            options,
            tables,
            state: LssState::Waiting,
            active: stored,
            pending: stored,
            sequence: Sequence::Idle,
            fastscan_part: Part::VendorId,
            activation: Activation::Idle,
            reply: None,
            reset_due: false,
        }
    }

    /// Its state.
    #[must_use]
    pub const fn state(&self) -> LssState {
        self.state
    }

    /// Its address.
    #[must_use]
    pub const fn address(&self) -> LssAddress {
        self.options.address
    }

    /// Node-ID and bit rate in use; [`RateSetting::Automatic`] also after the bit rate was found.
    #[must_use]
    pub const fn active(&self) -> Configuration {
        self.active
    }

    /// Node-ID from the next reset communication on, bit rate from the next activation on; what
    /// "store configuration" stores.
    #[must_use]
    pub const fn pending(&self) -> Configuration {
        self.pending
    }

    /// Whether the node may send: not during an activation.
    #[must_use]
    pub fn may_send(&self) -> bool {
        self.activation == Activation::Idle
    }

    /// Changes whether automatic detection can be configured, as object 1F80h is written.
    pub const fn set_automatic(&mut self, automatic: Automatic) {
        self.options.automatic = automatic;
    }

    /// The node enters the NMT state reset communication, for whatever reason: the pending node-ID
    /// becomes the active one, and the state is waiting again.
    pub const fn reset_communication(&mut self) {
        self.active.node_id = self.pending.node_id;
        self.state = LssState::Waiting;
        self.sequence = Sequence::Idle;
        self.fastscan_part = Part::VendorId;
        self.reply = None;
        self.reset_due = false;
    }

    /// The bit rate was found after [`RateSetting::Automatic`], and the controller is set to it.
    pub fn rate_found(&mut self) {
        self.activation.rate_found();
    }

    /// Takes a received frame; what is no LSS command of a master is ignored.
    pub fn handle<S: Storage>(&mut self, now: Micros, frame: &Frame, storage: &mut S) {
        let Some(request) = Request::from_frame(frame) else { return };
        let in_sequence = match request {
            Request::IdentifyRemoteSlave { .. } => true,
            Request::SwitchStateSelective { .. } => self.state == LssState::Waiting,
            _ => false,
        };
        if !in_sequence {
            self.sequence = Sequence::Idle;
        }
        if let Request::SwitchStateGlobal { mode } = request {
            self.switch_global(mode);
        } else if self.may_send() {
            self.reply = match self.state {
                LssState::Waiting => self.in_waiting(request),
                LssState::Configuration => self.in_configuration(now, request, storage),
            };
        }
    }

    /// The next thing to do at `now`.
    pub fn poll(&mut self, now: Micros) -> Option<SlaveAction> {
        if let Some(reply) = self.reply.take() {
            return Some(SlaveAction::Send(reply.to_frame()));
        }
        if let Some(step) = self.activation.poll(now) {
            return Some(match step {
                Step::Stop => SlaveAction::StopSending,
                Step::Switch(rate) => {
                    self.active.rate = rate;
                    SlaveAction::SwitchBitRate(rate)
                }
                Step::Resume => SlaveAction::ResumeSending,
            });
        }
        // The boot-up message has to wait until sending is allowed.
        if self.reset_due && self.may_send() {
            self.reset_due = false;
            return Some(SlaveAction::ResetCommunication(self.pending.node_id));
        }
        None
    }

    /// When to call [`Slave::poll`] next if no frame comes; [`Micros::MAX`] for never.
    #[must_use]
    pub fn deadline(&self) -> Micros {
        let due = self.reply.is_some() || (self.reset_due && self.may_send());
        if due { Micros(0) } else { self.activation.deadline() }
    }

    fn switch_global(&mut self, mode: u8) {
        match (self.state, LssState::from_mode(mode)) {
            (_, None) => {}
            (_, Some(LssState::Configuration)) => self.state = LssState::Configuration,
            (LssState::Waiting, Some(LssState::Waiting)) => self.fastscan_part = Part::VendorId,
            (LssState::Configuration, Some(LssState::Waiting)) => {
                self.state = LssState::Waiting;
                self.fastscan_part = Part::VendorId;
                let gained =
                    !self.active.node_id.is_configured() && self.pending.node_id.is_configured();
                self.reset_due |= gained;
            }
        }
    }

    /// Commands that are heeded in both states.
    fn in_both(&mut self, request: Request) -> Option<Response> {
        match request {
            Request::IdentifyRemoteSlave { bound, number } => {
                let progress = self.sequence.identify(&self.options.address, bound, number);
                (progress == Progress::Complete).then_some(Response::IdentifySlave)
            }
            Request::IdentifyNonConfiguredRemoteSlave => {
                self.is_unconfigured().then_some(Response::IdentifyNonConfiguredSlave)
            }
            _ => None,
        }
    }

    fn in_waiting(&mut self, request: Request) -> Option<Response> {
        match request {
            Request::SwitchStateSelective { part, number } => {
                let progress = self.sequence.select(&self.options.address, part, number);
                if progress == Progress::Open {
                    return None;
                }
                self.state = LssState::Configuration;
                Some(Response::SwitchStateSelective)
            }
            Request::Fastscan { id_number, bit_checked, lss_sub, lss_next } => {
                self.fastscan(id_number, bit_checked, lss_sub, lss_next)
            }
            other => self.in_both(other),
        }
    }

    fn in_configuration<S: Storage>(
        &mut self,
        now: Micros,
        request: Request,
        storage: &mut S,
    ) -> Option<Response> {
        match request {
            Request::ConfigureNodeId { node_id } => {
                Some(Response::ConfigureNodeId(self.configure_node_id(node_id)))
            }
            Request::ConfigureBitTiming { table_selector, table_index } => {
                let outcome = self.configure_bit_timing(table_selector, table_index);
                Some(Response::ConfigureBitTiming(outcome))
            }
            Request::ActivateBitTiming { switch_delay_ms } => {
                self.activation = Activation::begin(self.pending.rate, now, switch_delay_ms);
                None
            }
            Request::StoreConfiguration => {
                let outcome = match storage.store(self.pending) {
                    Ok(()) => Outcome::SUCCESS,
                    Err(StoreError::NotSupported) => Outcome::REFUSED,
                    Err(StoreError::Access) => Outcome::STORAGE_ACCESS,
                    Err(StoreError::Manufacturer(error)) => Outcome::manufacturer(error),
                };
                Some(Response::StoreConfiguration(outcome))
            }
            Request::InquireIdentity { part } => {
                Some(Response::InquireIdentity { part, number: self.options.address.part(part) })
            }
            Request::InquireNodeId => {
                // A node that never booted up has no active node-ID to tell.
                let booted = self.active.node_id.is_configured();
                let told = if booted { self.active } else { self.pending };
                Some(Response::InquireNodeId { node_id: told.node_id.get() })
            }
            other => self.in_both(other),
        }
    }

    fn configure_node_id(&mut self, node_id: u8) -> Outcome {
        match NodeId::new(node_id) {
            Some(node_id) => {
                self.pending.node_id = node_id;
                Outcome::SUCCESS
            }
            None => Outcome::REFUSED,
        }
    }

    fn configure_bit_timing(&mut self, table_selector: u8, table_index: u8) -> Outcome {
        let setting = match table_selector {
            0 => RateSetting::from_index(table_index).filter(|setting| self.has(*setting)),
            // Reserved.
            1..=127 => None,
            128..=255 => self.tables.setting(table_selector, table_index),
        };
        match setting {
            Some(RateSetting::Automatic) if self.options.automatic == Automatic::Refused => {
                Outcome::REFUSED
            }
            Some(setting) => {
                self.pending.rate = setting;
                Outcome::SUCCESS
            }
            None => Outcome::REFUSED,
        }
    }

    /// Whether the device can be set to a fixed rate of table 0.
    fn has(&self, setting: RateSetting) -> bool {
        setting.bitrate().is_none_or(|rate| self.options.rates.has(rate))
    }

    const fn is_unconfigured(&self) -> bool {
        !self.active.node_id.is_configured() && !self.pending.node_id.is_configured()
    }

    fn fastscan(&mut self, id: u32, bit_checked: u8, sub: u8, next: u8) -> Option<Response> {
        if !self.is_unconfigured() {
            return None;
        }
        if bit_checked == Request::FASTSCAN_BEGIN {
            self.fastscan_part = Part::VendorId;
            return Some(Response::IdentifySlave);
        }
        let (part, next) = (Part::from_sub(sub)?, Part::from_sub(next)?);
        let differing = id ^ self.options.address.part(part);
        let matches = differing.checked_shr(u32::from(bit_checked))? == 0;
        if part != self.fastscan_part || !matches {
            return None;
        }
        self.fastscan_part = next;
        if bit_checked == 0 && next < part {
            self.state = LssState::Configuration;
        }
        Some(Response::IdentifySlave)
    }
}
