//! Saves states as bytes and restores them, so that a run resumes with the same bits after a power-down.
//!
//! A snapshot has a fixed size for each type of state. Integers are little endian, floats are stored as their bits:
//!
//! | bytes | content |
//! | --- | --- |
//! | 4 | `VEHI` |
//! | 2 | version of this layout, 5 |
//! | 2 | length of the state in bytes |
//! | 4 | fingerprint of the model that the state belongs to ([`Fingerprint`]) |
//! | … | the state, field by field ([`Snapshot`]) |
//! | 4 | CRC-32 of all bytes before it |
//!
//! [`save_image`] and [`newest_image`] save all states of a node as one numbered image, in two slots of flash by
//! turns, so that a torn write leaves the image before it. Every state that a node learns is a [`Snapshot`], and what it
//! belongs to a [`Configuration`].
//!
//! [`restore`] refuses bytes that [`save`] did not write for the same model. The checksum detects every
//! flipped bit and every burst of up to 32 flipped bits. The fingerprint and the length detect another scene,
//! other parameters, another precision and other mode counts.
//!
//! ```
//! use model_core::snapshot::{self, Snapshot, SnapshotError};
//!
//! let state = [1.5_f32, -2.0];
//! let mut flash = [0xff_u8; 64];
//! let used = snapshot::save(&state, 0x1234, &mut flash)?;
//! assert_eq!(used, snapshot::size_of::<[f32; 2]>());
//! assert_eq!(snapshot::restore::<[f32; 2]>(0x1234, &flash)?, state);
//! assert_eq!(snapshot::restore::<[f32; 2]>(0x4321, &flash), Err(SnapshotError::ForeignModel));
//! flash[13] ^= 4;
//! assert_eq!(snapshot::restore::<[f32; 2]>(0x1234, &flash), Err(SnapshotError::Corrupt));
//! # Ok::<(), SnapshotError>(())
//! ```

mod checksum;
mod image;
mod plain;

use core::fmt;

use checksum::Checksum;
pub use checksum::Fingerprint;
pub use image::{Image, image_size, newest_image, read_image, save_image};
pub(crate) use image::{NUMBERED, newest_slot, number};

const MAGIC: u32 = u32::from_le_bytes(*b"VEHI");
/// Version of the layout of the snapshot and of every state in it.
const VERSION: u16 = 6;
/// Bytes before the state.
const HEAD: usize = 12;
/// Bytes after the state.
const TAIL: usize = 4;

/// The reason why a snapshot was not written or not accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SnapshotError {
    /// The buffer is smaller than the snapshot.
    NoRoom {
        /// Size of the snapshot in bytes.
        needed: usize,
        /// Size of the buffer in bytes.
        given: usize,
    },
    /// There are fewer bytes than the snapshot has.
    TooShort {
        /// Size of the snapshot in bytes.
        needed: usize,
        /// Number of bytes given.
        given: usize,
    },
    /// The bytes do not begin with `VEHI`, for example in erased flash.
    NotASnapshot,
    /// The snapshot has another layout.
    ForeignVersion {
        /// Version of that layout.
        version: u16,
    },
    /// The checksum does not match.
    Corrupt,
    /// A valid snapshot of another model: another scene, other parameters or another precision.
    ForeignModel,
    /// A valid snapshot with an invalid state: a mode that does not exist, a number that is not finite, or a count that no state reaches.
    NoState,
}

impl fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRoom { needed, given } => {
                write!(f, "the snapshot takes {needed} bytes and there is room for {given}")
            }
            Self::TooShort { needed, given } => write!(f, "a snapshot of {needed} bytes ends after {given}"),
            Self::NotASnapshot => write!(f, "no snapshot"),
            Self::ForeignVersion { version } => {
                write!(f, "a snapshot of version {version}, not {VERSION}")
            }
            Self::Corrupt => write!(f, "the checksum does not match"),
            Self::ForeignModel => write!(f, "a snapshot of another model"),
            Self::NoState => write!(f, "the snapshot holds no state"),
        }
    }
}

impl core::error::Error for SnapshotError {}

/// A value with a fixed size in bytes that is read back with the same bits.
pub trait Snapshot: Sized {
    /// Size in bytes.
    const BYTES: usize;

