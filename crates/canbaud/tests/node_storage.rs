//! What a node remembers, with power cut at every byte and every step of an erase.

use canbaud::node::{RECORD_OVERHEAD, SaveError, Slot, Storage, load, save};

/// How a memory takes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// One byte after the other over what was there.
    Eeprom,
    /// Erased to FFh byte by byte first.
    Flash,
    /// From the last byte to the first.
    Backwards,
    /// A write leaves a byte half way: some of its bits old, some new.
    Torn,
}

const KINDS: [Kind; 4] = [Kind::Eeprom, Kind::Flash, Kind::Backwards, Kind::Torn];

/// Memory whose power goes after so many byte operations.
#[derive(Clone, Debug)]
struct Memory {
    slots: [[u8; 32]; 2],
    kind: Kind,
    operations_left: u32,
    writes: [u32; 2],
    stuck_at: Option<u8>,
}

#[derive(Debug, PartialEq)]
struct PowerGone;

impl Memory {
    fn new(kind: Kind) -> Self {
        Self {
            slots: [[0xFF; 32]; 2],
            kind,
            operations_left: u32::MAX,
            writes: [0; 2],
            stuck_at: None,
        }
    }

    fn put(&mut self, slot: Slot, at: usize, byte: u8) -> Result<(), PowerGone> {
        let cell = &mut self.slots[slot as usize][at];
        if self.operations_left == 0 {
            if self.kind == Kind::Torn {
                *cell = (*cell & 0xA5) | (byte & 0x5A);
            }
            return Err(PowerGone);
        }
        self.operations_left -= 1;
        *cell = self.stuck_at.unwrap_or(byte);
        Ok(())
    }
}

impl Storage for Memory {
    type Error = PowerGone;

    fn read(&mut self, slot: Slot, into: &mut [u8]) -> Result<(), PowerGone> {
        into.copy_from_slice(&self.slots[slot as usize][..into.len()]);
        Ok(())
    }

    fn write(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), PowerGone> {
        self.writes[slot as usize] += 1;
        if self.kind == Kind::Flash {
            for at in 0..bytes.len() {
                self.put(slot, at, 0xFF)?;
            }
        }
        for at in 0..bytes.len() {
            let at = if self.kind == Kind::Backwards { bytes.len() - 1 - at } else { at };
            self.put(slot, at, bytes[at])?;
        }
        Ok(())
    }
}

const OLD: [u8; 8] = *b"\x40\x42\x0F\x00\x00\x00\x00\x00";
const NEW: [u8; 8] = *b"\x90\xD0\x03\x00\x80\x84\x1E\x00";

/// Old or new at every cut, for every kind of memory and several pasts; what was complete is new,
/// and after any cut the next save works.
#[test]
fn power_cut_at_every_byte_leaves_the_old_value_or_the_new_one() {
    let mut cuts = 0;
    for kind in KINDS {
        for past in 0..5_u8 {
            let mut before = Memory::new(kind);
            for n in 0..past {
                save(&mut before, &[n; 8]).unwrap();
            }
            let old = (past > 0).then_some(());
            if old.is_some() {
                save(&mut before, &OLD).unwrap();
            }
            for cut in 0.. {
                let mut memory = Memory { operations_left: cut, ..before.clone() };
                let result = save(&mut memory, &NEW);
                memory.operations_left = u32::MAX;
                let found = load::<_, 8>(&mut memory).unwrap();
                let is_old = found == old.map(|()| OLD);
                assert!(is_old || found == Some(NEW), "{kind:?} {past} {cut}: {found:?}");
                // The power may go between the last byte and the answer.
                assert!(result.is_err() || found == Some(NEW));
                save(&mut memory, &[9; 8]).unwrap();
                assert_eq!(load(&mut memory), Ok(Some([9; 8])));
                cuts += 1;
                if result.is_ok() {
                    break;
                }
            }
        }
    }
    // 19 bytes, twice as many operations with an erase.
    assert_eq!(cuts, 5 * ((19 + 1) * 3 + (38 + 1)));
}

/// Power goes again and again, each time at another byte of the write: still old or new.
#[test]
fn repeated_cuts_never_lose_the_last_complete_value() {
    for kind in KINDS {
        let mut memory = Memory::new(kind);
        save(&mut memory, &OLD).unwrap();
        let mut last = OLD;
        let mut random: u32 = 12_345;
        for n in 0..20_000_u32 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            memory.operations_left = (random >> 16) % 45;
            let mut value = [0; 8];
            value[..4].copy_from_slice(&n.to_le_bytes());
            let result = save(&mut memory, &value);
            let found = load(&mut memory).unwrap();
            assert!(found == Some(last) || found == Some(value), "{kind:?} {n}: {found:?}");
            assert!(result.is_err() || found == Some(value));
            last = found.unwrap();
        }
    }
}

#[test]
fn slots_take_turns_and_the_same_value_is_not_written_again() {
    let mut memory = Memory::new(Kind::Flash);
    for n in 0..10 {
        save(&mut memory, &[n; 8]).unwrap();
        save(&mut memory, &[n; 8]).unwrap();
    }
    assert_eq!(memory.writes, [5, 5]);
}

#[test]
fn sequence_number_wraps() {
    let mut memory = Memory::new(Kind::Eeprom);
    save(&mut memory, &OLD).unwrap();
    // Bring the sequence number of the only record to the end of its range, with a right CRC.
    let mut bytes = memory.slots[0][..15].to_vec();
    bytes[3..7].fill(0xFF);
    let crc = bytes.iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 }
        })
    });
    memory.slots[0][3..7].fill(0xFF);
    memory.slots[0][15..19].copy_from_slice(&(!crc).to_le_bytes());
    assert_eq!(load(&mut memory), Ok(Some(OLD)));
    for n in 0..4 {
        save(&mut memory, &[n; 8]).unwrap();
        assert_eq!(load(&mut memory), Ok(Some([n; 8])));
    }
}

/// A worn-out cell is noticed, and the value before stays.
#[test]
fn memory_that_does_not_take_a_byte_is_noticed() {
    let mut memory = Memory::new(Kind::Eeprom);
    save(&mut memory, &OLD).unwrap();
    memory.stuck_at = Some(0x00);
    assert_eq!(save(&mut memory, &NEW), Err(SaveError::Verify));
    assert_eq!(load(&mut memory), Ok(Some(OLD)));
}

/// A record of another length is no record.
#[test]
fn other_layouts_are_not_taken() {
    let mut memory = Memory::new(Kind::Eeprom);
    save(&mut memory, &[1; 4]).unwrap();
    assert_eq!(load::<_, 8>(&mut memory), Ok(None));
    assert_eq!(load(&mut memory), Ok(Some([1; 4])));
    assert_eq!(RECORD_OVERHEAD + 8, 19);
}
