//! The strongest line near a resonance, and the spectral density there, from 16-bit samples in integers: a bank of
//! Goertzel's bins for the price of one.
//!
//! A bin of Goertzel's recursion takes a multiplication and two additions a sample, so a bank over the resonance takes as
//! many times that as it has bins. Here the samples are first multiplied with *one* reference at a frequency beside the
//! resonance and summed over sections of `m` samples, in 32 bits. The reference has a whole number `k` of periods in a
//! section, so it needs a table of `m` entries, and gravity, its harmonics and those of the section's rate vanish exactly
//! but for rounding. Then each bin is a sum over the `P` sections of a block,
//!
//! ```text
//! X_b = Σ_p z_p e^(−2πi b p/P),   z_p = Σ_n x_n e^(−2πi k n/m),   f_b = (k + b/P) r/m,
//! ```
//!
//! with `r` the rate of the samples: exact up to the attenuation of the sections, `sinc(b/P)`, which is divided out. A Hann
//! window, `Y_b = X_b − (X_(b−1) + X_(b+1))/2`, keeps lines apart that are two bins or more from each other. The place of a
//! line between two bins follows from the ratio of the two (M. Jain and others, IEEE Trans. Instrum. Meas. 28, 1979, with
//! the window's ratio (2 r − 1)/(r + 1)).
//!
//! A line at a distance of `d` section rates from the reference, beyond the bins, appears at the fraction of `d`, attenuated
//! to `sinc(d)`: by at least 10 dB at the nearest that appears among the bins, three quarters of a section rate, and by 20 dB at
//! nine tenths.

#[cfg(test)]
mod tests;

use super::ExcitationError;
use crate::bounds::Bounds;
use crate::scalar::{Mathematics, Polynomial, Scalar};
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// Unit of the reference: sums of 128 samples of 16 bits fit in 32 bits.
const REFERENCE: f32 = 256.0;
/// Unit of the rotation of the bins.
const ROTATION: f32 = 2048.0;
/// Bits that a normalised section has at most.
const SECTION_BITS: u32 = 13;
/// Fewest samples that a section may have, and most.
const LEAST_SAMPLES: usize = 16;
pub(crate) const MOST_SAMPLES: usize = 128;
/// Most sections in a block.
const MOST_SECTIONS: usize = 32;
/// Most bins, and one.
const MOST_BINS: usize = MOST_SECTIONS / 2 + 2;
/// Bins to each side of a line that its lobe reaches.
const LOBE: u32 = 2;
/// Equivalent noise bandwidth of a Hann window, in bins.
const NOISE_BINS: f32 = 1.5;

/// What a block says about the band of the resonance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lines {
    /// Amplitude of the strongest line in m/s²; 0 without one.
    pub amplitude: f32,
    /// Its frequency in Hz.
    pub frequency: f32,
    /// Part of the band's power that is in this line, 0 to 1; of a steady line alone at least 0.998.
    pub purity: f32,
    /// One-sided spectral density of the acceleration near the resonance, all lines included, in (m/s²)²/Hz: the mean over
    /// the bins within a half-bandwidth and one bin of the resonance. Of noise it has a relative standard deviation of 0.85 in
    /// a block where these are two bins, and of 0.73 where they are three; average over blocks.
    pub density: f32,
    /// The same without the bins of the strongest line: what else the resonance hears; 0 if the line has all of them.
    pub rest: f32,
}

/// A bank of bins beside a resonance, for sections of at most `M` samples and blocks of `P` sections.
///
/// `P` is a power of two from 8 to 32; the bins reach a quarter of a section's rate to both sides of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineBank<const M: usize, const P: usize> {
    /// Cosine and minus sine of the reference, as words: both are loaded at once.
    reference: [[i32; 2]; M],
    /// Cosine and minus sine of `p/P` turns.
    rotation: [[i16; 2]; P],
    samples: usize,
    /// Frequency of the reference in Hz.
    reference_hz: f32,
    /// Distance of two bins in Hz.
    bin_hz: f32,
    /// Bins of the density, from the reference: the lowest and the highest.
    near: [i32; 2],
    /// What the power of each bin is multiplied with, the lowest first: the square of what the sections attenuate it by.
    gain: [f32; MOST_BINS],
    /// m/s² of one count.
    unit: f32,
}

