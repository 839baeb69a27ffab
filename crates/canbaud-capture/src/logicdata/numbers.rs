//! The numbers and strings of the format.

pub(crate) const MAGIC: u8 = 0x7f;

/// Bytes of a head, taken number by number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers<'a> {
    bytes: &'a [u8],
    used: usize,
}

impl<'a> Numbers<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, used: 0 }
    }

    /// Bytes taken so far.
    pub(super) const fn used(self) -> usize {
        self.used
    }

    fn take(&mut self, len: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(len)?;
        self.bytes = rest;
        self.used += len;
        Some(taken)
    }

    /// A number: its length in bytes, 0 to 8, and the bytes; `None` at the end or if the length
    /// is none.
    pub(super) fn number(&mut self) -> Option<u64> {
        let &[len @ 0..=8] = self.take(1)? else { return None };
        let bytes = self.take(usize::from(len))?;
        Some(bytes.iter().rev().fold(0, |n, byte| n << 8 | u64::from(*byte)))
    }

    /// A string: the number of bytes, and the bytes.
    pub(super) fn string(&mut self) -> Option<&'a [u8]> {
        let len = usize::try_from(self.number()?).ok()?;
        self.take(len)
    }

    /// The size of a vector, which stands there three times: `N 0 N 0 N`.
    pub(super) fn size(&mut self) -> Option<u64> {
        let [n, zero, again, high, low] =
            [self.number()?, self.number()?, self.number()?, self.number()?, self.number()?];
        (zero == 0 && again == n && high == 0 && low == n).then_some(n)
    }
}
