//! Numbered images of all states of a node, in two slots of flash of which one is always whole.
//!
//! A power failure may interrupt the writing of an image. So a node writes its images by turns to two slots, with a
//! sequence number, and resumes from the newest image that is whole:
//!
//! ```
//! use model_core::excitation::LineBank;
//! use model_core::snapshot::{self, SnapshotError};
//!
//! let bank = LineBank::<80, 16>::new(400.0, 20.0, 0.2, 9.81 / 8192.0).expect("in bounds");
//! let mut state = bank.start();
//! let mut flash = [[0xff_u8; 256]; 2];
//! let slots = |flash: &[[u8; 256]; 2]| {
//!     snapshot::newest_image(&bank, [&flash[0], &flash[1]]).map(|image| image.state)
//! };
//! assert_eq!(slots(&flash), Err(SnapshotError::NotASnapshot)); // erased
//!
//! snapshot::save_image(&bank, &state, 1, &mut flash[0])?;
//! let first = state;
//! bank.take(&mut state, &[8192, 8200]);
//! snapshot::save_image(&bank, &state, 2, &mut flash[1])?;
//! assert_eq!(slots(&flash), Ok(state));
//! flash[1][40..].fill(0xff); // torn
//! assert_eq!(slots(&flash), Ok(first));
//! # Ok::<(), SnapshotError>(())
//! ```

use super::{
    Configuration, Fingerprint, HEAD, Reader, Snapshot, SnapshotError, open, restore, save_with, size_of,
};

/// The states of a node as they were saved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Image<T> {
    /// The states.
    pub state: T,
    /// Number of the image.
    pub sequence: u32,
    /// The slot that it is in, 0 or 1: the next image belongs in the other one.
    pub slot: usize,
}

/// Size in bytes of an image of the states of a configuration.
#[must_use]
pub const fn image_size<C: Configuration>() -> usize {
    size_of::<(u32, C::State)>()
}

/// Writes an image of the states of `configuration` with its number to the front of `bytes`. Returns its size in bytes,
/// [`image_size`].
///
/// # Errors
/// [`SnapshotError::NoRoom`]; `bytes` is then unchanged.
pub fn save_image<C: Configuration>(
    configuration: &C,
    state: &C::State,
    sequence: u32,
    bytes: &mut [u8],
) -> Result<usize, SnapshotError> {
    save_with(C::State::BYTES + u32::BYTES, fingerprint(configuration), bytes, |out| {
        sequence.write(out);
        state.write(out);
    })
}

/// Reads the image at the front of `bytes` to `state`, as [`save_image`] wrote it for the same configuration; gives its number. For a
/// store that finds the newest bytes itself, such as a map of keys to values in flash.
///
/// # Errors
/// As [`restore`]. The state has no meaning then.
#[inline(never)]
pub fn read_image<C: Configuration>(
    configuration: &C,
    bytes: &[u8],
    state: &mut C::State,
) -> Result<u32, SnapshotError> {
    let content = open(u32::BYTES + C::State::BYTES, fingerprint(configuration), bytes)?;
    let mut from = Reader::new(content);
    let sequence = u32::read(&mut from);
    state.overwrite(&mut from);
    if from.is_sound { Ok(sequence) } else { Err(SnapshotError::NoState) }
}

/// The image with the later number of two slots; the only valid one if the other slot is erased, torn or foreign.
///
/// Numbers wrap: a number is later than another if it is ahead by less than 2³¹.
///
/// # Errors
/// If neither slot holds a valid image: the error of the first slot that is not erased, as by [`restore`].
pub fn newest_image<C: Configuration>(
    configuration: &C,
    slots: [&[u8]; 2],
) -> Result<Image<C::State>, SnapshotError> {
    let fingerprint = fingerprint(configuration);
    let ((sequence, state), slot) =
        newest_slot(slots.map(number), |slot| restore(fingerprint, slots.get(slot).copied().unwrap_or(&[])))?;
    Ok(Image { state, sequence, slot })
}

/// Bytes from the front of an image with its number.
pub(crate) const NUMBERED: usize = HEAD + u32::BYTES;

/// The number of what may be an image.
pub(crate) fn number(bytes: &[u8]) -> u32 {
    bytes.get(HEAD..).and_then(|state| state.first_chunk().copied()).map_or(0, u32::from_le_bytes)
}

