//! Arithmetic of `f32` for a core without floating point and without a long multiplication: Cortex-M0 and M0+. Nothing on
//! other cores.
//!
//! The compiler's functions are written once for all cores. On ARMv6-M they take 115 instructions for a product, since they
//! multiply numbers of 64 bits, 95 to 130 for a sum, and 23 for a comparison. Those of this crate take 53, 60, and 15 to 24,
//! and have the same bits, except of what is not a number.
//!
//! A firmware depends on the crate and names it once; the linker then takes its functions in place of the compiler's:
//!
//! ```text
//! use cortex_m0_arithmetic as _;
//! ```

#![no_std]

#[cfg(armv6m)]
core::arch::global_asm!(include_str!("armv6m.s"));
