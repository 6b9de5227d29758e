//! The CRC-32 of snapshots, and fingerprints of models by the same checksum.

use super::{Snapshot, Writer};

/// CRC-32 with the polynomial of IEEE 802.3, reflected, with all bits set at the start and inverted at the
/// end. Its table has 64 bytes; each byte takes two look-ups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Checksum(u32);

const POLYNOMIAL: u32 = 0xedb8_8320;

/// The change of the remainder for each value of four bits that are shifted out.
const TABLE: [u32; 16] = {
    let mut table = [0; 16];
    let mut index = 0;
    while index < 16 {
        let mut remainder = index as u32;
        let mut bit = 0;
        while bit < 4 {
            remainder = if remainder & 1 == 1 { (remainder >> 1) ^ POLYNOMIAL } else { remainder >> 1 };
            bit += 1;
        }
        table[index] = remainder;
        index += 1;
    }
    table
};

impl Checksum {
    const START: Self = Self(u32::MAX);

    pub(super) fn of(bytes: &[u8]) -> u32 {
        let mut checksum = Self::START;
        checksum.include(bytes);
        checksum.value()
    }

    /// Not inlined: a fingerprint calls it for each number, and runs for an image only.
    #[inline(never)]
    const fn include(&mut self, bytes: &[u8]) {
        let mut bytes = bytes;
        while let [byte, rest @ ..] = bytes {
            let remainder = self.0 ^ *byte as u32;
            let remainder = (remainder >> 4) ^ TABLE[(remainder & 15) as usize];
            self.0 = (remainder >> 4) ^ TABLE[(remainder & 15) as usize];
            bytes = rest;
        }
    }

    const fn value(self) -> u32 {
        !self.0
    }
}

/// A 32-bit number that identifies a model: a checksum over the bits of all its coefficients.
///
/// Two models that differ only in one single-precision coefficient always have different fingerprints. Two
/// other models have the same fingerprint by chance once in 2³² pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint(Checksum);

impl Default for Fingerprint {
    fn default() -> Self {
        Self::new()
    }
}

impl Fingerprint {
    /// The fingerprint before any input.
    #[must_use]
    pub const fn new() -> Self {
        Self(Checksum::START)
    }

    /// Includes the name of a type or of a version.
    pub fn name(&mut self, name: &str) {
        self.0.include(name.as_bytes());
    }

    /// Includes the bytes of numbers of at most 64 bits each.
    #[inline(never)]
    pub fn numbers<T: Snapshot>(&mut self, numbers: &[T]) {
        const { assert!(T::BYTES <= 8, "numbers of at most 64 bits") };
        for number in numbers {
            let mut bytes = [0; 8];
            number.write(&mut Writer { left: &mut bytes });
            self.0.include(bytes.get(..T::BYTES).unwrap_or(&bytes));
        }
    }

    pub(crate) const fn bytes(&mut self, bytes: &[u8]) {
        self.0.include(bytes);
    }

    /// Includes a count or a choice.
    pub(crate) fn count(&mut self, count: u32) {
        self.bytes(&count.to_le_bytes());
    }

    /// The number.
    #[must_use]
    pub const fn value(self) -> u32 {
        self.0.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_published_check_value() {
        // The check value of CRC-32/ISO-HDLC in the catalogue of Williams.
        assert_eq!(Checksum::of(b"123456789"), 0xcbf4_3926);
        assert_eq!(Checksum::of(b""), 0);
    }

    #[test]
    fn fingerprints_separate_values_precisions_and_counts() {
        let of = |take: fn(&mut Fingerprint)| {
            let mut fingerprint = Fingerprint::new();
            take(&mut fingerprint);
            fingerprint.value()
        };
        let all = [
            of(|_| ()),
            of(|f| f.numbers(&[1.0_f32])),
            of(|f| f.numbers(&[1.0_f64])),
            of(|f| f.numbers(&[1.0_f32, 0.0])),
            of(|f| f.numbers(&[f32::from_bits(1.0_f32.to_bits() + 1)])),
            of(|f| f.count(1)),
            of(|f| f.count(2)),
            of(|f| f.name("one")),
        ];
        for (index, one) in all.iter().enumerate() {
            assert!(all[..index].iter().all(|other| other != one), "{index}");
        }
    }
}
