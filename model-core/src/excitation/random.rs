//! Band-limited random acceleration with a given spectral density, reproducible from a seed.

use core::cell::Cell;
use core::marker::PhantomData;

use heapless::Vec;

use super::integers::divide;
use super::sample_grid::SampleGrid;
use super::{Excitation, ExcitationError, Line, SpectralDensity};
use crate::clock::{Frequency, Instant};
use crate::oscillator::{Kernel, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar};

/// Knots of the spline in a period of the highest frequency, as a power of two.
const KNOTS_LOG2: u32 = 3;
/// Turns in a knot of the highest frequency, in units of 2⁻⁶⁴.
const HIGHEST_TURNS: u64 = 1 << (64 - KNOTS_LOG2);
/// Knots that are kept: those of two pieces.
const KEPT: usize = 5;

/// Random acceleration with a one-sided spectral density, from a seed: a sum of sines, joined by a cubic spline.
///
/// # The sum
///
/// `a(t) = Σ √(2 S(f_k) Δf_k) sin(2π f_k t + φ_k)` (Shinozuka and Deodatis, Applied Mechanics Reviews 44, 1991), with
/// one frequency `f_k` in each part of the band and a phase `φ_k`, drawn independently and evenly by SplitMix64 (Steele,
/// Lea and Flood, OOPSLA 2014). From the lowest frequency on, each octave has the same number of parts of equal width.
/// So over the seeds the mean square of `a`, and that of any linear response to it, are exactly the integrals over the
/// density, `∫ S df` and `∫ |H|² S df`, at any number of lines.
///
/// * **Period**: the frequencies are not multiples of a common one, so the acceleration does not repeat within the
///   clock's range.
/// * **Distribution**: that of a sum of sines with independent phases. Its kurtosis is `3 − 3/2 · Σ A⁴/(Σ A²)²`, near the
///   3 of a Gaussian; no value exceeds `Σ A`.
/// * **Resolution**: a resonance answers like noise if several lines are within its half-power bandwidth; see
///   [`Random::spacing`]. With fewer it answers like a few beating sines. Over times longer than the reciprocal of the
///   spacing, means differ less from seed to seed than those of a process with a continuous spectrum.
///
/// # The spline
///
/// The sum is computed at knots, eight in a period of the highest frequency, and joined by a cubic spline whose filter is
/// compensated in the amplitudes. What the spline adds to the sum is above seven times the highest frequency, with
/// less than 2·10⁻⁷ of the spectral density. A step within a piece costs the same with any number of lines, and the
/// response to it is exact; a new piece costs a sine for each line.
///
/// Frequencies and phases are integers: both precisions draw the same ones, if the ends of the band are numbers of both.
/// The pieces in use are kept in a cell, so the type is not `Sync`; the acceleration does not depend on them.
///
/// ```
/// use model_core::clock::Instant;
/// use model_core::excitation::{Excitation, Random, SpectralDensity};
///
/// let points = [[10.0_f32, 1.0], [40.0, 1.0], [200.0, 0.1]]; // Hz, (m/s²)²/Hz
/// let density = SpectralDensity::new(&points)?;
/// let random = Random::<f32, 64>::new(&density, 64, 1)?; // 64 lines, seed 1
/// let again = Random::<f32, 64>::new(&density, 64, 1)?;
/// let at = Instant::from_whole_seconds(3);
/// assert_eq!(random.acceleration(at), again.acceleration(at));
/// # Ok::<(), model_core::excitation::ExcitationError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Random<S: Scalar, const LINES: usize, M = Polynomial> {
    lines: Vec<Drawn<S>, LINES>,
    grid: SampleGrid<S>,
    /// Ticks from one knot to the next, rounded down.
    interval: u32,
    /// Of the highest frequency, in rad/s.
    angular_frequency: S,
    band: Band<S>,
    knots: Cell<Knots<S>>,
    mathematics: PhantomData<M>,
}

/// A sine of the sum.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drawn<S> {
    /// Amplitude in m/s², over the spline's factor at the frequency.
    coefficient: S,
    /// Turns from one knot to the next, in units of 2⁻⁶⁴.
    turns: u64,
    /// Phase at the knot before time zero, in units of 2⁻⁶⁴ turns.
    phase: u64,
}

