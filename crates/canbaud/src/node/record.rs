//! What a node remembers over a loss of power: the old value or the new one, never garbage.
//!
//! Two slots take turns. A record is a sequence number, the payload and a CRC over both; writing
//! goes to the slot that does not hold the newest record, so a cut at any byte leaves that one.

use core::fmt;

/// A place for one record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Slot {
    /// The first.
    A,
    /// The second, in another erase unit of a flash than the first.
    B,
}

impl Slot {
    /// The other one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// Memory that survives a loss of power: EEPROM, flash, FRAM, a file.
///
/// An implementation may leave a slot half written when power goes, but must not touch the other.
pub trait Storage {
    /// What can go wrong with the memory.
    type Error;

    /// Reads `slot` from its begin on.
    ///
    /// # Errors
    /// The memory's.
    fn read(&mut self, slot: Slot, into: &mut [u8]) -> Result<(), Self::Error>;

    /// Erases `slot` as far as the memory needs it, and writes `bytes` from its begin on.
    ///
    /// # Errors
    /// The memory's.
    fn write(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), Self::Error>;
}

/// Why a record could not be kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SaveError<E> {
    /// The memory says so.
    Storage(E),
    /// What was written does not read back; the record before is still there.
    Verify,
}

impl<E: fmt::Display> fmt::Display for SaveError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Storage(error) => error.fmt(f),
            Self::Verify => f.write_str("what was written does not read back"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for SaveError<E> {}

/// Marks a record; neither erased flash (FFh) nor cleared RAM (00h).
const MARK: [u8; 2] = *b"cb";

/// Bytes of a record around its payload: mark, length, sequence number, CRC-32.
pub const RECORD_OVERHEAD: usize = MARK.len() + 1 + 4 + 4;

/// A record with `N` bytes of payload (at most 53).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Record<const N: usize> {
    sequence: u32,
    payload: [u8; N],
}

/// Room for a record with its overhead.
const ROOM: usize = 64;

impl<const N: usize> Record<N> {
    const LENGTH: usize = N + RECORD_OVERHEAD;
    /// Evaluated while compiling.
    const FITS: () = assert!(Self::LENGTH <= ROOM, "a record has at most 53 bytes of payload");

    fn to_bytes(self) -> [u8; ROOM] {
        let () = Self::FITS;
        let mut bytes = [0; ROOM];
        let fields = MARK
            .into_iter()
            .chain([N as u8])
            .chain(self.sequence.to_le_bytes())
            .chain(self.payload);
        bytes.iter_mut().zip(fields).for_each(|(byte, field)| *byte = field);
        let crc = crc32(bytes.get(..N + 7).unwrap_or(&[]));
        let end = bytes.iter_mut().skip(N + 7);
        end.zip(crc.to_le_bytes()).for_each(|(byte, field)| *byte = field);
        bytes
    }

    fn from_bytes(bytes: &[u8; ROOM]) -> Option<Self> {
        let (head, _) = bytes.split_at_checked(Self::LENGTH)?;
        let mut payload = [0; N];
        payload.copy_from_slice(head.get(7..7 + N)?);
        let sequence = u32::from_le_bytes(head.get(3..7)?.try_into().ok()?);
        let record = Self { sequence, payload };
        (record.to_bytes().get(..Self::LENGTH)? == head).then_some(record)
    }
}

/// CRC-32 as in ISO 3309.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| bit(crc)))
}

fn read<S: Storage, const N: usize>(
    storage: &mut S,
    slot: Slot,
) -> Result<Option<Record<N>>, S::Error> {
    let mut bytes = [0; ROOM];
    storage.read(slot, bytes.get_mut(..Record::<N>::LENGTH).unwrap_or(&mut []))?;
    Ok(Record::from_bytes(&bytes))
}

/// The newest record with its slot. A slot that cannot be read counts as empty as long as the
/// other one can.
fn newest<S: Storage, const N: usize>(
    storage: &mut S,
) -> Result<Option<(Slot, Record<N>)>, S::Error> {
    let (a, b) = match (read::<S, N>(storage, Slot::A), read::<S, N>(storage, Slot::B)) {
        (Err(error), Err(_)) => return Err(error),
        (a, b) => (a.ok().flatten(), b.ok().flatten()),
    };
    Ok(match (a, b) {
        // The sequence number wraps: the later one is less than half the circle ahead.
        (Some(a), Some(b)) if (b.sequence.wrapping_sub(a.sequence) as i32) > 0 => {
            Some((Slot::B, b))
        }
        (Some(a), _) => Some((Slot::A, a)),
        (None, Some(b)) => Some((Slot::B, b)),
        (None, None) => None,
    })
}

/// The payload written last and completely; `None` if there is none.
///
/// # Errors
/// The memory's, if neither slot can be read.
pub fn load<S: Storage, const N: usize>(storage: &mut S) -> Result<Option<[u8; N]>, S::Error> {
    Ok(newest(storage)?.map(|(_, record)| record.payload))
}

/// Keeps `payload`; once this returns, [`load`] gives it. Writes nothing if it is there already.
///
/// ```
/// use canbaud::node::{Slot, Storage, load, save};
/// # #[derive(Default)]
/// struct Ram([[u8; 32]; 2]);
/// impl Storage for Ram {
///     type Error = core::convert::Infallible;
///     fn read(&mut self, slot: Slot, into: &mut [u8]) -> Result<(), Self::Error> {
///         into.copy_from_slice(&self.0[slot as usize][..into.len()]);
///         Ok(())
///     }
///     fn write(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), Self::Error> {
///         self.0[slot as usize][..bytes.len()].copy_from_slice(bytes);
///         Ok(())
///     }
/// }
/// let mut memory = Ram::default();
/// assert_eq!(load::<_, 4>(&mut memory), Ok(None));
/// save(&mut memory, &250_000_u32.to_le_bytes()).unwrap();
/// assert_eq!(load(&mut memory), Ok(Some(250_000_u32.to_le_bytes())));
/// ```
///
/// # Errors
/// [`SaveError`]; the payload before is still there.
pub fn save<S: Storage, const N: usize>(
    storage: &mut S,
    payload: &[u8; N],
) -> Result<(), SaveError<S::Error>> {
    let (slot, sequence) = match newest::<S, N>(storage).map_err(SaveError::Storage)? {
        Some((_, record)) if record.payload == *payload => return Ok(()),
        Some((slot, record)) => (slot.other(), record.sequence.wrapping_add(1)),
        None => (Slot::A, 0),
    };
    let record = Record { sequence, payload: *payload };
    let bytes = record.to_bytes();
    let bytes = bytes.get(..Record::<N>::LENGTH).unwrap_or(&[]);
    storage.write(slot, bytes).map_err(SaveError::Storage)?;
    match read::<S, N>(storage, slot).map_err(SaveError::Storage)? {
        Some(back) if back == record => Ok(()),
        _ => Err(SaveError::Verify),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_is_that_of_iso_3309() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn erased_and_cleared_memory_hold_no_record() {
        for byte in [0x00, 0xFF] {
            assert_eq!(Record::<8>::from_bytes(&[byte; ROOM]), None);
            assert_eq!(Record::<0>::from_bytes(&[byte; ROOM]), None);
        }
    }

    #[test]
    fn any_single_wrong_bit_is_noticed() {
        let record = Record { sequence: 7, payload: *b"250000bd" };
        let bytes = record.to_bytes();
        assert_eq!(Record::from_bytes(&bytes), Some(record));
        for bit in 0..8 * Record::<8>::LENGTH {
            let mut wrong = bytes;
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Record::<8>::from_bytes(&wrong), None, "bit {bit}");
        }
    }
}