/// The sums of a [`LineBank`] between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineBankState<const P: usize> {
    /// Samples of this section so far.
    place: u32,
    /// Whole sections of this block.
    count: u32,
    section: [i32; 2],
    sections: [[i32; 2]; P],
}

impl<const P: usize> Default for LineBankState<P> {
    fn default() -> Self {
        Self { place: 0, count: 0, section: [0; 2], sections: [[0; 2]; P] }
    }
}

impl<const M: usize, const P: usize> LineBank<M, P> {
    /// Bins to each side of the reference.
    const REACH: i32 = P as i32 / 4;

    /// A bank for `rate` samples per second of `unit` m/s² a count, beside a resonance at `frequency` in Hz of a half-bandwidth
    /// in Hz.
    ///
    /// # Errors
    /// [`ExcitationError::Bank`], [`ExcitationError::Band`], [`ExcitationError::Block`].
    #[cold]
    #[inline(never)]
    pub fn new(rate: f32, frequency: f32, half_bandwidth: f32, unit: f32) -> Result<Self, ExcitationError> {
        const { assert!(P.is_power_of_two() && P >= 8 && P <= MOST_SECTIONS, "8, 16 or 32 sections") };
        let half_rate = 0.45 * rate;
        for (field, value, lowest, highest) in [
            ("M", real(M), real(LEAST_SAMPLES), real(MOST_SAMPLES)),
            ("unit", unit, f32::MIN_POSITIVE, f32::MAX),
            ("rate", rate, 1.0, 1e5),
            ("frequency", frequency, 2.0 * rate / real(M), half_rate),
            ("half_bandwidth", half_bandwidth, f32::MIN_POSITIVE, half_rate),
        ] {
            Bounds { lowest, highest }.check(field, value).map_err(ExcitationError::Bank)?;
        }
        let (samples, cycles) = Self::section(rate, frequency);
        let section_rate = rate / real(samples);
        let reference_hz = section_rate * real(cycles);
        let bin_hz = section_rate / real(P);
        let low = (frequency - half_bandwidth - reference_hz) / bin_hz - 1.0;
        let high = (frequency + half_bandwidth - reference_hz) / bin_hz + 1.0;
        let reach = f32::from_i32(Self::REACH) + 1.0;
        if !(low > -reach && high < reach) {
            let off = Scalar::abs(frequency - reference_hz);
            let limit = f32::from_i32(Self::REACH) * bin_hz - off;
            return Err(ExcitationError::Band { section_rate, half_bandwidth, limit });
        }
        let (seconds, least) = (1.0 / bin_hz, 1.0 / (core::f32::consts::TAU * half_bandwidth));
        if seconds < least {
            return Err(ExcitationError::Block { seconds, least });
        }
        let mut bank = Self {
            reference: [[0; 2]; M],
            rotation: [[0; 2]; P],
            samples,
            reference_hz,
            bin_hz,
            near: [floor(low) + 1, floor(high)],
            gain: core::array::from_fn(|index| {
                1.0 / Self::droop_square(f32::from_i32(index as i32 - Self::REACH))
            }),
            unit,
        };
        for (n, entry) in bank.reference.iter_mut().enumerate().take(samples) {
            *entry = turned(n * cycles, samples, REFERENCE).map(i32::from);
        }
        bank.balance();
        for (p, entry) in bank.rotation.iter_mut().enumerate() {
            *entry = turned(p, P, ROTATION);
        }
        Ok(bank)
    }

