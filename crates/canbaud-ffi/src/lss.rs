//! The LSS slave.

use crate::frame::{canbaud_frame, from_c, to_c};
use crate::status::{canbaud_status, status_of};
use crate::storage::{self, read, write};
use canbaud::lss::{
    Automatic, Configuration, LssAddress, LssState, NodeId, RateSet, RateSetting, Slave,
    SlaveAction, SlaveOptions, Storage, StoreError,
};
use canbaud::units::{Bitrate, Micros};
use core::ffi::c_void;
use core::mem::MaybeUninit;

/// Words of a canbaud_lss_slave, of eight bytes each.
pub const CANBAUD_LSS_SLAVE_WORDS: usize = 32;

/// The node-ID of a device that has none.
pub const CANBAUD_NODE_ID_UNCONFIGURED: u8 = 255;

/// A bit rate of 0 stands for automatic detection: index 9 of the bit timing table.
pub const CANBAUD_BITRATE_AUTOMATIC: u32 = 0;

/// The LSS slave of a CANopen device [CiA 305]. Times are microseconds of a clock of the caller that
/// never goes back. Its content is private. Zeros are storage that is not initialized.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct canbaud_lss_slave {
    /// Private.
    pub opaque: [MaybeUninit<u64>; CANBAUD_LSS_SLAVE_WORDS],
}

/// The address of a device, object 1018h.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_lss_address {
    /// Vendor-ID.
    pub vendor_id: u32,
    /// Product code.
    pub product_code: u32,
    /// Revision number.
    pub revision_number: u32,
    /// Serial number.
    pub serial_number: u32,
}

/// Node-ID and bit rate of a device.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_lss_configuration {
    /// 1 to 127, or CANBAUD_NODE_ID_UNCONFIGURED.
    pub node_id: u8,
    /// Bit rate in bit/s, or CANBAUD_BITRATE_AUTOMATIC.
    pub bitrate: u32,
}

/// What came of storing.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_lss_store_result {
    /// Stored.
    OK = 0,
    /// The device cannot store.
    NOT_SUPPORTED = 1,
    /// The storage medium cannot be accessed.
    ACCESS = 2,
}

/// Keeps a configuration over a loss of power; gives a canbaud_lss_store_result.
pub type canbaud_lss_store = Option<
    unsafe extern "C" fn(context: *mut c_void, configuration: canbaud_lss_configuration) -> u8,
>;

/// What a slave wants done.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_lss_action_kind {
    /// Nothing: sleep until the deadline or until a frame comes.
    NONE = 0,
    /// Send the frame.
    SEND = 1,
    /// Send nothing at all until CANBAUD_LSS_ACTION_KIND_RESUME_SENDING.
    STOP_SENDING = 2,
    /// Set the controller to the bit rate. CANBAUD_BITRATE_AUTOMATIC: listen silently until the bit
    /// rate is found, set the controller to it and call canbaud_lss_slave_rate_found.
    SWITCH_BIT_RATE = 3,
    /// The node may send again.
    RESUME_SENDING = 4,
    /// Enter the NMT state reset communication: call canbaud_lss_slave_reset_communication and boot
    /// up with the node-ID.
    RESET_COMMUNICATION = 5,
}

/// What a slave wants done, and with what.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_lss_action {
    /// What.
    pub kind: canbaud_lss_action_kind,
    /// The frame to send.
    pub frame: canbaud_frame,
    /// The bit rate to switch to.
    pub bitrate: u32,
    /// The node-ID to boot up with.
    pub node_id: u8,
}

/// Sets up a slave in waiting, at power-on. `stored` is what was stored last. `automatic` is 1 if the
/// device can find its bit rate itself (index 9).
///
/// # Safety
/// All pointers must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_init(
    slave: *mut canbaud_lss_slave,
    address: *const canbaud_lss_address,
    stored: *const canbaud_lss_configuration,
    automatic: u8,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let (address, stored) = unsafe { (read(address)?, read(stored)?) };
        let options = SlaveOptions {
            address: LssAddress::new(
                address.vendor_id,
                address.product_code,
                address.revision_number,
                address.serial_number,
            ),
            rates: RateSet::ALL,
            automatic: if automatic == 0 { Automatic::Refused } else { Automatic::Offered },
        };
        let node_id = NodeId::new(stored.node_id).ok_or(canbaud_status::OUT_OF_RANGE)?;
        let rate = Bitrate::new(stored.bitrate).map_or(RateSetting::Automatic, RateSetting::Fixed);
        let value = Slave::new(options, Configuration { node_id, rate });
        // SAFETY: the struct is its words.
        unsafe { storage::init(slave.cast::<[u64; CANBAUD_LSS_SLAVE_WORDS]>(), value) }
    })
}

