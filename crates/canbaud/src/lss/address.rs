//! Who a device is.

use core::fmt;

/// One of the four numbers of an LSS address, in the order of the identity object 1018h.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// Vendor-ID, 1018h sub 1.
    VendorId,
    /// Product code, 1018h sub 2.
    ProductCode,
    /// Revision number, 1018h sub 3.
    RevisionNumber,
    /// Serial number, 1018h sub 4.
    SerialNumber,
}

impl Part {
    /// All in order.
    pub const ALL: [Self; 4] =
        [Self::VendorId, Self::ProductCode, Self::RevisionNumber, Self::SerialNumber];

    /// LSSSub of this part, 0 to 3.
    #[must_use]
    pub const fn sub(self) -> u8 {
        self as u8
    }

    /// The part of `sub`; `None` above 3.
    #[must_use]
    pub const fn from_sub(sub: u8) -> Option<Self> {
        match sub {
            0 => Some(Self::VendorId),
            1 => Some(Self::ProductCode),
            2 => Some(Self::RevisionNumber),
            3 => Some(Self::SerialNumber),
            _ => None,
        }
    }

    /// The part behind this one.
    #[must_use]
    pub const fn next(self) -> Option<Self> {
        Self::from_sub(self.sub() + 1)
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::VendorId => "vendor-ID",
            Self::ProductCode => "product code",
            Self::RevisionNumber => "revision number",
            Self::SerialNumber => "serial number",
        })
    }
}

/// The LSS address: 128 bits that name one device in the world [CiA 305; 1018h of CiA 301].
///
/// ```
/// use canbaud::lss::{LssAddress, Part};
/// let address = LssAddress::new(0x0000_029C, 1, 0x0001_0002, 4711);
/// assert_eq!(address.part(Part::RevisionNumber), 0x0001_0002);
/// assert_eq!(address.to_string(), "0000029C:00000001:00010002:00001267");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LssAddress {
    /// Vendor-ID, given out by CiA.
    pub vendor_id: u32,
    /// Product code.
    pub product_code: u32,
    /// Revision number: major in the upper half, minor in the lower.
    pub revision_number: u32,
    /// Serial number.
    pub serial_number: u32,
}

impl LssAddress {
    /// An address of its four numbers.
    #[must_use]
    pub const fn new(
        vendor_id: u32,
        product_code: u32,
        revision_number: u32,
        serial_number: u32,
    ) -> Self {
        Self { vendor_id, product_code, revision_number, serial_number }
    }

    /// One of its numbers.
    #[must_use]
    pub const fn part(&self, part: Part) -> u32 {
        match part {
            Part::VendorId => self.vendor_id,
            Part::ProductCode => self.product_code,
            Part::RevisionNumber => self.revision_number,
            Part::SerialNumber => self.serial_number,
        }
    }

    /// The same with another number in place of one.
    #[must_use]
    pub const fn with_part(mut self, part: Part, number: u32) -> Self {
        match part {
            Part::VendorId => self.vendor_id = number,
            Part::ProductCode => self.product_code = number,
            Part::RevisionNumber => self.revision_number = number,
            Part::SerialNumber => self.serial_number = number,
        }
        self
    }
}

impl fmt::Display for LssAddress {
    /// Four hexadecimal numbers of eight digits with colons between.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:08X}:{:08X}:{:08X}:{:08X}",
            self.vendor_id, self.product_code, self.revision_number, self.serial_number
        )
    }
}

/// Which devices a master asks for by "identify remote slave": one product of one vendor, a range
/// of revisions and of serial numbers, bounds included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct IdRange {
    /// Vendor-ID.
    pub vendor_id: u32,
    /// Product code.
    pub product_code: u32,
    /// Least and greatest revision number.
    pub revision_number: (u32, u32),
    /// Least and greatest serial number.
    pub serial_number: (u32, u32),
}
