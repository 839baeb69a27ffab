//! rtnetlink for CAN interfaces, as functions over bytes [linux/rtnetlink.h, linux/can/netlink.h].
//!
//! Reading never fails on hostile bytes: what does not fit its type is left out.

mod attribute;
mod can;
mod link;
mod message;
mod request;

pub use attribute::{Attribute, Attributes};
pub use can::{CanInfo, ErrorCounters, TdcInfo, TimingConst, TimingInfo, XStats, ctrlmode};
pub use link::{Link, LinkFlags};
pub use message::{Message, Messages, NetlinkError};
pub use request::{Change, LinkChange, dump_links, get_link};
