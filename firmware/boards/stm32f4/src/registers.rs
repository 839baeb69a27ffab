//! The registers of one peripheral.

/// Reads and writes the registers of one peripheral by their offset.
pub trait Registers {
    /// The register at `offset` bytes.
    fn read(&self, offset: usize) -> u32;

    /// Writes it.
    fn write(&mut self, offset: usize, value: u32);

    /// Sets the bits of `set` and clears those of `clear`.
    fn modify(&mut self, offset: usize, clear: u32, set: u32) {
        self.write(offset, self.read(offset) & !clear | set);
    }
}

impl<R: Registers> Registers for &mut R {
    fn read(&self, offset: usize) -> u32 {
        (**self).read(offset)
    }

    fn write(&mut self, offset: usize, value: u32) {
        (**self).write(offset, value);
    }
}

/// A peripheral at an address \[RM0090, table 1\].
#[derive(Debug)]
pub struct Block(usize);

impl Block {
    /// RCC: clocks of the peripherals.
    pub const RCC: usize = 0x4002_3800;
    /// GPIOA.
    pub const GPIOA: usize = 0x4002_0000;
    /// TIM2, with 32 bits.
    pub const TIM2: usize = 0x4000_0000;
    /// CAN1.
    pub const CAN1: usize = 0x4000_6400;

    /// The peripheral at `base`.
    ///
    /// # Safety
    /// `base` must be the address of a peripheral that nothing else uses while this lives.
    #[must_use]
    pub const unsafe fn new(base: usize) -> Self {
        Self(base)
    }
}

impl Registers for Block {
    fn read(&self, offset: usize) -> u32 {
        // SAFETY: whoever made the block says that this is a peripheral; its registers are words.
        unsafe { ((self.0 + offset) as *const u32).read_volatile() }
    }

    fn write(&mut self, offset: usize, value: u32) {
        // SAFETY: as above.
        unsafe { ((self.0 + offset) as *mut u32).write_volatile(value) }
    }
}
