//! The income under one sine, looked up in a map that the host computed with the full model.
//!
//! A node knows the amplitude and the frequency of its shaking, for example by
//! [`ToneMeter`](crate::excitation::ToneMeter). A [`ResponseMap`] gives the mean power into the load, or the charge per
//! second into a storage, of the steady motion at that place, with bounds that were measured against the full model at
//! random places off the map's nodes. `map` of the host writes such a map as constants for firmware.
//!
//! A harvester with a stop or with friction may have two steady motions at the same place: one that a rising amplitude
//! leaves at a boundary, and one that a falling amplitude leaves at another, lower one. The map has a branch for each, and
//! between the boundaries it tells both. Beyond its edges it answers [`Outside`] and does not extrapolate.
//!
//! Nodes lie evenly over the detuning, `arsinh` of the distance from the resonance in half-bandwidths, over which the
//! logarithm of the power of a linear resonance has a curvature of at most 2. In the amplitude they lie at fixed ratios to
//! the boundary of their branch, closer together near it, where the branch is steep. Values between are linear in both, of
//! the logarithm.
//!
//! # Broadband shaking
//!
//! A linear harvester that yields `h(f) A²` under a sine of amplitude `A` yields under shaking of the one-sided spectral
//! density `G(f)`, in (m/s²)²/Hz, the sum over its sines, of which those in `df` have the mean square `A²/2 = G df`:
//!
//! ```text
//! P = 2 ∫ G(f) h(f) df ≈ 2 G(f_n) ∫ h(f) df,
//! ```
//!
//! if `G` hardly changes over several bandwidths. For a mass `m` with a resistor that damps it by `ζ_e` of `ζ` in all,
//! `h(f) = m ζ_e ω_n |H|²` with the velocity's response `|H|² = ω²/((ω_n² − ω²)² + (2 ζ ω_n ω)²)`, whose integral over `f` is
//! `1/(8 ζ ω_n)`, so that `P = m G ζ_e/(4 ζ)`, whatever the resonance. The map has the integral over its own lower branch, with
//! Lorentz's tails beyond its edges ([`ResponseMap::broadband`]).
//!
//! That holds while the motion stays on the linear part of the lower branch. A sine of amplitude `A` at the resonance moves
//! the mass by `A/(2 ζ ω_n²)`; shaking moves it by `√(G/(8 ζ ω_n³))` RMS. With the half-bandwidth `b = ζ ω_n/2π` in Hz, three
//! times this is below the motion at the rising boundary `A*` up to `G = A*²/(9π b)`, and its mean square is that of a sine up
//! to which the branch is within a tenth of the square law, `A_l`, up to `G = A_l²/(2π b)`. Beyond either the answer is
//! flagged.
//!
//! All arithmetic is in integers: a look-up takes no floating-point operation, allocates nothing and cannot panic.

mod coordinate;
mod image;
#[cfg(test)]
mod tests;

pub use coordinate::{
    AMPLITUDE_OCTAVES, DETUNING_UNIT, FARTHEST, LEVELS_PER_OCTAVE, Spacing, detuning, fixed, level, number,
    row, row_distance,
};
pub use image::{
    BOUNDS, CURRENT, DENSITY_OCTAVES, HEAD, LOWER, MAGIC, MapError, NEAR, POWER_OCTAVES, TAIL, UPPER,
    VERSION, Words, seal,
};

use image::Head;

/// A map in flash, checked.
///
/// `W` is `&[u16]` for the constants of a Rust module, or `&[u8]` for the bytes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResponseMap<W> {
    words: W,
    head: Head,
}

/// A value with its bounds, in W, or in A where [`ResponseMap::is_current`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounded {
    /// The value by the map.
    pub value: f32,
    /// The value of the full model is expected at or above this one.
    pub low: f32,
    /// The value of the full model is expected at or below this one.
    pub high: f32,
}

/// A steady motion of a harvester.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Branch {
    /// The motion of small amplitudes: without impacts or contact, or stuck by friction.
    Lower,
    /// The motion of large amplitudes: with impacts or contact, or sliding.
    Upper,
}

/// The edge that a place is beyond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outside {
    /// The amplitude is below the map.
    AmplitudeBelow,
    /// The amplitude is above the map.
    AmplitudeAbove,
    /// The frequency is below the map.
    FrequencyBelow,
    /// The frequency is above the map.
    FrequencyAbove,
    /// The voltage is not between those of the slices.
    Voltage,
    /// A number is negative, or it is not finite.
    NoNumber,
}

