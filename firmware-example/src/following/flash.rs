//! Images of all states of a node in two slots of flash.

use model_core::snapshot::{Configuration, Fingerprint, Image};

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

    /// The number of the next image and its slot, after the newest image that a node resumed from or saved; 1 and the
    /// first slot if there is none. The newest image stays whole while the next one is written.
    pub fn next(&mut self, newest: Option<Image<()>>) -> (u32, &mut [u8]) {
        let (sequence, slot) = newest.map_or((1, 0), |image| (image.next_sequence(), image.next_slot()));
        let [first, second] = &mut self.slots;
        (sequence, if slot == 0 { first } else { second })
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
