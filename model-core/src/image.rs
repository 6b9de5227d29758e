//! States as bytes: for a power-down, from which a run resumes with the same bits.
//!
//! An image is of fixed size for each type of state, little endian, floats by their bits:
//!
//! | bytes | what |
//! | --- | --- |
//! | 4 | `VEHI` |
//! | 2 | version of this layout, 1 |
//! | 2 | length of the payload |
//! | 4 | fingerprint of the model whose state it is ([`Fingerprint`]) |
//! | … | the state, entry by entry ([`Image`]) |
//! | 4 | CRC-32 of all before it |
//!
//! [`restore`] refuses whatever is not the very image that [`save`] wrote for the same model: every single
//! flipped bit and every burst of up to 32 is found by the checksum, another scene, other parameters, another
//! precision or other mode counts by the fingerprint and the length.
//!
//! ```
//! use model_core::image::{self, Image, ImageError};
//!
//! let state = [1.5_f32, -2.0];
//! let mut flash = [0xff_u8; 64];
//! let used = image::save(&state, 0x1234, &mut flash)?;
//! assert_eq!(used, image::size_of::<[f32; 2]>());
//! assert_eq!(image::restore::<[f32; 2]>(0x1234, &flash)?, state);
//! assert_eq!(image::restore::<[f32; 2]>(0x4321, &flash), Err(ImageError::ForeignModel));
//! flash[13] ^= 4;
//! assert_eq!(image::restore::<[f32; 2]>(0x1234, &flash), Err(ImageError::Corrupt));
//! # Ok::<(), ImageError>(())
//! ```

mod checksum;
mod plain;

use core::fmt;

use checksum::Checksum;
pub use checksum::Fingerprint;

const MAGIC: u32 = u32::from_le_bytes(*b"VEHI");
/// Version of the layout of the frame and of every state in it.
const VERSION: u16 = 1;
/// Bytes before the payload, and after it.
const HEAD: usize = 12;
const TAIL: usize = 4;

/// Why an image was not written or not accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ImageError {
    /// There is not enough room for the image.
    NoRoom {
        /// Bytes that it takes.
        needed: usize,
        /// Bytes that there are.
        given: usize,
    },
    /// The bytes end before the image does.
    TooShort {
        /// Bytes that it takes.
        needed: usize,
        /// Bytes that there are.
        given: usize,
    },
    /// The bytes do not begin as an image does: erased flash, or something else.
    NoImage,
    /// An image in another layout.
    ForeignVersion {
        /// Its version.
        version: u16,
    },
    /// The checksum does not match.
    Corrupt,
    /// A sound image of the state of another model: another scene, other parameters, another precision.
    ForeignModel,
    /// A sound image whose payload is no state: a mode that does not exist, a number that is not finite.
    NoState,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRoom { needed, given } => {
                write!(f, "the image takes {needed} bytes and there is room for {given}")
            }
            Self::TooShort { needed, given } => write!(f, "an image of {needed} bytes ends after {given}"),
            Self::NoImage => write!(f, "no image"),
            Self::ForeignVersion { version } => {
                write!(f, "an image of version {version}, not {VERSION}")
            }
            Self::Corrupt => write!(f, "the checksum does not match"),
            Self::ForeignModel => write!(f, "an image of another model"),
            Self::NoState => write!(f, "the image holds no state"),
        }
    }
}

impl core::error::Error for ImageError {}

/// A plain value that can be written as a fixed number of bytes and read back with the same bits.
pub trait Image: Sized {
    /// Number of bytes.
    const BYTES: usize;

    /// Appends the value.
    fn write(&self, out: &mut Writer<'_>);

    /// Takes the value from the front.
    ///
    /// # Errors
    /// [`ImageError::NoState`] where the bytes are no such value or are used up.
    fn read(from: &mut Reader<'_>) -> Result<Self, ImageError>;
}

/// Where an image is written to.
#[derive(Debug)]
pub struct Writer<'a> {
    left: &'a mut [u8],
}

impl Writer<'_> {
    /// Appends `bytes`; those for which there is no room are lost, which [`save`] has ruled out.
    pub(crate) fn bytes<const N: usize>(&mut self, bytes: [u8; N]) {
        let left = core::mem::take(&mut self.left);
        if let Some((front, rest)) = left.split_first_chunk_mut::<N>() {
            *front = bytes;
            self.left = rest;
        }
    }
}

/// What an image is read from.
#[derive(Debug)]
pub struct Reader<'a> {
    left: &'a [u8],
}

impl Reader<'_> {
    /// The next `N` bytes.
    pub(crate) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], ImageError> {
        let (front, rest) = self.left.split_first_chunk::<N>().ok_or(ImageError::NoState)?;
        self.left = rest;
        Ok(*front)
    }
}

/// Bytes that the image of a state takes.
#[must_use]
pub const fn size_of<T: Image>() -> usize {
    HEAD + T::BYTES + TAIL
}

/// Writes the image of `state`, the state of a model with this fingerprint, to the front of `bytes`; gives
/// its size.
///
/// # Errors
/// [`ImageError::NoRoom`] with both sizes; `bytes` is then as before.
pub fn save<T: Image>(state: &T, fingerprint: u32, bytes: &mut [u8]) -> Result<usize, ImageError> {
    let (needed, given) = (size_of::<T>(), bytes.len());
    // A payload whose length the head cannot tell has no room in an image of any size.
    let length = u16::try_from(T::BYTES).ok();
    let (Some(length), Some(image)) = (length, bytes.get_mut(..needed)) else {
        return Err(ImageError::NoRoom { needed, given });
    };
    let mut out = Writer { left: &mut *image };
    MAGIC.write(&mut out);
    VERSION.write(&mut out);
    length.write(&mut out);
    fingerprint.write(&mut out);
    state.write(&mut out);
    if let Some((content, tail)) = image.split_last_chunk_mut::<TAIL>() {
        *tail = Checksum::of(content).to_le_bytes();
    }
    Ok(needed)
}

/// Reads the state from an image at the front of `bytes`; what follows the image is not looked at.
///
/// # Errors
/// Every [`ImageError`] but [`ImageError::NoRoom`].
pub fn restore<T: Image>(fingerprint: u32, bytes: &[u8]) -> Result<T, ImageError> {
    let given = bytes.len();
    let too_short = |needed| ImageError::TooShort { needed, given };
    let mut head = Reader { left: bytes.get(..HEAD).ok_or(too_short(size_of::<T>()))? };
    if u32::read(&mut head)? != MAGIC {
        return Err(ImageError::NoImage);
    }
    let version = u16::read(&mut head)?;
    if version != VERSION {
        return Err(ImageError::ForeignVersion { version });
    }
    let length = usize::from(u16::read(&mut head)?);
    let needed = HEAD + length + TAIL;
    let image = bytes.get(..needed).ok_or(too_short(needed))?;
    let (content, tail) = image.split_last_chunk::<TAIL>().ok_or(too_short(needed))?;
    if Checksum::of(content) != u32::from_le_bytes(*tail) {
        return Err(ImageError::Corrupt);
    }
    if u32::read(&mut head)? != fingerprint || length != T::BYTES {
        return Err(ImageError::ForeignModel);
    }
    let mut payload = Reader { left: content.get(HEAD..).ok_or(ImageError::NoState)? };
    T::read(&mut payload)
}

#[cfg(test)]
mod tests;