    /// Takes from the reference what rounding left of its mean, a unit from each of the first entries.
    fn balance(&mut self) {
        let sum = self.reference.iter().fold([0_i32; 2], |[a, b], [c, s]| [a + c, b + s]);
        for entry in self.reference.iter_mut().enumerate() {
            let (index, [cosine, sine]) = entry;
            let unit = |sum: i32| if index < sum.unsigned_abs() as usize { sum.signum() } else { 0 };
            *cosine -= unit(sum[0]);
            *sine -= unit(sum[1]);
        }
    }

    /// The section, of at least half of `M` samples, whose reference is nearest to the resonance: samples and periods. At two
    /// section rates or above there is one.
    fn section(rate: f32, frequency: f32) -> (usize, usize) {
        let (mut least, mut best) = (f32::INFINITY, (M, 2));
        for samples in M.div_ceil(2)..=M {
            let periods = frequency * real(samples) / rate;
            let cycles = (periods + 0.5) as usize;
            let off = (real(cycles) * rate / real(samples) - frequency).abs();
            // Of equal ones the longer, as its section needs fewer rotations.
            if cycles >= 2 && off <= least {
                (least, best) = (off, (samples, cycles));
            }
        }
        best
    }

    /// Samples in a block.
    #[must_use]
    pub fn block(&self) -> usize {
        self.samples * P
    }

    /// Samples in a second, to a rounding.
    #[must_use]
    pub fn rate(&self) -> f32 {
        self.bin_hz * real(P) * real(self.samples)
    }

    /// Frequency of the lowest and of the highest bin in Hz.
    #[must_use]
    pub fn band(&self) -> [f32; 2] {
        [-Self::REACH, Self::REACH].map(|bin| self.reference_hz + f32::from_i32(bin) * self.bin_hz)
    }

    /// The frequencies of the bins in Hz.
    pub(crate) fn frequencies(&self) -> impl Iterator<Item = f32> {
        (-Self::REACH..=Self::REACH).map(|bin| self.reference_hz + f32::from_i32(bin) * self.bin_hz)
    }

    /// Frequency of the reference in Hz.
    #[must_use]
    pub fn reference_frequency(&self) -> f32 {
        self.reference_hz
    }

    /// The state before the first sample.
    #[must_use]
    pub fn start(&self) -> LineBankState<P> {
        LineBankState::default()
    }

    /// Takes samples until a block is full: gives the number of samples taken, and the lines if it is.
    ///
    /// Call it again with the samples that are left.
    #[inline]
    pub fn take(&self, state: &mut LineBankState<P>, samples: &[i16]) -> (usize, Option<Lines>) {
        let mut taken = 0;
        while let Some(left) = samples.get(taken..)
            && !left.is_empty()
        {
            let from = state.place as usize;
            let reference = self.reference.get(from..self.samples).unwrap_or(&[]);
            let [mut cosine, mut sine] = state.section;
            let count = left.len().min(reference.len());
            for (&sample, &[c, s]) in left.iter().zip(reference) {
                let sample = i32::from(sample);
                cosine = cosine.wrapping_add(sample * c);
                sine = sine.wrapping_add(sample * s);
            }
            state.section = [cosine, sine];
            state.place += count as u32;
            taken += count;
            if state.place as usize >= self.samples && self.end_section(state) {
                let lines = self.lines(state);
                *state = LineBankState::default();
                return (taken, Some(lines));
            }
        }
        (taken, None)
    }

    /// Ends a section; whether it was the last of its block.
    fn end_section(&self, state: &mut LineBankState<P>) -> bool {
        if let Some(entry) = state.sections.get_mut(state.count as usize) {
            *entry = state.section;
        }
        state.section = [0; 2];
        state.place = 0;
        state.count += 1;
        state.count as usize >= P
    }

