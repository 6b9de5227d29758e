//! Band-limited random acceleration with a given spectral density, reproducible from a seed.

use core::cell::Cell;
use core::marker::PhantomData;

use heapless::Vec;

use super::integers::divide;
use super::sample_grid::SampleGrid;
use super::{Excitation, ExcitationError, Line, SpectralDensity};
use crate::clock::{Frequency, Instant};
use crate::oscillator::{Kernel, Response};
use crate::scalar::{Mathematics, Polynomial, Scalar, horner};

/// Knots of the spline in a period of the highest frequency, as a power of two.
const KNOTS_LOG2: u32 = 3;
/// Turns in a knot of the highest frequency, in units of 2⁻⁶⁴.
const HIGHEST_TURNS: u64 = 1 << (64 - KNOTS_LOG2);
/// Knots of a piece, half of them on each side of its middle.
const KNOTS: usize = 8;
/// The coefficients over [`SCALE`] of the powers of the place in a piece, −1 to 1, by pairs of knots from the middle out:
/// of the sums of the pairs for even powers, of first less second for odd ones.
const WEIGHTS: [[i32; KNOTS / 2]; KNOTS] = [
    [259_723, 60_657, 2_179, 1],
    [-91_035, -68_747, -5_047, -7],
    [-30_345, 25_389, 4_935, 21],
    [13_545, -175, -2_555, -35],
    [1_505, -2_205, 665, 35],
    [-945, 399, -21, -21],
    [-35, 63, -35, 7],
    [35, -21, 7, -1],
];
/// `2⁷ 7!`.
const SCALE: f64 = 645_120.0;
/// Gauss's nodes of the inner and the outer pair in a step, in halves of the step from its middle.
const INNER: f64 = 0.339_981_043_584_856_3;
const OUTER: f64 = 0.861_136_311_594_052_6;
/// Weights of these nodes in the mean.
const NODE_WEIGHTS: [f64; 2] = [0.326_072_577_431_273_1, 0.173_927_422_568_726_9];

/// Random acceleration with a one-sided spectral density, from a seed: a sum of sines, joined by a spline.
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
/// The sum is computed at knots, eight in a period of the highest frequency, and joined by a spline of degree 7 whose filter
/// is compensated in the amplitudes. What the spline adds to a line at the highest frequency is below 2·10⁻⁷ of its
/// amplitude, and above seven times its frequency. A step costs the same with any number of lines; the response to it is
/// that to the cubic through Gauss's nodes of the step, which adds less than 10⁻⁸. A new piece costs a sine for each line.
///
/// Frequencies and phases are integers: both precisions draw the same ones, if the ends of the band are numbers of both.
/// The pieces in use are in cells, so the type is not `Sync`; the acceleration does not depend on them.
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
    knots: Cell<Piece<S>>,
    /// The pieces of an even and of an odd number in use, as coefficients of the powers of the place, −1 to 1, in m/s².
    pieces: [Cell<Piece<S>>; 2],
    mathematics: PhantomData<M>,
}

/// A sine of the sum.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drawn<S> {
    /// Amplitude in m/s², over the spline's factor at the frequency.
    coefficient: S,
    /// Turns from one knot to the next, in units of 2⁻⁶⁴.
    turns: u64,
    /// Phase three knots before time zero, in units of 2⁻⁶⁴ turns.
    phase: u64,
}

/// Eight numbers of a piece of the spline.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece<S> {
    index: u64,
    values: [S; KNOTS],
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
        let whole = lowest.leading_zeros().saturating_sub(HIGHEST_TURNS.leading_zeros());
        let is_above = lowest.wrapping_shl(whole) > HIGHEST_TURNS;
        let whole = whole.saturating_sub(u32::from(is_above));
        let octave = lowest.wrapping_shl(whole);
        let rest = divide(u128::from(HIGHEST_TURNS.wrapping_sub(octave)), 32, u128::from(octave)) as u64;
        let length = (u64::from(whole) << 32).wrapping_add(rest);
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

