//! Attributes: length, type, payload, aligned to four bytes.

/// Bits of the type that say how the payload is made (`NLA_F_NESTED`, `NLA_F_NET_BYTEORDER`).
const TYPE_MASK: u16 = 0x3FFF;

/// One attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attribute<'a> {
    /// Its type without flags.
    pub kind: u16,
    /// Its payload.
    pub payload: &'a [u8],
}

impl<'a> Attribute<'a> {
    /// The payload as a number; `None` if it is shorter.
    #[must_use]
    pub fn u16(self) -> Option<u16> {
        Some(u16::from_ne_bytes(*self.payload.first_chunk()?))
    }

    /// The payload as a number; `None` if it is shorter.
    #[must_use]
    pub fn u32(self) -> Option<u32> {
        Some(u32::from_ne_bytes(*self.payload.first_chunk()?))
    }

    /// The payload as numbers; what is left over is left out.
    #[must_use]
    pub fn u32s(self) -> Vec<u32> {
        self.payload
            .chunks_exact(4)
            .map_while(<[u8]>::first_chunk)
            .map(|b| u32::from_ne_bytes(*b))
            .collect()
    }

    /// The payload as text up to its NUL.
    #[must_use]
    pub fn text(self) -> String {
        let end = self.payload.iter().position(|byte| *byte == 0).unwrap_or(self.payload.len());
        String::from_utf8_lossy(self.payload.get(..end).unwrap_or_default()).into_owned()
    }

    /// The payload as attributes.
    #[must_use]
    pub const fn nested(self) -> Attributes<'a> {
        Attributes { bytes: self.payload }
    }
}

/// A row of attributes; ends at the first that does not fit.
#[derive(Debug, Clone, Copy)]
pub struct Attributes<'a> {
    bytes: &'a [u8],
}

impl<'a> Attributes<'a> {
    /// The attributes in `bytes`.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// The first one of `kind`.
    #[must_use]
    pub fn find(mut self, kind: u16) -> Option<Attribute<'a>> {
        Iterator::find(&mut self, |attribute| attribute.kind == kind)
    }
}

impl<'a> Iterator for Attributes<'a> {
    type Item = Attribute<'a>;

    fn next(&mut self) -> Option<Attribute<'a>> {
        let length = usize::from(u16::from_ne_bytes(*self.bytes.first_chunk()?));
        let kind = u16::from_ne_bytes(*self.bytes.get(2..)?.first_chunk()?) & TYPE_MASK;
        let payload = self.bytes.get(4..length)?;
        self.bytes = self.bytes.get(length.next_multiple_of(4)..).unwrap_or_default();
        Some(Attribute { kind, payload })
    }
}

/// Appends an attribute.
pub(super) fn push(out: &mut Vec<u8>, kind: u16, payload: &[u8]) {
    // Requests hold a name of 15 characters and numbers.
    let length = u16::try_from(4 + payload.len()).unwrap_or(u16::MAX);
    out.extend(length.to_ne_bytes());
    out.extend(kind.to_ne_bytes());
    out.extend(payload);
    out.resize(out.len().next_multiple_of(4), 0);
}