/// Takes a received frame; what is no LSS command of a master is ignored. `store` is called with
/// `context` for "store configuration"; NULL: the device cannot store.
///
/// # Safety
/// `slave` and `frame` must be valid or NULL; `store` must be able to be called with `context`, and
/// must not use the slave.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_handle(
    slave: *mut canbaud_lss_slave,
    now_us: u64,
    frame: *const canbaud_frame,
    store: canbaud_lss_store,
    context: *mut c_void,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let frame = from_c(unsafe { read(frame) }?)?;
        // SAFETY: as the caller says.
        let slave = unsafe { of(slave) }?;
        slave.handle(Micros(now_us), &frame, &mut Callback { store, context });
        Ok(())
    })
}

/// What to do now. To be called until it wants nothing, after everything that was told, and when the
/// deadline has come.
///
/// # Safety
/// `slave` and `action` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_poll(
    slave: *mut canbaud_lss_slave,
    now_us: u64,
    action: *mut canbaud_lss_action,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let wanted = unsafe { of(slave) }?.poll(Micros(now_us));
        // SAFETY: as the caller says.
        unsafe { write(action, action_to_c(wanted)) }
    })
}

/// When canbaud_lss_slave_poll has to be called if no frame comes; CANBAUD_NEVER for never.
///
/// # Safety
/// `slave` and `deadline_us` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_deadline(
    slave: *mut canbaud_lss_slave,
    deadline_us: *mut u64,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let deadline = unsafe { of(slave) }?.deadline().0;
        // SAFETY: as the caller says.
        unsafe { write(deadline_us, deadline) }
    })
}

/// The bit rate was found after automatic detection, and the controller is set to it.
///
/// # Safety
/// `slave` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_rate_found(
    slave: *mut canbaud_lss_slave,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(slave) }?.rate_found();
        Ok(())
    })
}

/// The node enters the NMT state reset communication, for whatever reason.
///
/// # Safety
/// `slave` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_reset_communication(
    slave: *mut canbaud_lss_slave,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        unsafe { of(slave) }?.reset_communication();
        Ok(())
    })
}

/// Node-ID and bit rate in use, and whether the slave is in the state configuration (1) or waiting
/// (0). `in_configuration` may be NULL.
///
/// # Safety
/// All pointers must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_lss_slave_active(
    slave: *mut canbaud_lss_slave,
    configuration: *mut canbaud_lss_configuration,
    in_configuration: *mut u8,
) -> canbaud_status {
    status_of(|| {
        // SAFETY: as the caller says.
        let slave = unsafe { of(slave) }?;
        // SAFETY: as the caller says.
        unsafe { write(configuration, to_c_configuration(slave.active())) }?;
        if !in_configuration.is_null() {
            // SAFETY: not NULL, so valid.
            unsafe { write(in_configuration, u8::from(slave.state() == LssState::Configuration)) }?;
        }
        Ok(())
    })
}

/// # Safety
/// As for [`storage::get`].
unsafe fn of<'a>(slave: *mut canbaud_lss_slave) -> Result<&'a mut Slave, canbaud_status> {
    // SAFETY: the struct is its words.
    unsafe { storage::get::<Slave, CANBAUD_LSS_SLAVE_WORDS>(slave.cast()) }
}

/// Storage behind a function of the caller.
struct Callback {
    store: canbaud_lss_store,
    context: *mut c_void,
}

impl Storage for Callback {
    fn store(&mut self, configuration: Configuration) -> Result<(), StoreError> {
        let store = self.store.ok_or(StoreError::NotSupported)?;
        // SAFETY: the caller says that it can be called with its context.
        match unsafe { store(self.context, to_c_configuration(configuration)) } {
            0 => Ok(()),
            1 => Err(StoreError::NotSupported),
            _ => Err(StoreError::Access),
        }
    }
}

fn bitrate(rate: RateSetting) -> u32 {
    rate.bitrate().map_or(CANBAUD_BITRATE_AUTOMATIC, Bitrate::bits_per_second)
}

fn to_c_configuration(configuration: Configuration) -> canbaud_lss_configuration {
    canbaud_lss_configuration {
        node_id: configuration.node_id.get(),
        bitrate: bitrate(configuration.rate),
    }
}

fn action_to_c(action: Option<SlaveAction>) -> canbaud_lss_action {
    let frame = canbaud_frame { id: 0, extended: 0, kind: 0, dlc: 0, esi: 0, data: [0; 64] };
    let kind = canbaud_lss_action_kind::NONE;
    let mut wanted = canbaud_lss_action { kind, frame, bitrate: 0, node_id: 0 };
    wanted.kind = match action {
        None => canbaud_lss_action_kind::NONE,
        Some(SlaveAction::Send(frame)) => {
            wanted.frame = to_c(&frame);
            canbaud_lss_action_kind::SEND
        }
        Some(SlaveAction::StopSending) => canbaud_lss_action_kind::STOP_SENDING,
        Some(SlaveAction::SwitchBitRate(rate)) => {
            wanted.bitrate = bitrate(rate);
            canbaud_lss_action_kind::SWITCH_BIT_RATE
        }
        Some(SlaveAction::ResumeSending) => canbaud_lss_action_kind::RESUME_SENDING,
        Some(SlaveAction::ResetCommunication(node_id)) => {
            wanted.node_id = node_id.get();
            canbaud_lss_action_kind::RESET_COMMUNICATION
        }
    };
    wanted
}