/// What is read of the newest valid image of two slots, which have these numbers, and its slot. The one that is ahead is most often
/// valid: the other one is then not read.
pub(crate) fn newest_slot<T>(
    [first, second]: [u32; 2],
    mut read: impl FnMut(usize) -> Result<T, SnapshotError>,
) -> Result<(T, usize), SnapshotError> {
    let ahead = usize::from(is_later(second, first));
    let mut errors = [SnapshotError::NotASnapshot; 2];
    for slot in [ahead, 1 - ahead] {
        match read(slot) {
            Ok(found) => return Ok((found, slot)),
            Err(error) => errors[slot % 2] = error,
        }
    }
    match errors {
        [SnapshotError::NotASnapshot, error] | [error, _] => Err(error),
    }
}

/// Whether the number of an image is later than another: ahead by less than 2³¹.
fn is_later(number: u32, than: u32) -> bool {
    (1..1 << 31).contains(&number.wrapping_sub(than))
}

#[inline(never)]
fn fingerprint<C: Configuration>(configuration: &C) -> u32 {
    let mut fingerprint = Fingerprint::new();
    fingerprint.name("image");
    configuration.identify(&mut fingerprint);
    fingerprint.value()
}

#[cfg(test)]
mod tests {
    use super::super::save;
    use super::*;

    /// A configuration of two numbers.
    struct Pair(f32);

    impl Configuration for Pair {
        type State = [f32; 2];

        fn identify(&self, fingerprint: &mut Fingerprint) {
            fingerprint.name("pair");
            fingerprint.numbers(&[self.0]);
        }
    }

    const SIZE: usize = image_size::<Pair>();

    fn slot(of: f32, state: f32, sequence: u32) -> [u8; SIZE] {
        let mut bytes = [0; SIZE];
        assert_eq!(save_image(&Pair(of), &[state; 2], sequence, &mut bytes), Ok(SIZE));
        bytes
    }

    fn newest(first: &[u8], second: &[u8]) -> Result<(f32, u32, usize), SnapshotError> {
        let image = newest_image(&Pair(1.0), [first, second])?;
        Ok((image.state[0], image.sequence, image.slot))
    }

    #[test]
    fn the_later_number_is_the_newest_across_the_wrap() {
        for (first, second, expected) in
            [(1, 2, 1), (2, 1, 0), (u32::MAX, 0, 1), (0, u32::MAX, 0), (7, 7, 0), (0, (1 << 31) - 1, 1)]
        {
            let found = newest(&slot(1.0, 0.0, first), &slot(1.0, 1.0, second)).expect("both are whole");
            assert_eq!(found, (expected as f32, [first, second][expected], expected));
        }
    }

    #[test]
    fn a_torn_write_leaves_the_image_before_it_at_every_byte() {
        let (old, new) = (slot(1.0, 3.0, 8), slot(1.0, 4.0, 9));
        for written in 0..SIZE {
            // Over erased flash, and over the image before the last.
            for before in [[0xff; SIZE], slot(1.0, 2.0, 7)] {
                let mut torn = before;
                torn[..written].copy_from_slice(&new[..written]);
                assert_eq!(newest(&torn, &old), Ok((3.0, 8, 1)), "{written}");
                assert_eq!(newest(&old, &torn), Ok((3.0, 8, 0)), "{written}");
            }
        }
    }

    #[test]
    fn neither_slot_valid_is_the_error_of_the_one_that_was_written() {
        let erased = [0xff; SIZE];
        let foreign = slot(2.0, 0.0, 1);
        let mut corrupt = slot(1.0, 0.0, 1);
        corrupt[15] ^= 1;
        assert_eq!(newest(&erased, &erased), Err(SnapshotError::NotASnapshot));
        for (first, second, error) in [
            (erased, foreign, SnapshotError::ForeignModel),
            (foreign, erased, SnapshotError::ForeignModel),
            (corrupt, foreign, SnapshotError::Corrupt),
        ] {
            assert_eq!(newest(&first, &second), Err(error));
        }
        assert_eq!(newest(&foreign, &slot(1.0, 5.0, 0)), Ok((5.0, 0, 1)));
        // A snapshot of the state alone is no image.
        let mut alone = [0; SIZE];
        save(&[1.0_f32; 2], fingerprint(&Pair(1.0)), &mut alone).expect("room");
        assert_eq!(newest(&alone, &erased), Err(SnapshotError::ForeignModel));
    }
}
