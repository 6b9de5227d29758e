//! Two slots for images in NOR flash, by the traits of `embedded-storage`.

use embedded_storage::nor_flash::NorFlash;
use model_core::node::Fault;

/// Longest unit that the flash may read or write, in bytes.
const UNIT: usize = 32;

/// Two slots of whole erasable units, one after the other from the start of a flash.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
    /// Bytes of a slot.
    size: u32,
}

impl<F: NorFlash> Slots<F> {
    /// Slots of at least `bytes` each; `None` if the flash is too small or its units are longer than 32 bytes.
    pub fn new(flash: F, bytes: usize) -> Option<Self> {
        const { assert!(F::WRITE_SIZE <= UNIT && F::READ_SIZE <= UNIT, "units of up to 32 bytes") };
        let size = bytes.div_ceil(F::ERASE_SIZE).checked_mul(F::ERASE_SIZE)?;
        (size.checked_mul(2)? <= flash.capacity()).then_some(())?;
        Some(Self { flash, size: u32::try_from(size).ok()? })
    }

    /// The flash.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The first byte of a slot; any number but 0 is the second.
    fn start(&self, slot: usize) -> u32 {
        if slot == 0 { 0 } else { self.size }
    }

    /// Copies the front of a slot to `bytes`, all of them `0xFF` where it cannot be read.
    pub fn read(&mut self, slot: usize, bytes: &mut [u8]) {
        let start = self.start(slot);
        let whole = bytes.len() / F::READ_SIZE * F::READ_SIZE;
        let (front, rest) = bytes.split_at_mut(whole);
        let mut unit = [0xFF; UNIT];
        let unit = unit.get_mut(..F::READ_SIZE).unwrap_or(&mut []);
        let mut read = self.flash.read(start, front);
        if !rest.is_empty() {
            read = read.and_then(|()| self.flash.read(start + whole as u32, unit));
            rest.iter_mut().zip(unit).for_each(|(to, from)| *to = *from);
        }
        if read.is_err() {
            bytes.fill(0xFF);
        }
    }

    /// Erases a slot and writes `bytes` to its front.
    ///
    /// # Errors
    /// If the bytes are more than a slot holds, which is then as it was, or the flash reports a failure: the slot then holds
    /// no valid image.
    pub fn write(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        if bytes.len() > self.size as usize {
            return Err(Fault);
        }
        let start = self.start(slot);
        self.flash.erase(start, start + self.size).map_err(|_| Fault)?;
        let whole = bytes.len() / F::WRITE_SIZE * F::WRITE_SIZE;
        let (front, rest) = bytes.split_at(whole);
        self.flash.write(start, front).map_err(|_| Fault)?;
        if rest.is_empty() {
            return Ok(());
        }
        let mut unit = [0xFF; UNIT];
        unit.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
        let unit = unit.get(..F::WRITE_SIZE).unwrap_or(&[]);
        self.flash.write(start + whole as u32, unit).map_err(|_| Fault)
    }
}
