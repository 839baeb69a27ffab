//! The controller of a device, in the simulator's terms and in canbaud's.

use canbaud::detect::scan::{ErrorClass, ErrorPlace, Evidence};
use canbaud::units::Permille;
use canbaud::wire::{Frame, Level, Logic};
use canbaud_sim::{
    BitTiming, ErrorKind, Gate, Mode, MonitoringCounters, NodeConfig, Place, Recovery,
};

use crate::config::{DeviceConfig, Listener};

/// What the controller is set up for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    Listen,
    TakePart,
}

/// Mode and gate for a purpose; `None` if the device cannot.
pub(crate) const fn mode(listener: Listener, purpose: Purpose) -> Option<(Mode, Gate)> {
    match (listener, purpose) {
        (Listener::Gate, Purpose::TakePart) => Some((Mode::Normal, Gate::Open)),
        (Listener::Gate, Purpose::Listen) => Some((Mode::Normal, Gate::Closed)),
        (_, Purpose::TakePart) => Some((Mode::Normal, Gate::Absent)),
        (Listener::Monitoring(_), Purpose::Listen) => Some((Mode::BusMonitoring, Gate::Absent)),
        (Listener::None, Purpose::Listen) => None,
    }
}

pub(crate) fn frame(id: u16, data: &[u8]) -> Option<Frame> {
    let id = canbaud::wire::Id::base(id)?;
    Frame::new(id, canbaud::wire::FrameKind::Data, data.len() as u8, data).ok()
}

/// The controller of a device with `config`, off.
pub(crate) fn blank(config: &DeviceConfig) -> NodeConfig {
    // 125 kbit/s can be made of every clock in use.
    let point = Permille::new(875).unwrap_or_default();
    let nominal = BitTiming::find(config.clock_hz, 125_000, point);
    let mut node = NodeConfig::at(&config.name, 125_000).unwrap_or_else(|_| unreachable!());
    node.oscillator = canbaud_sim::Oscillator { hertz: config.clock_hz, ppb: config.ppb };
    node.nominal = nominal.unwrap_or(node.nominal);
    off(node, config.listener)
}

/// The same node with a controller as such devices have it, off.
pub(crate) const fn off(mut node: NodeConfig, listener: Listener) -> NodeConfig {
    node.fd = canbaud_sim::FdSupport::None;
    node.recovery = Recovery::Manual;
    node.mode = Mode::Disabled;
    if matches!(listener, Listener::Gate) {
        node.gate = Gate::Closed;
    }
    if matches!(listener, Listener::Monitoring(Evidence::Counter)) {
        node.monitoring_counters = MonitoringCounters::Counting;
    }
    node
}

pub(crate) const fn logic(level: Level) -> Logic {
    match level {
        Level::Recessive => Logic::High,
        Level::Dominant => Logic::Low,
    }
}

pub(crate) const fn class(kind: ErrorKind) -> ErrorClass {
    match kind {
        ErrorKind::Bit => ErrorClass::Bit,
        ErrorKind::Stuff => ErrorClass::Stuff,
        ErrorKind::Form => ErrorClass::Form,
        ErrorKind::Crc => ErrorClass::Crc,
        ErrorKind::Ack => ErrorClass::Acknowledge,
    }
}

pub(crate) const fn where_at(place: Place) -> ErrorPlace {
    match place {
        Place::Arbitration => ErrorPlace::Arbitration,
        Place::Control | Place::Data | Place::Crc => ErrorPlace::BeforeCrcEnd,
        Place::CrcDelimiter => ErrorPlace::CrcDelimiter,
        Place::AckSlot => ErrorPlace::AckSlot,
        Place::AckDelimiter => ErrorPlace::AckDelimiter,
        Place::EndOfFrame => ErrorPlace::EndOfFrame,
        Place::Flag | Place::Delimiter | Place::Between => ErrorPlace::Between,
    }
}
