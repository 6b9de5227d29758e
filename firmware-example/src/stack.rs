//! How deep the stack went: paint what is free below it, run, and see how far the paint is gone.
//!
//! A frame that reserves words and never writes them is not seen, so this is a measurement and not
//! a bound; the states of a model are written.

use core::arch::asm;
use core::ptr;

/// A word that code is unlikely to leave on the stack.
const PAINT: u32 = 0xCCCC_CCCC;

unsafe extern "C" {
    /// The end of RAM, from the link script: the first word of the stack is just below.
    safe static _stack_start: u32;
}

/// Paints everything between the static variables and the stack as it stands now.
pub(crate) fn paint() {
    // In assembly, because only there the stack pointer is known: a compiled function may read it
    // first and push afterwards, and would paint over its own return address.
    //
    // SAFETY: from the end of the static variables up to the stack pointer nobody owns a word:
    // there is no heap, and an Arm function keeps nothing below its stack pointer. An exception
    // taken here uses these words and is done with them when it returns.
    unsafe {
        asm!(
            "2: cmp {word}, sp",
            "bhs 3f",
            "stm {word}!, {{{paint}}}",
            "b 2b",
            "3:",
            word = inout(reg) cortex_m_rt::heap_start() => _,
            paint = in(reg) PAINT,
        );
    }
}

/// Bytes from the top of the stack to the deepest word written since [`paint`].
#[inline(never)]
pub(crate) fn deepest() -> u32 {
    let top = (&raw const _stack_start).addr();
    let mut word = cortex_m_rt::heap_start().cast_const();
    // SAFETY: the words between the end of the static variables and the top of the stack are RAM,
    // aligned, and only read.
    while word.addr() < top && unsafe { ptr::read_volatile(word) } == PAINT {
        word = word.wrapping_add(1);
    }
    (top - word.addr()) as u32
}
