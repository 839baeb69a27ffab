//! A memory whose power may go while it is written.

use canbaud::node::{Slot, Storage};

/// An EEPROM: byte by byte, and gone is what was not written when power went.
#[derive(Debug, Clone)]
pub struct Memory {
    slots: [[u8; 32]; 2],
    /// Bytes that will still be written before power goes; `None`: it stays.
    bytes_left: Option<u32>,
    writes: u32,
}

/// Power went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PowerGone;

impl Memory {
    /// As delivered: erased.
    #[must_use]
    pub const fn new() -> Self {
        Self { slots: [[0xFF; 32]; 2], bytes_left: None, writes: 0 }
    }

    /// Power will go after `bytes` more.
    pub const fn cut_after(&mut self, bytes: u32) {
        self.bytes_left = Some(bytes);
    }

    /// Power is back.
    pub const fn power_on(&mut self) {
        self.bytes_left = None;
    }

    /// How often a slot was written: what wears it out.
    #[must_use]
    pub const fn writes(&self) -> u32 {
        self.writes
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

impl Storage for Memory {
    type Error = PowerGone;

    fn read(&mut self, slot: Slot, into: &mut [u8]) -> Result<(), PowerGone> {
        let bytes = &self.slots[slot as usize];
        for (to, from) in into.iter_mut().zip(bytes) {
            *to = *from;
        }
        Ok(())
    }

    fn write(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), PowerGone> {
        self.writes += 1;
        for (to, from) in self.slots[slot as usize].iter_mut().zip(bytes) {
            match &mut self.bytes_left {
                Some(0) => return Err(PowerGone),
                Some(left) => *left -= 1,
                None => {}
            }
            *to = *from;
        }
        Ok(())
    }
}
