//! What the maps of tests have in common.

use super::{COLUMNS, MAGIC, VERSION};

pub(crate) const FINGERPRINT: u32 = 0x1234_5678;

/// The first words of a map with these rows of both branches: resonance at 20 Hz, half-bandwidth 0.1 Hz, columns from −8 to 8
/// half-bandwidths of the detuning, amplitudes from 1/4 to 8 m/s².
pub(crate) fn head(flags: u16, rows: [u16; 2], slices: usize) -> Vec<u16> {
    let half_bandwidth = 0.1_f64 * f64::from(1 << 15);
    vec![
        MAGIC,
        VERSION,
        0,
        FINGERPRINT as u16,
        (FINGERPRINT >> 16) as u16,
        flags,
        COLUMNS as u16,
        slices as u16,
        (20 << 15 & 0xffff) as u16,
        (20 << 15 >> 16) as u16,
        15,
        (f64::from(1 << 24) / half_bandwidth).round() as u16,
        (-8 * 1024_i16).cast_unsigned(),
        2 * 8 * 1024,
        rows[0],
        rows[1],
        1 << 8 | 11,
        1 << 8 | 11,
        14 * 2048,
        19 * 2048,
        40,
        (-20_i16).cast_unsigned(),
        300,
        123,
        456,
        9700,
        (20 * 2048) as u16,
        (24 * 2048) as u16,
    ]
}

/// Factors of bounds as a map holds them.
pub(crate) fn factors<const N: usize>(factors: [f32; N]) -> [u16; N] {
    factors.map(|factor| (factor.to_bits() >> 16) as u16)
}
