//! The node-ID.

use core::fmt;

/// A node-ID that LSS may set: 1 to 127, or 255 for "not configured" [CiA 305].
///
/// ```
/// use canbaud::lss::NodeId;
/// assert_eq!(NodeId::new(127).unwrap().get(), 127);
/// assert_eq!(NodeId::new(255), Some(NodeId::UNCONFIGURED));
/// assert_eq!(NodeId::new(0), None);
/// assert_eq!(NodeId::new(128), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// 255: the device has none and takes no part in the network.
    pub const UNCONFIGURED: Self = Self(0xFF);

    /// A node-ID; `None` for 0 and 128 to 254.
    #[must_use]
    pub const fn new(id: u8) -> Option<Self> {
        match id {
            1..=127 | 0xFF => Some(Self(id)),
            _ => None,
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Whether the device can take part.
    #[must_use]
    pub const fn is_configured(self) -> bool {
        self.0 != 0xFF
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_configured() { write!(f, "{}", self.0) } else { f.pad("none (255)") }
    }
}
