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
use crate::bounds::first_outside;
use crate::scalar::{Scalar, sine_of_phase};
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// Unit of the reference: sums of 128 samples of 16 bits fit in 32 bits.
const REFERENCE: f32 = 256.0;
/// Unit of the rotation of the bins.
const ROTATION: f32 = 2048.0;
/// Bits that a normalised section has at most.
const SECTION_BITS: u32 = 13;
/// Fewest samples that a section may have, and most.
const LEAST_SAMPLES: usize = 16;
const MOST_SAMPLES: usize = 128;
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
    /// The same without the bins of the strongest line: what else excites the resonance; 0 if the line has all of them.
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
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    pub const fn new(
        rate: f32,
        frequency: f32,
        half_bandwidth: f32,
        unit: f32,
    ) -> Result<Self, ExcitationError> {
        const { assert!(P.is_power_of_two() && P >= 8 && P <= MOST_SECTIONS, "8, 16 or 32 sections") };
        let half_rate = 0.45 * rate;
        if let Some(error) = first_outside(&[
            ("M", real(M), real(LEAST_SAMPLES), real(MOST_SAMPLES)),
            ("unit", unit, f32::MIN_POSITIVE, f32::MAX),
            ("rate", rate, 1.0, 1e5),
            ("frequency", frequency, 2.0 * rate / real(M), half_rate),
            ("half_bandwidth", half_bandwidth, f32::MIN_POSITIVE, half_rate),
        ]) {
            return Err(ExcitationError::Bank(error));
        }
        let (samples, cycles) = Self::section(rate, frequency);
        let section_rate = rate / real(samples);
        let reference_hz = section_rate * real(cycles);
        let bin_hz = section_rate / real(P);
        let low = (frequency - half_bandwidth - reference_hz) / bin_hz - 1.0;
        let high = (frequency + half_bandwidth - reference_hz) / bin_hz + 1.0;
        let reach = Self::REACH as f32 + 1.0;
        if !(low > -reach && high < reach) {
            let limit = Self::REACH as f32 * bin_hz - (frequency - reference_hz).abs();
            return Err(ExcitationError::Band { section_rate, half_bandwidth, limit });
        }
        let (seconds, least) = (1.0 / bin_hz, 1.0 / (core::f32::consts::TAU * half_bandwidth));
        if seconds < least {
            return Err(ExcitationError::Block { seconds, least });
        }
        let near = [floor(low).wrapping_add(1), floor(high)];
        let (reference, rotation, gain) = Self::tables(samples, cycles);
        Ok(Self { reference, rotation, samples, reference_hz, bin_hz, near, gain, unit })
    }

    /// The reference of a section, the rotation of the bins, and what their powers are multiplied with.
    const fn tables(samples: usize, cycles: usize) -> ([[i32; 2]; M], [[i16; 2]; P], [f32; MOST_BINS]) {
        let (mut reference, mut rotation, mut gain) = ([[0; 2]; M], [[0; 2]; P], [0.0; MOST_BINS]);
        let mut sum = [0_i32; 2];
        let mut index = 0;
        while index < samples && index < M {
            let [cosine, sine] = turned(index.wrapping_mul(cycles), samples, REFERENCE);
            reference[index] = [cosine as i32, sine as i32];
            sum = [sum[0].wrapping_add(cosine as i32), sum[1].wrapping_add(sine as i32)];
            index += 1;
        }
        // What rounding left of its mean: a unit from each of the first entries.
        index = 0;
        while index < 2 * M {
            let (entry, part) = (index / 2, index % 2);
            if entry < sum[part].unsigned_abs() as usize {
                reference[entry][part] = reference[entry][part].wrapping_sub(sum[part].signum());
            }
            index += 1;
        }
        index = 0;
        while index < P {
            rotation[index] = turned(index, P, ROTATION);
            index += 1;
        }
        index = 0;
        while index < MOST_BINS {
            gain[index] = 1.0 / Self::droop_square((index as i32 - Self::REACH) as f32);
            index += 1;
        }
        (reference, rotation, gain)
    }

    /// The section, of at least half of `M` samples, whose reference is nearest to the resonance: samples and periods. At two
    /// section rates or above there is one.
    const fn section(rate: f32, frequency: f32) -> (usize, usize) {
        let (mut least, mut best) = (f32::INFINITY, (M, 2));
        let mut samples = M.div_ceil(2);
        while samples <= M {
            let periods = frequency * real(samples) / rate;
            let cycles = (periods + 0.5) as usize;
            let off = (real(cycles) * rate / real(samples) - frequency).abs();
            // Of equal ones the longer, as its section needs fewer rotations.
            if cycles >= 2 && off <= least {
                (least, best) = (off, (samples, cycles));
            }
            samples += 1;
        }
        best
    }

    /// Samples in a block.
    #[must_use]
    pub const fn block(&self) -> usize {
        self.samples.wrapping_mul(P)
    }

    /// Samples in a second, to a rounding.
    #[must_use]
    pub const fn rate(&self) -> f32 {
        self.bin_hz * real(P) * real(self.samples)
    }

    /// Frequency of the lowest and of the highest bin in Hz.
    #[must_use]
    pub const fn band(&self) -> [f32; 2] {
        let reach = Self::REACH as f32 * self.bin_hz;
        [self.reference_hz - reach, self.reference_hz + reach]
    }

    /// Bins, and the frequency of one of them in Hz, the lowest first.
    pub(crate) const BINS: usize = P / 2 + 1;
    pub(crate) const fn bin_frequency(&self, index: usize) -> f32 {
        self.reference_hz + (index as i32 - Self::REACH) as f32 * self.bin_hz
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
        let taken = self.sum(state, samples);
        let is_full = state.count as usize >= P && self.transform(state);
        (taken, if is_full { self.lines(state) } else { None })
    }

    /// Takes samples until a block is full: gives the number of samples taken. A full block takes none before its lines are asked for.
    #[inline]
    pub(crate) fn sum(&self, state: &mut LineBankState<P>, samples: &[i16]) -> usize {
        let mut taken = 0;
        while let Some(left) = samples.get(taken..)
            && !left.is_empty()
            && let Some(entry) = state.sections.get_mut(state.count as usize)
        {
            let from = state.place as usize;
            let reference = self.reference.get(from..self.samples).unwrap_or(&[]);
            let [mut cosine, mut sine] = state.section;
            let count = left.len().min(reference.len());
            for (&sample, &[c, s]) in left.iter().zip(reference) {
                let sample = i32::from(sample);
                cosine = cosine.wrapping_add(sample.wrapping_mul(c));
                sine = sine.wrapping_add(sample.wrapping_mul(s));
            }
            state.section = [cosine, sine];
            state.place = state.place.wrapping_add(count as u32);
            taken += count;
            if state.place as usize >= self.samples {
                (*entry, state.section, state.place) = (state.section, [0; 2], 0);
                state.count = state.count.wrapping_add(1);
            }
        }
        taken
    }

    /// Puts the squares of the bins with the window of Hann, the lowest first, and zeros in the place of the sections of a full block, and the
    /// bits that these lose in that of the section; whether there was one.
    #[cold]
    #[inline(never)]
    pub(crate) fn transform(&self, state: &mut LineBankState<P>) -> bool {
        if state.count as usize != P {
            return false;
        }
        let sums = state.sections.iter().flatten();
        let largest = sums.fold(0, |largest: u32, sum| largest.max(sum.unsigned_abs()));
        let shift = (32 - largest.leading_zeros()).saturating_sub(SECTION_BITS);
        Self::fold(&mut state.sections, shift);
        // One more to each side than squares.
        let mut bins = [[0; 2]; MOST_BINS + 1];
        for (place, bin) in (0..Self::BINS.saturating_add(2)).zip(&mut bins) {
            *bin = self.bin(&state.sections, place.wrapping_sub(Self::REACH as usize + 1));
        }
        *state = LineBankState { count: P as u32 + 1, place: shift, ..LineBankState::default() };
        for ([square, _], bins) in state.sections.iter_mut().zip(bins.windows(3)).take(Self::BINS) {
            let &[below, here, above] = bins else { continue };
            // In integers: software floating point takes several times as many instructions.
            let part = |a: i32, b: i32, c: i32| f32::from_i32(b.wrapping_sub(a.wrapping_add(c) >> 1));
            let [real, imaginary] = [part(below[0], here[0], above[0]), part(below[1], here[1], above[1])];
            *square = (real * real + imaginary * imaginary).to_bits().cast_signed();
        }
        true
    }

    /// The lines of a block whose bins are known; begins the next one.
    #[cold]
    #[inline(never)]
    pub(crate) fn lines(&self, state: &mut LineBankState<P>) -> Option<Lines> {
        if state.count as usize <= P {
            return None;
        }
        let LineBankState { place: shift, sections, .. } = core::mem::take(state);
        let squares = sections.map(|[bits, _]| f32::from_bits(bits.cast_unsigned()));
        // Counts times samples, of one unit of a bin.
        let scale = f32::from_u32(1_u32.wrapping_shl(shift)) * (1.0 / (REFERENCE * ROTATION));
        let (mut strongest, mut place, mut beside) = (0.0_f32, 0, [0.0_f32; 2]);
        let (mut total, mut near, mut near_count, mut below) = (0.0_f32, 0.0_f32, 0_i32, 0.0);
        for (index, &here) in (0..Self::BINS).zip(&squares) {
            let bin = (index as i32).wrapping_sub(Self::REACH);
            let above = squares.get(index.wrapping_add(1)).copied().unwrap_or(0.0);
            if here > strongest {
                (strongest, place, beside) = (here, bin, [below, above]);
            }
            total += here;
            if bin >= self.near[0] && bin <= self.near[1] {
                near += here * self.gain_of(index);
                near_count = near_count.wrapping_add(1);
            }
            below = here;
        }
        if !(strongest > 0.0) {
            return Some(Lines::default());
        }
        let mut rest = 0.0_f32;
        for (index, &square) in (0..Self::BINS).zip(&squares) {
            let bin = (index as i32).wrapping_sub(Self::REACH);
            if bin >= self.near[0] && bin <= self.near[1] && bin.abs_diff(place) > LOBE {
                rest += square * self.gain_of(index);
            }
        }
        let (larger, towards) = if beside[1] > beside[0] { (beside[1], 1.0) } else { (beside[0], -1.0) };
        let ratio = Scalar::sqrt(larger / strongest);
        let off = towards * Scalar::max((2.0 * ratio - 1.0) / (ratio + 1.0), 0.0);
        // The line's own part of the bin beyond the larger neighbour: the ratio of the window's lobes at 2 − x and x bins.
        let (x, next) = (off.abs(), place.wrapping_add(Self::REACH + if towards > 0.0 { 2 } else { -2 }));
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
        Some(Lines {
            amplitude: 2.0 * peak / samples * self.unit,
            frequency: self.reference_hz + bins * self.bin_hz,
            purity: Scalar::min(of_line, 1.0),
            density: density * near,
            rest: density * rest,
        })
    }

    /// Square of the attenuation of a section at a distance of `bins` from the reference.
    const fn droop_square(bins: f32) -> f32 {
        let droop = sinc(bins / real(P));
        droop * droop
    }

    fn gain_of(&self, index: usize) -> f32 {
        self.gain.get(index).copied().unwrap_or(1.0)
    }

    /// Puts what the bins `4 k`, `4 k + 2`, `4 k + 1` and `4 k + 3` are summed of in the four quarters of the sections, which lose `shift` bits:
    /// the rotation of a quarter of the sections is a quarter turn, exactly.
    fn fold(sections: &mut [[i32; 2]; P], shift: u32) {
        let mut quarters = sections.chunks_exact_mut((P / 4).max(1));
        let [Some(a), Some(b), Some(c), Some(d)] = [(); 4].map(|()| quarters.next()) else { return };
        for (((a, b), c), d) in a.iter_mut().zip(b).zip(c).zip(d) {
            let sums = [*a, *b, *c, *d].map(|sums| sums.map(|sum| sum.wrapping_shr(shift)));
            let (even, other) = (add(sums[0], sums[2]), add(sums[1], sums[3]));
            let (odd, [real, imaginary]) = (less(sums[0], sums[2]), less(sums[1], sums[3]));
            let turned = [imaginary, real.wrapping_neg()];
            (*a, *b, *c, *d) = (add(even, other), less(even, other), add(odd, turned), less(odd, turned));
        }
    }

    /// A bin without a window, of folded sections: parts below 2³⁰, of sections of [`SECTION_BITS`] bits.
    fn bin(&self, sections: &[[i32; 2]; P], bin: usize) -> [i32; 2] {
        let quarter = [0, 2, 1, 3].get(bin % 4).copied().unwrap_or(0);
        let (mut sum, mut turn) = ([0; 2], 0_usize);
        for &[a, b] in sections.iter().skip(quarter * (P / 4)).take(P / 4) {
            let [c, s] = self.rotation.get(turn & (P - 1)).map_or([0, 0], |pair| pair.map(i32::from));
            let [ac, bs, a_s, bc] =
                [(a, c), (b, s), (a, s), (b, c)].map(|(one, other)| one.wrapping_mul(other));
            sum = add(sum, [ac.wrapping_sub(bs), a_s.wrapping_add(bc)]);
            turn = turn.wrapping_add(bin);
        }
        sum
    }
}