/// The answer of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Response {
    /// One steady motion.
    One {
        /// Which.
        branch: Branch,
        /// Its yield.
        income: Bounded,
    },
    /// Two steady motions, or a place too near to a boundary to tell which.
    Two {
        /// The yield of the motion that a rising amplitude has not left.
        lower: Bounded,
        /// The yield of the motion that a falling amplitude has not left.
        upper: Bounded,
    },
    /// The map does not cover this place.
    Outside(Outside),
}

impl Response {
    /// The yield to count on, with bounds that cover both motions where there may be two: the value is then the smaller
    /// one. `None` outside the map.
    #[must_use]
    #[inline]
    pub fn income(&self) -> Option<Bounded> {
        match *self {
            Self::One { income, .. } => Some(income),
            Self::Two { lower, upper } => Some(Bounded {
                value: if lower.value < upper.value { lower.value } else { upper.value },
                low: if lower.low < upper.low { lower.low } else { upper.low },
                high: if lower.high > upper.high { lower.high } else { upper.high },
            }),
            Self::Outside(_) => None,
        }
    }
}

/// What broadband shaking yields.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Broadband {
    /// Mean power in W, or charge per second in A.
    pub value: f32,
    /// Whether the motion stays on the linear part of the lower branch. If not, the value is not to be relied upon.
    pub is_linear: bool,
}

/// How well a map was found to agree with the full model, at random places off its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Agreement {
    /// Number of places by which the bounds were measured.
    pub places: u32,
    /// Median of the relative error.
    pub median: f32,
    /// 90th percentile of the relative error.
    pub percentile_90: f32,
    /// Share of other places at which the bounds hold.
    pub bounds_hold: f32,
}

/// Between two columns: the column below, and the place above it in 2⁻¹⁰ of their distance.
#[derive(Clone, Copy)]
struct Column {
    below: usize,
    place: i32,
}