    /// The lines of a full block.
    #[cold]
    #[inline(never)]
    fn lines(&self, state: &LineBankState<P>) -> Lines {
        let sums = state.sections.iter().flatten();
        let largest = sums.fold(0, |largest: u32, sum| largest.max(sum.unsigned_abs()));
        let shift = (32 - largest.leading_zeros()).saturating_sub(SECTION_BITS);
        let sections = state.sections.map(|section| section.map(|sum| sum >> shift));
        let squares = self.squares(&sections);
        // Counts times samples, of one unit of a bin.
        let scale = f32::from_u32(1 << shift) * (1.0 / (REFERENCE * ROTATION));
        let (mut strongest, mut place, mut beside) = (0.0_f32, 0, [0.0_f32; 2]);
        let (mut total, mut near, mut near_count) = (0.0_f32, 0.0_f32, 0);
        let mut below = 0.0;
        for (index, &here) in squares.iter().enumerate().take(2 * Self::REACH as usize + 1) {
            let bin = index as i32 - Self::REACH;
            let above = squares.get(index + 1).copied().unwrap_or(0.0);
            if here > strongest {
                (strongest, place, beside) = (here, bin, [below, above]);
            }
            total += here;
            if bin >= self.near[0] && bin <= self.near[1] {
                near += here * self.gain_of(index);
                near_count += 1;
            }
            below = here;
        }
        if !(strongest > 0.0) {
            return Lines::default();
        }
        let mut rest = 0.0_f32;
        for (index, &square) in squares.iter().enumerate().take(2 * Self::REACH as usize + 1) {
            let bin = index as i32 - Self::REACH;
            if bin >= self.near[0] && bin <= self.near[1] && bin.abs_diff(place) > LOBE {
                rest += square * self.gain_of(index);
            }
        }
        let (larger, towards) = if beside[1] > beside[0] { (beside[1], 1.0) } else { (beside[0], -1.0) };
        let ratio = Scalar::sqrt(larger / strongest);
        let off = towards * Scalar::max((2.0 * ratio - 1.0) / (ratio + 1.0), 0.0);
        // The line's own part of the bin beyond the larger neighbour: the ratio of the window's lobes at 2 − x and x bins.
        let (x, next) = (off.abs(), place + Self::REACH + 2 * if towards > 0.0 { 1 } else { -1 });
        let lobes = x * (1.0 + x) / ((2.0 - x) * (3.0 - x));
        let next = usize::try_from(next).ok().and_then(|index| squares.get(index)).copied().unwrap_or(0.0);
        let beyond = Scalar::min(next, strongest * lobes * lobes);
        let bins = f32::from_i32(place) + off;
        let samples = real(self.block());
        // The lobe of the window is sinc(x)/(1 − x²), and a sine of amplitude 1 has the sum N/2.
        let lobe = sinc(off) / (1.0 - off * off);
        let peak = Scalar::sqrt(strongest / Self::droop_square(bins)) * scale / lobe;
        let of_line = (strongest + beside[0] + beside[1] + beyond) / total;
        // 2 |Σ w x e|²/(r Σ w²), with Σ w² = 3/2 N and the rate r of N bins.
        let noise = NOISE_BINS * samples * samples * self.bin_hz * f32::from_i32(near_count.max(1));
        let density = 2.0 * scale * scale / noise * self.unit * self.unit;
        Lines {
            amplitude: 2.0 * peak / samples * self.unit,
            frequency: self.reference_hz + bins * self.bin_hz,
            purity: Scalar::min(of_line, 1.0),
            density: density * near,
            rest: density * rest,
        }
    }

    /// Square of the attenuation of a section at a distance of `bins` from the reference.
    fn droop_square(bins: f32) -> f32 {
        let droop = sinc(bins / real(P));
        droop * droop
    }

    fn gain_of(&self, index: usize) -> f32 {
        self.gain.get(index).copied().unwrap_or(1.0)
    }