/// The sum at successive knots, divided by the spline's factors.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knots<S> {
    /// Number of the piece that begins at the second of them.
    piece: u64,
    values: [S; KEPT],
}

/// A sine of a random acceleration, `A sin(2π f t + φ)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralLine<S> {
    /// `A` in m/s².
    pub amplitude: S,
    /// `f` in Hz.
    pub frequency: S,
    /// `φ` in rad, 0 to 2π.
    pub phase: S,
}

/// The division of the band: octaves from the lowest frequency on, the last one cut.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Band<S> {
    /// Turns of the lowest frequency in a knot, in units of 2⁻⁶⁴.
    lowest: u64,
    /// Frequency in Hz of one turn in two knots.
    per_half_turn: S,
    /// Width of a part, in units of 2⁻⁵⁶ octaves.
    width: u64,
    /// The same in octaves.
    octaves: S,
}

impl<S: Scalar> Band<S> {
    fn new([low, high]: [S; 2], rate: S, lines: u32) -> Result<Self, ExcitationError> {
        let units = |frequency| Frequency::from_hertz(frequency).ok_or(ExcitationError::Frequency);
        let ratio = divide(units(low)?.units(), 64 - KNOTS_LOG2, units(high)?.units());
        // The frequencies are in bounds, so their ratio is above 2⁻²⁷.
        let lowest = (ratio as u64).clamp(1 << 32, HIGHEST_TURNS);
        let whole = lowest.leading_zeros() - HIGHEST_TURNS.leading_zeros();
        let whole = if (lowest << whole) > HIGHEST_TURNS { whole - 1 } else { whole };
        let octave = lowest << whole;
        let rest = divide(u128::from(HIGHEST_TURNS - octave), 32, u128::from(octave)) as u64;
        let length = (u64::from(whole) << 32) + rest;
        let width = (length << 24).checked_div(u64::from(lines)).unwrap_or(0);
        let octaves = fraction::<S>(width) * S::power_of_two(7);
        Ok(Self { lowest, per_half_turn: S::from_f64(0.5) * rate, width, octaves })
    }

    /// Frequency in Hz of a number of turns in a knot.
    fn hertz(&self, turns: u64) -> S {
        self.per_half_turn * fraction(turns)
    }

    /// Turns in a knot at the start of a part.
    fn edge(&self, part: u32) -> u64 {
        let octaves = ((u128::from(self.width) * u128::from(part)) >> 24) as u64;
        let octave = self.lowest << (octaves >> 32).min(31);
        let beyond = (u128::from(octave) * u128::from(octaves & 0xffff_ffff)) >> 32;
        octave.saturating_add(beyond as u64).min(HIGHEST_TURNS)
    }

    /// Turns in a knot at a place within a part, in units of 2⁻³² of it, and its width.
    fn turns(&self, part: u32, place: u32) -> [u64; 2] {
        let from = self.edge(part);
        let width = self.edge(part + 1).saturating_sub(from);
        [from + ((u128::from(width) * u128::from(place)) >> 32) as u64, width]
    }
}

/// The generator SplitMix64 (Steele, Lea and Flood 2014).
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

/// `number/2⁶³` of a number below 2⁶³, to all digits; the conversion alone keeps 32 bits.
fn fraction<S: Scalar>(number: u64) -> S {
    let shift = number.leading_zeros().clamp(1, 63);
    S::from_fraction((number << (shift - 1)).cast_signed()) * S::power_of_two(1 - shift.cast_signed())
}

/// The spline's factor at a frequency of so many turns in a knot, `(sin πx / πx)⁴` for `x ≤ 1/8`.
fn spline_factor<S: Scalar>(turns: u64) -> S {
    // `1 − z/3! + z²/5! − …` with `z = (πx)²`.
    let angle = fraction::<S>(turns) * S::from_f64(core::f64::consts::FRAC_PI_2);
    let square = angle * angle;
    let factor =
        (1..=7_u32).rev().fold(S::ONE, |sum, n| S::ONE - square / S::from_u32(2 * n * (2 * n + 1)) * sum);
    factor * factor * (factor * factor)
}

