//! How much flash and RAM a firmware takes.

use super::image::Image;
use object::LittleEndian;
use object::elf::{SHF_ALLOC, SHF_WRITE, SHT_NOBITS};

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
    #[must_use]
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
