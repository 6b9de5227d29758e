//! Arithmetic of `f32` for a core without floating point and without a long multiplication: Cortex-M0 and M0+.
//!
//! The compiler's functions are written once for all cores. On ARMv6-M they take 115 instructions for a product, since they
//! multiply numbers of 64 bits, 95 to 130 for a sum, and 23 for a comparison. Those of `arithmetic/armv6m.s` take 53, 60,
//! and 15 to 24, and have the same bits, except of what is not a number.
//!
//! A firmware of your own needs the file, and one line in its `main.rs`:
//!
//! ```text
//! core::arch::global_asm!(include_str!("armv6m.s"));
//! ```

#[cfg(test)]
mod tests;

/// Puts `arithmetic/armv6m.s` in the place of the compiler's functions in a binary of this package for ARMv6-M; nothing on other
/// cores.
#[macro_export]
macro_rules! cortex_m0_arithmetic {
    () => {
        #[cfg(armv6m)]
        core::arch::global_asm!(include_str!(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/src/arithmetic/armv6m.s"
        )));
    };
}