impl<S: Scalar, const LINES: usize, M: Mathematics<S>> Random<S, LINES, M> {
    /// A random acceleration with a spectral density, of `lines` sines drawn from `seed`.
    ///
    /// # Errors
    /// No line, or more than `LINES`.
    pub fn new(density: &SpectralDensity<'_, S>, lines: u32, seed: u64) -> Result<Self, ExcitationError> {
        if lines == 0 || lines as usize > LINES {
            return Err(ExcitationError::Lines);
        }
        let [low, high] = density.band();
        let rate = high * S::power_of_two(KNOTS_LOG2.cast_signed());
        let grid = SampleGrid::new(rate)?;
        let band = Band::new([low, high], rate, lines)?;
        // The seed is mixed once, so that successive seeds draw from places far apart.
        let mut generator = SplitMix(SplitMix(seed).next());
        let mut drawn = Vec::new();
        for part in 0..lines {
            let [turns, width] = band.turns(part, (generator.next() >> 32) as u32);
            let frequency = band.hertz(turns).max(low).min(high);
            let twice = S::from_f64(2.0) * density.at(frequency) * band.hertz(width);
            let phase = generator.next().wrapping_sub(turns);
            let coefficient = twice.sqrt() / spline_factor(turns);
            drawn.push(Drawn { coefficient, turns, phase }).map_err(|_| ExcitationError::Lines)?;
        }
        let interval = grid.whole_ticks_per_sample().unwrap_or(u64::MAX);
        let random = Self {
            lines: drawn,
            grid,
            interval: u32::try_from(interval).unwrap_or(u32::MAX),
            angular_frequency: high * S::from_f64(core::f64::consts::TAU),
            band,
            knots: Cell::new(Knots { piece: 0, values: [S::ZERO; KEPT] }),
            mathematics: PhantomData,
        };
        random.knots.set(random.knots_from(0));
        Ok(random)
    }

    /// The sines of the sum.
    pub fn lines(&self) -> impl Iterator<Item = SpectralLine<S>> {
        self.lines.iter().map(|line| SpectralLine {
            amplitude: line.coefficient * spline_factor(line.turns),
            frequency: self.band.hertz(line.turns),
            phase: S::from_fraction((line.phase.wrapping_add(line.turns) >> 1).cast_signed())
                * S::from_f64(core::f64::consts::TAU),
        })
    }

    /// The mean distance of the lines in Hz near a frequency in Hz; a band has at most twice as many lines at one end of
    /// an octave as at the other, relative to the frequency.
    ///
    /// A resonance of damping ratio `ζ` at `f` has the half-power bandwidth `2 ζ f`.
    #[must_use]
    pub fn spacing(&self, frequency: S) -> S {
        let mut octave = self.band.hertz(self.band.lowest);
        for _ in 0..32 {
            let next = octave + octave;
            if next > frequency {
                break;
            }
            octave = next;
        }
        octave * self.band.octaves
    }

    /// The sum at the knot before that with an index, divided by the spline's factors.
    fn knot(&self, index: u64) -> S {
        self.lines.iter().fold(S::ZERO, |sum, line| {
            let phase = line.turns.wrapping_mul(index).wrapping_add(line.phase);
            sum + line.coefficient * M::sine_of_turns(phase)
        })
    }

    fn knots_from(&self, piece: u64) -> Knots<S> {
        let mut index = piece;
        let values = [S::ZERO; KEPT].map(|_| {
            let value = self.knot(index);
            index = index.wrapping_add(1);
            value
        });
        Knots { piece, values }
    }

    /// The four knots of a piece. Successive pieces cost one new knot each.
    #[inline]
    fn knots_of(&self, piece: u64) -> [S; 4] {
        let kept = self.knots.get();
        let Knots { piece: first, values: [a, b, c, d, e] } = kept;
        match piece.wrapping_sub(first) {
            0 => [a, b, c, d],
            1 => [b, c, d, e],
            2 => {
                let next = self.knot(piece.wrapping_add(3));
                self.knots.set(Knots { piece: first.wrapping_add(1), values: [b, c, d, e, next] });
                [c, d, e, next]
            }
            u64::MAX => {
                let before = self.knot(piece);
                self.knots.set(Knots { piece, values: [before, a, b, c, d] });
                [before, a, b, c]
            }
            _ => {
                let found = self.knots_from(piece);
                self.knots.set(found);
                let [a, b, c, d, _] = found.values;
                [a, b, c, d]
            }
        }
    }

