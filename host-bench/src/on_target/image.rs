//! A firmware file, known to be linked for the board that it is for.

use object::elf::{SHF_ALLOC, SHF_WRITE, SHT_NOBITS};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSection, ObjectSymbol};
use thiserror::Error;

use super::qemu::Core;

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

/// Reads a firmware file and checks the two addresses that identify the board: two of them have their flash at the same place.
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

/// Bytes, as the `size` of binutils counts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Size {
    /// Code, constants and the initial values of variables.
    pub flash: u64,
    /// Static variables, with or without an initial value.
    pub static_ram: u64,
}

impl Size {
    /// Adds up the sections of `image` that are on the target; logs and debug information are not.
    pub fn of(image: &Image<'_>) -> Self {
        let mut size = Self::default();
        for section in image.elf_section_table().iter() {
            let bytes = u64::from(section.sh_size.get(LittleEndian));
            let flags = section.sh_flags.get(LittleEndian);
            let is = |flag| flags & flag != 0;
            if !is(SHF_ALLOC) {
                continue;
            }
            if section.sh_type.get(LittleEndian) != SHT_NOBITS {
                size.flash += bytes;
            }
            if is(SHF_WRITE) {
                size.static_ram += bytes;
            }
        }
        size
    }
}

/// The functions of `image` that panic, or that calculate in double precision, which these cores do
/// in software and by the hundred instructions. None, if all is well.
///
/// That a panic function is absent says that nothing in the firmware can call it: the panic handler
/// does no formatting, which would bring some of its own.
pub fn refused(image: &Image<'_>) -> Vec<String> {
    let mut names: Vec<String> = image
        .symbols()
        .filter(|symbol| symbol.is_definition())
        .filter_map(|symbol| symbol.name().ok())
        .map(|name| format!("{:#}", rustc_demangle::demangle(name)))
        .filter(|name| is_panic(name) || is_double(name))
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Everything that panics goes through this module of `core`.
fn is_panic(name: &str) -> bool {
    name.contains("core::panicking::")
}

/// Arithmetic, comparison and conversion have two sets of names, the Arm ABI's and the older ones
/// with which `compiler_builtins` implements them.
fn is_double(name: &str) -> bool {
    let function = name.rsplit("::").next().unwrap_or(name);
    if let Some(abi) = function.strip_prefix("__aeabi_") {
        return abi.starts_with('d') || abi.starts_with("cd") || abi.ends_with("2d");
    }
    function.starts_with("__") && function.contains("df")
}

#[cfg(test)]
mod tests {
    use super::{is_double, is_panic};

    #[test]
    fn panics_are_known_by_their_module() {
        assert!(is_panic("core::panicking::panic_bounds_check"));
        assert!(is_panic("core::panicking::panic_const::panic_const_div_by_zero"));
        assert!(!is_panic("firmware_example::stop::panic"));
    }

    #[test]
    fn double_arithmetic_is_known_by_both_its_names_and_no_other_is_taken_for_it() {
        let words = "__aeabi_dadd __aeabi_cdcmple __aeabi_ul2d __aeabi_d2f __adddf3 \
            compiler_builtins::float::mul::__muldf3 __truncdfsf2 __floatunsidf";
        for name in words.split(' ') {
            assert!(is_double(name), "{name}");
        }
        let words = "__aeabi_fadd __aeabi_ul2f __aeabi_f2iz __aeabi_uldivmod __aeabi_memcpy __addsf3 __udivmoddi4 \
            model_core::integrate::step";
        for name in words.split(' ') {
            assert!(!is_double(name), "{name}");
        }
    }
}
