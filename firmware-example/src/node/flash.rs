//! Images of all states of a node in two slots of flash.

use model_core::snapshot::{Configuration, Fingerprint};

use super::SLOT_BYTES;

/// The counter of whole seconds, in an image beside the states of the node's parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Seconds;

impl Configuration for Seconds {
    type State = [u32; 1];

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("seconds");
    }
}

/// Two slots of flash, of which images of a node are written by turns. Here they are in RAM.
#[derive(Debug, Clone, Copy)]
pub struct Flash {
    slots: [[u8; SLOT_BYTES]; 2],
}

impl Flash {
    /// Erased.
    #[must_use]
    pub fn new() -> Self {
        Self { slots: [[0xff; SLOT_BYTES]; 2] }
    }

    /// The slots.
    #[must_use]
    pub fn slots(&self) -> [&[u8]; 2] {
        self.slots.each_ref().map(<[u8; SLOT_BYTES]>::as_slice)
    }

    /// The slot of an image with this number.
    pub fn slot(&mut self, sequence: u32) -> &mut [u8] {
        let [even, odd] = &mut self.slots;
        if sequence.is_multiple_of(2) { even } else { odd }
    }
}

impl Default for Flash {
    fn default() -> Self {
        Self::new()
    }
}

/// An image that was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageReport {
    /// Number of the image.
    pub sequence: u32,
    /// Its size in bytes.
    pub bytes: usize,
    /// Its last four bytes: the CRC-32 of the others.
    pub checksum: u32,
}

impl ImageReport {
    /// Of the image of so many bytes at the front of a slot.
    #[must_use]
    pub fn new(sequence: u32, bytes: usize, slot: &[u8]) -> Self {
        let tail = slot.get(..bytes).and_then(<[u8]>::last_chunk);
        Self { sequence, bytes, checksum: tail.map_or(0, |tail| u32::from_le_bytes(*tail)) }
    }
}

impl core::fmt::Display for ImageReport {
    /// As the log has it.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { sequence, bytes, checksum } = self;
        write!(f, "image {sequence}: {bytes} bytes, checksum {checksum}")
    }
}

/// Writes a report of an image to the log.
#[cfg(target_os = "none")]
pub fn log_image(report: &ImageReport) {
    let ImageReport { sequence, bytes, checksum } = *report;
    defmt::info!("image {=u32}: {=u32} bytes, checksum {=u32}", sequence, bytes as u32, checksum);
}