    /// Coefficients of a piece in powers of the place in it, 0 to 1, in m/s².
    #[inline]
    fn piece(&self, piece: u64) -> [S; 4] {
        let [a, b, c, d] = self.knots_of(piece);
        let (half, sixth) = (S::from_f64(0.5), S::from_f64(1.0 / 6.0));
        let bow = a - (b + b) + c;
        [b + sixth * bow, half * (c - a), half * bow, sixth * (d - a + S::from_f64(3.0) * (b - c))]
    }

    /// The cubic over a step from `at`, in powers of the place in the step, 0 to 1, in m/s²; with the piece of `at`, the
    /// place in it, and the length of the step in knots.
    #[inline]
    fn cubic(&self, at: Instant, step: S) -> Cubic<S> {
        let (index, place) = self.grid.place(at);
        let piece = self.piece(index);
        let length = step * self.grid.samples_per_second;
        let [_, rate, bow, cube] = derivatives(piece, place);
        let square = length * length;
        Cubic {
            coefficients: [value(piece, place), length * rate, square * bow, square * length * cube],
            index,
            place,
            length,
            cube,
        }
    }
}

/// A piece of the spline over a step.
struct Cubic<S> {
    coefficients: [S; 4],
    /// Number of the piece.
    index: u64,
    /// Start of the step in the piece, 0 to 1.
    place: S,
    /// Length of the step in knots.
    length: S,
    /// Coefficient of the cube of the place in the piece.
    cube: S,
}

/// A cubic at `x`.
#[inline]
fn value<S: Scalar>([zeroth, first, second, third]: [S; 4], x: S) -> S {
    zeroth + x * (first + x * (second + x * third))
}

/// The coefficients of a cubic around `x`.
#[inline]
fn derivatives<S: Scalar>(cubic: [S; 4], x: S) -> [S; 4] {
    let [_, first, second, third] = cubic;
    let thrice = S::from_f64(3.0) * third;
    [value(cubic, x), first + x * (second + second + x * thrice), second + x * thrice, third]
}

impl<S: Scalar, const LINES: usize, M> PartialEq for Random<S, LINES, M> {
    /// Whether the sums are equal; the pieces in use do not matter.
    fn eq(&self, other: &Self) -> bool {
        self.lines == other.lines && self.grid == other.grid
    }
}

impl<S: Scalar, const LINES: usize, M: Mathematics<S>> Excitation<S> for Random<S, LINES, M> {
    fn acceleration(&self, at: Instant) -> S {
        let (index, place) = self.grid.place(at);
        value(self.piece(index), place)
    }

    fn jerk(&self, at: Instant) -> S {
        let (index, place) = self.grid.place(at);
        let [_, rate, ..] = derivatives(self.piece(index), place);
        rate * self.grid.samples_per_second
    }

    fn resolved_ticks(&self) -> u32 {
        self.interval
    }

    fn angular_frequency(&self) -> S {
        self.angular_frequency
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        self.grid.ticks_to_next(at)
    }

    fn response(&self, at: Instant, _ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        kernel.to_cubic(self.cubic(at, kernel.step).coefficients)
    }

    /// Exact for a step of at most an interval of the knots. Beyond a knot the next piece differs by a cube of the place
    /// after the knot alone.
    fn line(&self, at: Instant, ticks: u32, step: S, _start: S) -> Line<S> {
        let Cubic { coefficients, index, place, length, cube } = self.cubic(at, step);
        let [zeroth, first, second, third] = coefficients;
        let [half, quarter] = [0.5, 0.25].map(S::from_f64);
        let mean = zeroth + half * first + S::from_f64(1.0 / 3.0) * second + quarter * third;
        let tilt = half * (first + second) + S::from_f64(0.45) * third;
        let (last, end) = self.grid.place(at.after(ticks));
        if last == index {
            return Line { mean, tilt, end: value(coefficients, S::ONE) };
        }
        let next = self.piece(last);
        let [.., next_cube] = next;
        let beyond = (length - (S::ONE - place)).max(S::ZERO) / length;
        let square = beyond * beyond;
        let change = (next_cube - cube) * length * length * length * square * square;
        Line {
            mean: mean + quarter * change,
            tilt: tilt + S::from_f64(3.0) * change * (quarter - S::from_f64(0.1) * beyond),
            end: value(next, end),
        }
    }
}

#[cfg(test)]
mod tests;
