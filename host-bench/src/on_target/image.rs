//! A firmware file, known to be linked for the board that it is for.

use super::core::Core;
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSection};
use thiserror::Error;

/// A firmware file.
pub type Image<'data> = ElfFile32<'data, LittleEndian>;

/// Why a file is not the firmware for a board.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum Error {
    /// It cannot be read.
    #[error("not an ELF file: {0}")]
    Elf(#[from] object::Error),
    /// It has nothing that a Cortex-M could start from.
    #[error("no vector table")]
    NoVectors,
    /// It is linked for other memory.
    #[error(
        "linked for another board: vectors at {vectors:#010x} and the stack from {stack:#010x}, \
         where {board} has {flash_origin:#010x} and {stack_top:#010x}"
    )]
    OtherBoard {
        /// The board that it should be for.
        board: &'static str,
        /// Where its vector table is.
        vectors: u64,
        /// Where its stack starts.
        stack: u32,
        /// Where the vector table should be.
        flash_origin: u64,
        /// Where the stack should start.
        stack_top: u32,
    },
}

/// Reads a firmware file and checks the two addresses that tell the boards apart: two of them have
/// their flash at the same place.
///
/// # Errors
///
/// When it is no firmware, or not for the board with `core`.
pub fn open(file: &[u8], core: Core) -> Result<Image<'_>, Error> {
    let image = Image::parse(file)?;
    let table = image.section_by_name(".vector_table").ok_or(Error::NoVectors)?;
    let stack = *table.data()?.first_chunk().ok_or(Error::NoVectors)?;
    let (vectors, stack) = (table.address(), u32::from_le_bytes(stack));

    let hardware = core.hardware();
    if (vectors, stack) == (hardware.flash_origin, hardware.stack_top) {
        return Ok(image);
    }
    Err(Error::OtherBoard {
        board: hardware.board,
        vectors,
        stack,
        flash_origin: hardware.flash_origin,
        stack_top: hardware.stack_top,
    })
}