/// The spline's factor at a frequency of so many turns in a knot, `(sin πx / πx)⁸` for `x ≤ 1/8`.
fn spline_factor<S: Scalar>(turns: u64) -> S {
    // `1 − z/3! + z²/5! − …` with `z = (πx)²`.
    let angle = fraction::<S>(turns) * S::from_f64(core::f64::consts::FRAC_PI_2);
    let square = angle * angle;
    let term = |sum, n: u32| S::ONE - square / S::from_u32((n << 1).wrapping_mul(n << 1 | 1)) * sum;
    let factor = (1..=7_u32).rev().fold(S::ONE, term);
    let square = factor * factor;
    square * square * (square * square)
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
            let phase = generator.next().wrapping_sub(3 * turns);
            let coefficient = twice.sqrt() / spline_factor(turns);
            drawn.push(Drawn { coefficient, turns, phase }).map_err(|_| ExcitationError::Lines)?;
        }
        let interval = grid.whole_ticks_per_sample().unwrap_or(u64::MAX);
        // The clock reaches neither this piece nor the next.
        let nothing = || Cell::new(Piece { index: u64::MAX - 1, values: [S::ZERO; KNOTS] });
        Ok(Self {
            lines: drawn,
            grid,
            interval: u32::try_from(interval).unwrap_or(u32::MAX),
            angular_frequency: high * S::from_f64(core::f64::consts::TAU),
            band,
            knots: nothing(),
            pieces: [nothing(), nothing()],
            mathematics: PhantomData,
        })
    }

    /// The sines of the sum.
    pub fn lines(&self) -> impl Iterator<Item = SpectralLine<S>> {
        self.lines.iter().map(|line| SpectralLine {
            amplitude: line.coefficient * spline_factor(line.turns),
            frequency: self.band.hertz(line.turns),
            phase: S::from_fraction((line.phase.wrapping_add(3 * line.turns) >> 1).cast_signed())
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

    /// The sum three knots before that with an index, divided by the spline's factors.
    fn knot(&self, index: u64) -> S {
        self.lines.iter().fold(S::ZERO, |sum, line| {
            let phase = line.turns.wrapping_mul(index).wrapping_add(line.phase);
            sum + line.coefficient * M::sine_of_turns(phase)
        })
    }

    /// The knots of a piece; one is new if the last piece was the one before.
    fn knots_of(&self, index: u64) -> [S; KNOTS] {
        let Piece { index: last, values: [_, a, b, c, d, e, f, g] } = self.knots.get();
        let known = if last.wrapping_add(1) == index { KNOTS as u64 - 1 } else { 0 };
        let mut values = [a, b, c, d, e, f, g, S::ZERO];
        for (number, value) in (0..KNOTS as u64).zip(&mut values) {
            if number >= known {
                *value = self.knot(index.wrapping_add(number));
            }
        }
        self.knots.set(Piece { index, values });
        values
    }

    #[inline(never)]
    fn new_piece(&self, index: u64) -> Piece<S> {
        let [h, f, d, b, a, c, e, g] = self.knots_of(index);
        let mut pairs = [b + a, d + c, f + e, h + g];
        let mut others = [b - a, d - c, f - e, h - g];
        let mut values = [S::ZERO; KNOTS];
        for (value, weights) in values.iter_mut().zip(&WEIGHTS) {
            for (pair, weight) in pairs.iter().zip(weights) {
                *value += S::from_i32(*weight) * *pair;
            }
            *value = S::from_f64(1.0 / SCALE) * *value;
            (pairs, others) = (others, pairs);
        }
        Piece { index, values }
    }

    /// The coefficients of a piece.
    #[inline]
    fn piece(&self, index: u64) -> [S; KNOTS] {
        let [even, odd] = &self.pieces;
        let cell = if index & 1 == 0 { even } else { odd };
        if cell.get().index != index {
            cell.set(self.new_piece(index));
        }
        cell.get().values
    }

    /// The acceleration at a place from the start of a piece in pieces, 0 to 2.
    fn value(&self, index: u64, place: S) -> S {
        let (index, place) =
            if place < S::ONE { (index, place) } else { (index.wrapping_add(1), place - S::ONE) };
        horner(&self.piece(index), place + place - S::ONE)
    }

    /// The accelerations at the nodes of a step of at most an interval of the knots: for both pairs the sum, and the later
    /// less the earlier.
    #[inline]
    fn pairs(&self, at: Instant, step: S) -> [[S; 2]; 2] {
        let (index, place) = self.grid.place(at);
        let half = S::from_f64(0.5) * step * self.grid.samples_per_second;
        let pair = |node: S| {
            let (middle, offset) = (place + half, half * node);
            let before = self.value(index, middle - offset);
            let after = self.value(index, middle + offset);
            [before + after, after - before]
        };
        [pair(S::from_f64(INNER)), pair(S::from_f64(OUTER))]
    }
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
        self.value(index, place)
    }

    fn jerk(&self, at: Instant) -> S {
        let (index, place) = self.grid.place(at);
        let piece = self.piece(index);
        let place = place + place - S::ONE;
        let (slope, _) = piece.iter().rev().fold((S::ZERO, S::ZERO), |(slope, value), &coefficient| {
            (slope * place + value, value * place + coefficient)
        });
        S::from_f64(2.0) * slope * self.grid.samples_per_second
    }

    fn resolved_ticks(&self) -> u32 {
        self.interval
    }

    fn angular_frequency(&self) -> S {
        self.angular_frequency
    }

    /// To the cubic through the accelerations at Gauss's nodes.
    fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<S>) -> Response<S> {
        const DISTANCE: f64 = OUTER * OUTER - INNER * INNER;
        let [[inner, inner_rise], [outer, outer_rise]] = self.pairs(at, kernel.step);
        // Powers of the place from −1 to 1.
        let [half, square] = [0.5, INNER * INNER].map(S::from_f64);
        let slope = S::from_f64(0.5 / INNER) * inner_rise;
        let second = S::from_f64(0.5 / DISTANCE) * (outer - inner);
        let third = S::from_f64(1.0 / DISTANCE) * (S::from_f64(0.5 / OUTER) * outer_rise - slope);
        let (zeroth, first) = (half * inner - square * second, slope - square * third);
        let [twice, thrice, fourfold] = [2.0, 3.0, 4.0].map(S::from_f64);
        let response = kernel.to_cubic([
            zeroth - first + second - third,
            twice * (first - twice * second + thrice * third),
            fourfold * (second - thrice * third),
            fourfold * (third + third),
        ]);
        let [start, end] = [at, at.after(ticks)].map(|at| self.acceleration(at));
        Response { start, end, ..response }
    }

    fn line(&self, at: Instant, ticks: u32, step: S, _start: S) -> Line<S> {
        let [[inner, inner_rise], [outer, outer_rise]] = self.pairs(at, step);
        let [by_inner, by_outer] = NODE_WEIGHTS.map(S::from_f64);
        let mean = by_inner * inner + by_outer * outer;
        let [inner_lever, outer_lever] = [3.0 * INNER, 3.0 * OUTER].map(S::from_f64);
        let tilt = by_inner * (inner_lever * inner_rise) + by_outer * (outer_lever * outer_rise);
        Line { mean, tilt, end: self.acceleration(at.after(ticks)) }
    }
}

#[cfg(test)]
mod tests;