impl<W: Words> ResponseMap<W> {
    /// Checks a map: its checksum, its layout, and that it is of the harvester with this fingerprint.
    ///
    /// `map` of the host writes the fingerprint beside the map. It is that of the scene in `f32`, which firmware with the
    /// scene finds by [`Scene::identify`](crate::scene::Scene::identify) into a new
    /// [`Fingerprint`](crate::snapshot::Fingerprint)
    /// ([`BumpStop::identify_first`](crate::scene::bump_stop::BumpStop::identify_first) of a beam), followed behind a bridge by
    /// the number of its diode drop.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn new(words: W, fingerprint: u32) -> Result<Self, MapError> {
        Ok(Self { words, head: Head::read(words, fingerprint)? })
    }

    /// Whether the values are charge per second in A, for a storage at a stated voltage; otherwise power in W.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.head.is_current
    }

    /// Fingerprint of the harvester.
    #[must_use]
    pub fn fingerprint(&self) -> u32 {
        u32::from(self.words.word(3)) | u32::from(self.words.word(4)) << 16
    }

    /// CRC-32 of the map.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        let end = self.words.count();
        let word = |back: usize| u32::from(self.words.word(end.saturating_sub(back)));
        word(2) | word(1) << 16
    }

    /// Lowest and highest amplitude in m/s².
    #[must_use]
    pub fn amplitudes(&self) -> [f32; 2] {
        [self.head.lowest, self.head.highest]
            .map(|level| number(level - AMPLITUDE_OCTAVES * LEVELS_PER_OCTAVE))
    }

    /// Number of slices.
    #[must_use]
    pub fn slices(&self) -> usize {
        self.head.slices
    }

    /// Voltage of the storage of a slice in V; 0 of a map of power.
    #[must_use]
    pub fn voltage(&self, slice: usize) -> f32 {
        match self.voltage_level(slice) {
            0 => 0.0,
            level => number(level - AMPLITUDE_OCTAVES * LEVELS_PER_OCTAVE),
        }
    }

    /// How well the map was found to agree with the full model.
    #[must_use]
    pub fn agreement(&self) -> Agreement {
        let part = |index| f32::from(self.words.word(index)) * 1e-4;
        Agreement {
            places: u32::from(self.words.word(22)),
            median: part(23),
            percentile_90: part(24),
            bounds_hold: part(25),
        }
    }

    /// The steady motion under a sine of `amplitude` in m/s² and `frequency` in Hz, by the first slice.
    #[must_use]
    #[inline]
    pub fn at(&self, amplitude: f32, frequency: f32) -> Response {
        match self.place(amplitude, frequency) {
            Ok((level, column)) => self.in_slice(0, level, column),
            Err(outside) => Response::Outside(outside),
        }
    }

    /// As [`ResponseMap::at`] by another slice, at its own voltage; [`Outside::Voltage`] if there is no such slice.
    #[must_use]
    pub fn in_slice_at(&self, slice: usize, amplitude: f32, frequency: f32) -> Response {
        if slice >= self.head.slices {
            return Response::Outside(Outside::Voltage);
        }
        match self.place(amplitude, frequency) {
            Ok((level, column)) => self.in_slice(slice, level, column),
            Err(outside) => Response::Outside(outside),
        }
    }

    /// As [`ResponseMap::at`] at a voltage of the storage in V, between that of two slices.
    ///
    /// Where the two slices do not agree about the motion, both motions are told, with bounds of both slices.
    #[must_use]
    pub fn at_voltage(&self, amplitude: f32, frequency: f32, voltage: f32) -> Response {
        let (at, voltage) = match (self.place(amplitude, frequency), level(voltage)) {
            (Ok(at), Some(voltage)) => (at, voltage),
            (Err(outside), _) => return Response::Outside(outside),
            (_, None) => return Response::Outside(Outside::NoNumber),
        };
        let above = (0..self.head.slices).find(|&slice| self.voltage_level(slice) >= voltage);
        match above {
            Some(0) if self.voltage_level(0) == voltage => self.in_slice(0, at.0, at.1),
            Some(slice @ 1..) => {
                let [low, high] = [slice - 1, slice].map(|slice| self.voltage_level(slice));
                let nearer_high = 2 * (voltage - low) >= high - low;
                between(self.in_slice(slice - 1, at.0, at.1), self.in_slice(slice, at.0, at.1), nearer_high)
            }
            _ => Response::Outside(Outside::Voltage),
        }
    }

    /// The yield under shaking of a one-sided spectral density in (m/s²)²/Hz near the resonance, as
    /// [`Lines::density`](crate::excitation::Lines::density), averaged over blocks; `None` for a map without a linear lower
    /// branch, and for a density that is negative or from 2⁶⁴ on.
    #[must_use]
    pub fn broadband(&self, density: f32) -> Option<Broadband> {
        let [factor, largest] = [26, 27].map(|index| i32::from(self.words.word(index)));
        let level = level_of_density(density)?;
        if factor == 0 {
            return None;
        }
        let value =
            if density > 0.0 { number(level + factor - POWER_OCTAVES * LEVELS_PER_OCTAVE) } else { 0.0 };
        let is_linear = level + DENSITY_OCTAVES * LEVELS_PER_OCTAVE <= largest;
        Some(Broadband { value, is_linear })
    }

    fn voltage_level(&self, slice: usize) -> i32 {
        i32::from(self.words.word(HEAD + slice))
    }

    /// Whether the map reaches over a frequency in Hz.
    pub(crate) fn has_frequency(&self, frequency: f32) -> bool {
        use Outside::{FrequencyAbove, FrequencyBelow, NoNumber};
        !matches!(self.place(1.0, frequency), Err(FrequencyBelow | FrequencyAbove | NoNumber))
    }

    /// Level of the amplitude, and the columns beside the frequency.
    #[inline]
    fn place(&self, amplitude: f32, frequency: f32) -> Result<(i32, Column), Outside> {
        let head = &self.head;
        let (Some(level), Some(frequency)) = (level(amplitude), fixed(frequency, head.frequency_shift))
        else {
            return Err(Outside::NoNumber);
        };
        let distance = frequency.cast_signed() - head.resonance;
        let beyond = if distance < 0 { Outside::FrequencyBelow } else { Outside::FrequencyAbove };
        if distance.unsigned_abs() > FARTHEST {
            return Err(beyond);
        }
        let from_first = detuning(distance, head.slope) - head.first;
        if from_first < 0 {
            return Err(Outside::FrequencyBelow);
        }
        let from_first = from_first.cast_unsigned();
        if from_first > head.span {
            return Err(Outside::FrequencyAbove);
        }
        if level < head.lowest {
            return Err(Outside::AmplitudeBelow);
        }
        if level > head.highest {
            return Err(Outside::AmplitudeAbove);
        }
        let columns = (from_first * head.factor) >> head.factor_shift;
        // The last column is the end of the cell before it.
        let below = (columns >> 10).min((1 << head.column_bits) - 1);
        let place = (columns - (below << 10)).cast_signed();
        Ok((level, Column { below: below as usize, place }))
    }

    /// The answer of one slice.
    #[inline]
    fn in_slice(&self, slice: usize, level: i32, column: Column) -> Response {
        let head = &self.head;
        let start = HEAD + head.slices + slice * head.slice();
        let rising = self.curve(start, column);
        if !head.has_boundary() {
            let income = self.branch(start + head.columns(), 0, rising - level, column);
            return Response::One { branch: Branch::Lower, income };
        }
        let falling = self.curve(start + head.columns(), column);
        let lower_at = start + 2 * head.columns();
        let upper_at = if head.lower { lower_at + head.nodes() + BOUNDS } else { lower_at };
        let lower =
            || if head.lower { self.branch(lower_at, 0, rising - level, column) } else { Bounded::default() };
        let upper = || self.branch(upper_at, 1, level - falling, column);
        if level > rising + head.margin {
            Response::One { branch: Branch::Upper, income: upper() }
        } else if level < falling - head.margin {
            Response::One { branch: Branch::Lower, income: lower() }
        } else {
            Response::Two { lower: lower(), upper: upper() }
        }
    }

    /// The level of a boundary between two columns.
    #[inline]
    fn curve(&self, start: usize, Column { below, place }: Column) -> i32 {
        let [left, right] = self.words.pair(start + below);
        left + (((right - left) * place) >> 10)
    }

    /// The value of a branch at a distance in levels from its boundary, with its bounds.
    #[inline]
    fn branch(&self, start: usize, which: usize, distance: i32, Column { below, place }: Column) -> Bounded {
        let head = &self.head;
        let [lower, upper] = head.spacings;
        let spacing = if which == 0 { lower } else { upper };
        let (row, above) = row(distance.max(0).cast_unsigned(), spacing);
        let last = head.rows - 2;
        // The rows reach over the whole map.
        let (row, above) = if row > last { (last, 1 << 10) } else { (row, above.cast_signed()) };
        let rows = head.rows as usize;
        let node = start + below * rows + row as usize;
        let across = |[left, right]: [i32; 2], part: i32| left + (((right - left) * part + 512) >> 10);
        let left = across(self.words.pair(node), above);
        let right = across(self.words.pair(node + rows), above);
        let level = across([left, right], place) + head.value_octaves * LEVELS_PER_OCTAVE;
        let part =
            (below >> (head.column_bits - 3)) + if row < NEAR << (spacing.bits - 1) { 0 } else { BOUNDS / 2 };
        let bounds = i32::from(self.words.word(start + head.nodes() + part));
        // From 1/128 octaves to levels.
        let (lower, higher) = ((bounds & 0xff) << 4, (bounds >> 8) << 4);
        // The largest byte is no bound: the model may yield nothing.
        let low = if bounds & 0xff == 0xff { 0.0 } else { number(level - lower) };
        Bounded { value: number(level), low, high: number(level + higher) }
    }
}