    /// Appends the value.
    fn write(&self, out: &mut Writer<'_>);

    /// Reads the value from the front. If the bytes are too few or not a valid value ([`Reader::require`]), the reader keeps
    /// that, and what is returned has no meaning: [`restore`] gives [`SnapshotError::NoState`] then.
    fn read(from: &mut Reader<'_>) -> Self;

    /// Reads the value from the front to where it is to be, entry by entry: a node has no room for another copy of all its
    /// states. As [`Snapshot::read`] otherwise.
    fn overwrite(&mut self, from: &mut Reader<'_>) {
        *self = Self::read(from);
    }
}

/// Parameters and settings to which a state belongs: a state is restored only into the same configuration.
///
/// A tuple of up to four configurations is the configuration of the tuple of their states, so that a node saves all
/// of its states in one image ([`save_image`]).
pub trait Configuration {
    /// The state.
    type State: Snapshot;

    /// Includes everything that determines the meaning of a state in a fingerprint.
    fn identify(&self, fingerprint: &mut Fingerprint);
}

impl<C: Configuration> Configuration for &C {
    type State = C::State;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        C::identify(self, fingerprint);
    }
}

macro_rules! tuples {
    ($(($($part:ident $place:tt),+))*) => {$(
        impl<$($part: Configuration),+> Configuration for ($($part,)+) {
            type State = ($($part::State,)+);

            fn identify(&self, fingerprint: &mut Fingerprint) {
                $(self.$place.identify(fingerprint);)+
            }
        }

        /// One entry after the other.
        impl<$($part: Snapshot),+> Snapshot for ($($part,)+) {
            const BYTES: usize = 0 $(+ $part::BYTES)+;

            fn write(&self, out: &mut Writer<'_>) {
                $(self.$place.write(out);)+
            }

            fn read(from: &mut Reader<'_>) -> Self {
                ($($part::read(from),)+)
            }
        }
    )*};
}

tuples! { (A 0, B 1) (A 0, B 1, C 2) (A 0, B 1, C 2, D 3) }

/// Implements [`Snapshot`] for a struct from one list of its fields, written in that order.
///
/// `snapshot_fields!(impl [S: Scalar] Pair<S> { low, high } if |pair| pair.low <= pair.high);` The condition
/// after `if` is optional; on reading, a value that does not satisfy it is refused.
macro_rules! snapshot_fields {
    (impl [$($generics:tt)*] $type:ty { $($field:tt),+ $(,)? } $(if $is_sound:expr)?) => {
        impl<$($generics)*> $crate::snapshot::Snapshot for $type {
            const BYTES: usize = 0 $(+ $crate::snapshot::bytes_of_field(|value: &Self| &value.$field))+;

            fn write(&self, out: &mut $crate::snapshot::Writer<'_>) {
                $($crate::snapshot::Snapshot::write(&self.$field, out);)+
            }

            fn read(from: &mut $crate::snapshot::Reader<'_>) -> Self {
                let value = Self { $($field: $crate::snapshot::Snapshot::read(from)),+ };
                $(
                    let is_sound: fn(&Self) -> bool = $is_sound;
                    from.require(is_sound(&value));
                )?
                value
            }

            #[inline(never)]
            fn overwrite(&mut self, from: &mut $crate::snapshot::Reader<'_>) {
                $($crate::snapshot::Snapshot::overwrite(&mut self.$field, from);)+
                $(
                    let is_sound: fn(&Self) -> bool = $is_sound;
                    from.require(is_sound(self));
                )?
            }
        }
    };
}
pub(crate) use snapshot_fields;

/// Bytes of the field that the function selects; only the type of the field is used.
pub(crate) const fn bytes_of_field<T, Field: Snapshot>(_select: fn(&T) -> &Field) -> usize {
    Field::BYTES
}

/// Implements [`Snapshot`] for an enum without fields: one byte, the discriminant of the variant.
macro_rules! snapshot_variants {
    ($type:ty { $($variant:ident),+ $(,)? }) => {
        impl $crate::snapshot::Snapshot for $type {
            const BYTES: usize = 1;

            fn write(&self, out: &mut $crate::snapshot::Writer<'_>) {
                $crate::snapshot::Snapshot::write(&(*self as u8), out);
            }

            fn read(from: &mut $crate::snapshot::Reader<'_>) -> Self {
                let byte: u8 = $crate::snapshot::Snapshot::read(from);
                $(
                    if byte == Self::$variant as u8 {
                        return Self::$variant;
                    }
                )+
                from.require(false);
                [$(Self::$variant),+][0]
            }
        }
    };
}
pub(crate) use snapshot_variants;

/// The bytes to which a snapshot is written.
#[derive(Debug)]
pub struct Writer<'a> {
    left: &'a mut [u8],
}

impl Writer<'_> {
    /// Appends `bytes`, or drops them without room; [`save`] has checked the room. Not inlined: a node saves a hundred numbers,
    /// once an hour or so.
    #[inline(never)]
    pub(crate) fn bytes<const N: usize>(&mut self, bytes: [u8; N]) {
        let left = core::mem::take(&mut self.left);
        if let Some((front, rest)) = left.split_first_chunk_mut::<N>() {
            *front = bytes;
            self.left = rest;
        }
    }
}