const fn add([a, b]: [i32; 2], [c, d]: [i32; 2]) -> [i32; 2] {
    [a.wrapping_add(c), b.wrapping_add(d)]
}

const fn less([a, b]: [i32; 2], [c, d]: [i32; 2]) -> [i32; 2] {
    [a.wrapping_sub(c), b.wrapping_sub(d)]
}

/// A count as a number.
const fn real(count: usize) -> f32 {
    count as f32
}

/// The largest whole number that is not above `number`, which is within a thousand of 0.
const fn floor(number: f32) -> i32 {
    ((number + 1024.0) as i32).wrapping_sub(1024)
}

/// Cosine and minus sine of `part/whole` turns, times `unit`, rounded.
const fn turned(part: usize, whole: usize, unit: f32) -> [i16; 2] {
    let (Some(part), Some(step)) = (part.checked_rem(whole), u32::MAX.checked_div(whole as u32)) else {
        return [0; 2];
    };
    let phase = (part as u32).wrapping_mul(step);
    let cosine = sine_of_phase(phase.wrapping_add(1 << 30)) * unit + 4096.5;
    let sine = -sine_of_phase(phase) * unit + 4096.5;
    [(cosine as i32).wrapping_sub(4096) as i16, (sine as i32).wrapping_sub(4096) as i16]
}

/// `sin(πx)/(πx)` to 10⁻⁴ for |x| up to 0.6, by its series.
const fn sinc(x: f32) -> f32 {
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
