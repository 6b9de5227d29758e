//! Random numbers: SplitMix64 (Steele, Lea and Flood, 2014).

use std::ops::RangeInclusive;

/// A sequence of random numbers.
#[derive(Debug, Clone, Copy)]
pub struct Source(u64);

/// The increment of SplitMix64: the golden ratio in 64 bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Source {
    /// The sequence of a number under a seed.
    pub(crate) fn new(seed: u64, number: u64) -> Self {
        let mut by_seed = Self(seed);
        Self(by_seed.bits() ^ number.wrapping_mul(GOLDEN))
    }

    /// The sequence of a seed alone.
    pub fn of_seed(seed: u64) -> Self {
        Self(seed)
    }

    /// A whole number of a range.
    pub(crate) fn whole(&mut self, range: RangeInclusive<u16>) -> u16 {
        let count = u64::from(range.end() - range.start()) + 1;
        range.start() + (self.bits() % count) as u16
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// From `lowest` to `highest`, uniform.
    pub fn uniform(&mut self, lowest: f64, highest: f64) -> f64 {
        let part = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        lowest + part * (highest - lowest)
    }

    /// Normal with the variance 1, as the sum of twelve.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform(0.0, 1.0) - 0.5).sum()
    }

    /// From `lowest` to `highest`, both above 0, with a uniform logarithm.
    pub(crate) fn logarithmic(&mut self, lowest: f64, highest: f64) -> f64 {
        self.uniform(lowest.ln(), highest.ln()).exp()
    }

    /// Whether an event of this probability happens.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// One of some values, each as probable as another.
    pub(crate) fn one_of<T: Copy, const N: usize>(&mut self, values: [T; N]) -> T {
        values[(self.bits() % N as u64) as usize]
    }

    /// A magnitude as by [`Source::logarithmic`] with a random sign.
    pub(crate) fn signed(&mut self, lowest: f64, highest: f64) -> f64 {
        self.one_of([-1.0, 1.0]) * self.logarithmic(lowest, highest)
    }
}