/// The bytes from which a snapshot is read, and whether all that was read is valid.
#[derive(Debug)]
pub struct Reader<'a> {
    left: &'a [u8],
    is_sound: bool,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes, is_sound: true }
    }

    /// The next `N` bytes; zeros if there are fewer.
    #[inline(never)]
    pub(crate) fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let Some((front, rest)) = self.left.split_first_chunk::<N>() else {
            self.is_sound = false;
            return [0; N];
        };
        self.left = rest;
        *front
    }

    /// Keeps whether what was read is valid: [`restore`] refuses the snapshot if `is_sound` is false once.
    pub fn require(&mut self, is_sound: bool) {
        self.is_sound &= is_sound;
    }
}

/// Size of the snapshot of a state in bytes.
#[must_use]
pub const fn size_of<T: Snapshot>() -> usize {
    HEAD + T::BYTES + TAIL
}

/// Writes the snapshot of `state`, of the model with this fingerprint, to the front of `bytes`. Returns the
/// size of the snapshot in bytes.
///
/// # Errors
/// [`SnapshotError::NoRoom`]; `bytes` is then unchanged.
pub fn save<T: Snapshot>(state: &T, fingerprint: u32, bytes: &mut [u8]) -> Result<usize, SnapshotError> {
    save_with(T::BYTES, fingerprint, bytes, |out| state.write(out))
}

/// As [`save`], of a state of `size` bytes that a function writes.
fn save_with(
    size: usize,
    fingerprint: u32,
    bytes: &mut [u8],
    write: impl FnOnce(&mut Writer<'_>),
) -> Result<usize, SnapshotError> {
    let (needed, given) = (size.saturating_add(HEAD + TAIL), bytes.len());
    // The length must fit in the two bytes of the head.
    let length = u16::try_from(size).ok();
    let (Some(length), Some(snapshot)) = (length, bytes.get_mut(..needed)) else {
        return Err(SnapshotError::NoRoom { needed, given });
    };
    let mut out = Writer { left: &mut *snapshot };
    MAGIC.write(&mut out);
    VERSION.write(&mut out);
    length.write(&mut out);
    fingerprint.write(&mut out);
    write(&mut out);
    let (content, tail) = snapshot.split_at_mut_checked(HEAD + size).unwrap_or_default();
    Checksum::of(content).write(&mut Writer { left: tail });
    Ok(needed)
}

/// Reads the state from the snapshot at the front of `bytes`. Bytes after the snapshot are ignored.
///
/// # Errors
/// Any [`SnapshotError`] except [`SnapshotError::NoRoom`].
pub fn restore<T: Snapshot>(fingerprint: u32, bytes: &[u8]) -> Result<T, SnapshotError> {
    read_sound(open(T::BYTES, fingerprint, bytes)?)
}

/// The states in the bytes of a snapshot of `size` bytes, without its head and its checksum.
fn open(size: usize, fingerprint: u32, bytes: &[u8]) -> Result<&[u8], SnapshotError> {
    let given = bytes.len();
    let too_short = |needed| SnapshotError::TooShort { needed, given };
    let mut head = Reader::new(bytes.get(..HEAD).ok_or(too_short(size.saturating_add(HEAD + TAIL)))?);
    if u32::read(&mut head) != MAGIC {
        return Err(SnapshotError::NotASnapshot);
    }
    let version = u16::read(&mut head);
    if version != VERSION {
        return Err(SnapshotError::ForeignVersion { version });
    }
    let length = usize::from(u16::read(&mut head));
    let needed = HEAD + length + TAIL;
    let snapshot = bytes.get(..needed).ok_or(too_short(needed))?;
    let (content, tail) = snapshot.split_last_chunk::<TAIL>().ok_or(too_short(needed))?;
    if Checksum::of(content) != u32::from_le_bytes(*tail) {
        return Err(SnapshotError::Corrupt);
    }
    if u32::read(&mut head) != fingerprint || length != size {
        return Err(SnapshotError::ForeignModel);
    }
    content.get(HEAD..).ok_or(SnapshotError::NoState)
}

/// The value in all of the bytes.
fn read_sound<T: Snapshot>(bytes: &[u8]) -> Result<T, SnapshotError> {
    let mut payload = Reader::new(bytes);
    let value = T::read(&mut payload);
    if payload.is_sound { Ok(value) } else { Err(SnapshotError::NoState) }
}

#[cfg(test)]
mod tests;