/// The level of a density, not shifted; −80 octaves at 2⁻⁸⁰ and less. `None` for a negative one and from 2⁶⁴ on.
fn level_of_density(density: f32) -> Option<i32> {
    /// Octaves by which the exponent is raised: densities are small, and levels begin at 2⁻¹⁶.
    const RAISED: i32 = 64;
    let raised = density.to_bits().checked_add(RAISED.cast_unsigned() << 23)?;
    level(f32::from_bits(raised)).map(|level| level - (AMPLITUDE_OCTAVES + RAISED) * LEVELS_PER_OCTAVE)
}

/// The answer between two slices: the value of the nearer one, and the bounds of both.
fn between(low: Response, high: Response, nearer_high: bool) -> Response {
    let join = |one: Bounded, other: Bounded| Bounded {
        value: if nearer_high { other.value } else { one.value },
        low: if one.low < other.low { one.low } else { other.low },
        high: if one.high > other.high { one.high } else { other.high },
    };
    match (low, high) {
        (Response::One { branch: one, income: low }, Response::One { branch: other, income: high }) => {
            match (one, other) {
                (Branch::Lower, Branch::Upper) => Response::Two { lower: low, upper: high },
                (Branch::Upper, Branch::Lower) => Response::Two { lower: high, upper: low },
                _ => Response::One { branch: one, income: join(low, high) },
            }
        }
        (Response::Two { lower, upper }, Response::One { branch, income }) => match branch {
            Branch::Lower => Response::Two { lower: join(lower, income), upper },
            Branch::Upper => Response::Two { lower, upper: join(upper, income) },
        },
        (Response::One { branch, income }, Response::Two { lower, upper }) => match branch {
            Branch::Lower => Response::Two { lower: join(income, lower), upper },
            Branch::Upper => Response::Two { lower, upper: join(income, upper) },
        },
        (Response::Two { lower: a, upper: b }, Response::Two { lower: c, upper: d }) => {
            Response::Two { lower: join(a, c), upper: join(b, d) }
        }
        (Response::Outside(outside), _) | (_, Response::Outside(outside)) => Response::Outside(outside),
    }
}