    /// Squares of the magnitudes of the bins with the window of Hann, the lowest first, and zeros.
    fn squares(&self, sections: &[[i32; 2]; P]) -> [f32; MOST_BINS] {
        let mut squares = [0.0; MOST_BINS];
        // One more to each side than squares.
        let mut bins = [[0_i32; 2]; MOST_BINS + 1];
        let reach = Self::REACH as usize + 1;
        for bin in 0..=reach {
            let [of_minus, of_plus] = self.pair(sections, bin);
            for (place, value) in [(reach - bin, of_minus), (reach + bin, of_plus)] {
                if let Some(entry) = bins.get_mut(place) {
                    *entry = value;
                }
            }
        }
        for (square, bins) in squares.iter_mut().zip(bins.windows(3)).take(2 * Self::REACH as usize + 1) {
            let &[below, here, above] = bins else { continue };
            // In integers: software floating point takes several times as many instructions.
            let part = |here: i32, below: i32, above: i32| f32::from_i32(here - ((below + above) >> 1));
            let [real, imaginary] = [part(here[0], below[0], above[0]), part(here[1], below[1], above[1])];
            *square = real * real + imaginary * imaginary;
        }
        squares
    }

    /// The bins at `−bin` and at `bin` without a window: parts below 2³⁰, of sections of [`SECTION_BITS`] bits. Both have the
    /// same four products of a section.
    fn pair(&self, sections: &[[i32; 2]; P], bin: usize) -> [[i32; 2]; 2] {
        let (mut minus, mut plus) = ([0_i32; 2], [0_i32; 2]);
        let mut turn = 0_usize;
        for &[a, b] in sections {
            let [c, s] = self.rotation.get(turn & (P - 1)).map_or([0, 0], |pair| pair.map(i32::from));
            let [ac, bs, a_s, bc] = [a * c, b * s, a * s, b * c];
            plus = [plus[0].wrapping_add(ac - bs), plus[1].wrapping_add(a_s + bc)];
            minus = [minus[0].wrapping_add(ac + bs), minus[1].wrapping_add(bc - a_s)];
            turn = turn.wrapping_add(bin);
        }
        [minus, plus]
    }
}

/// A count as a number.
fn real(count: usize) -> f32 {
    f32::from_u32(count as u32)
}

/// The largest whole number that is not above `number`, which is within a thousand of 0.
fn floor(number: f32) -> i32 {
    (number + 1024.0) as i32 - 1024
}

/// Cosine and minus sine of `part/whole` turns, times `unit`, rounded.
#[inline(never)]
fn turned(part: usize, whole: usize, unit: f32) -> [i16; 2] {
    // The upper word of the phase is enough.
    let (part, step) =
        (part.checked_rem(whole).unwrap_or(0), u32::MAX.checked_div(whole as u32).unwrap_or(0));
    let phase = u64::from(part as u32 * step) << 32;
    let round = |number: f32| (number * unit + 4096.5) as i32 - 4096;
    let cosine: f32 = Polynomial::cosine_of_turns(phase);
    let sine: f32 = Polynomial::sine_of_turns(phase);
    [round(cosine) as i16, round(-sine) as i16]
}

/// `sin(πx)/(πx)` to 10⁻⁴ for |x| up to 0.6, by its series.
fn sinc(x: f32) -> f32 {
    let y = x * x;
    1.0 - y * (1.644_934 - y * (0.811_742_4 - y * (0.190_751_8 - y * 0.026_147_8)))
}

snapshot_fields!(impl [const P: usize] LineBankState<P> { place, count, section, sections }
    if |state| (state.place as usize) < MOST_SAMPLES && (state.count as usize) < P);

impl<const M: usize, const P: usize> Configuration for LineBank<M, P> {
    type State = LineBankState<P>;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("line bank");
        fingerprint.numbers(&[self.reference_hz, self.bin_hz, self.unit]);
        fingerprint.count(self.samples as u32);
        fingerprint.count(P as u32);
    }
}
