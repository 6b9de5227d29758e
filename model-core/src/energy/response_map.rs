//! The income under one sine, looked up in a map that the host computed with the full model.
//!
//! A node knows the amplitude and the frequency of its vibration, for example by
//! [`LineBank`](crate::excitation::LineBank). A [`ResponseMap`] gives the mean power into the load, or the charge per
//! second into a storage, of the steady motion at that place, with bounds that were measured against the full model at
//! random places off the map's nodes. `map` of the host writes such a map as constants for firmware.
//!
//! A harvester with a stop or with friction may have two steady motions at the same place: one that a rising amplitude
//! leaves at a boundary, and one that a falling amplitude leaves at another, lower one. The map has a branch for each, and
//! between the boundaries it gives both. Beyond its edges it answers [`Outside`] and does not extrapolate.
//!
//! Nodes lie evenly over the detuning, `arsinh` of the distance from the resonance in half-bandwidths, over which the
//! logarithm of the power of a linear resonance has a curvature of at most 2. In the amplitude they lie at fixed ratios to
//! the boundary of their branch, closer together near it, where the branch is steep. Values between are linear in both, of
//! the logarithm, rounded down to 2⁻¹¹ octaves.
//!
//! # Broadband vibration
//!
//! A linear harvester that gives `h(f) A²` under a sine of amplitude `A` gives under vibration of the one-sided spectral
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
//! the mass by `A/(2 ζ ω_n²)`; vibration moves it by `√(G/(8 ζ ω_n³))` RMS. With the half-bandwidth `b = ζ ω_n/2π` in Hz, three
//! times this is below the motion at the rising boundary `A*` up to `G = A*²/(9π b)`. Where the branch is within a tenth of the
//! square law up to a sine of amplitude `A_l`, by a term in `A⁴`, the mean over the amplitudes of noise is within a tenth up to
//! half of that sine's mean square, `G = A_l²/(4π b)`. Beyond either the answer is flagged.
//!
//! Both coordinates and the value are found in integers; only the factors of both bounds multiply the value as floating-point
//! numbers, on a core with a floating-point unit, and these products are exact. A look-up allocates nothing and cannot panic.

mod coordinate;
mod image;
mod plan;
#[cfg(test)]
pub(crate) mod test_map;
#[cfg(test)]
mod tests;
mod words;

pub use coordinate::{
    AMPLITUDE_OCTAVES, FARTHEST, LEVELS_PER_OCTAVE, Spacing, detuning, fixed, level, number, row,
    row_distance,
};
pub use image::{
    Agreement, BOUNDS, COLUMNS, CURRENT, DENSITY_OCTAVES, HEAD, LOWER, MAGIC, MapError, NEAR, NOWHERE, PARTS,
    POWER_OCTAVES, ROWS, Stored, TAIL, UPPER, VERSION, seal,
};
pub use words::{Bounds, Columns, Part, Word, WordSource};

use crate::scalar::Scalar;
use image::Head;
use plan::{Place, Plan, boundaries};

/// A map in flash, checked.
///
/// `W` is `&[u16]` for the constants of a Rust module, or `&[u8]` for the bytes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResponseMap<W: WordSource> {
    words: W,
    /// Of the first slice.
    columns: W::Columns,
    bounds: W::Bounds,
    plan: Plan,
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
        /// Its output power.
        income: Bounded,
    },
    /// Two steady motions, or a place too near to a boundary to decide which.
    Two {
        /// The output power of the motion that a rising amplitude has not left.
        lower: Bounded,
        /// The output power of the motion that a falling amplitude has not left.
        upper: Bounded,
    },
    /// The map does not cover this place.
    Outside(Outside),
}

impl Response {
    /// The output power to count on, with bounds that cover both motions where there may be two: the value is then the smaller
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

/// What broadband vibration gives.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Broadband {
    /// Mean power in W, or charge per second in A.
    pub value: f32,
    /// Whether the motion stays on the linear part of the lower branch. If not, the value is not to be relied upon.
    pub is_linear: bool,
}

impl<'a> ResponseMap<&'a [u16]> {
    /// As [`ResponseMap::new`], also at compile time: a `static` map, or a node with it, is checked then and lies in flash.
    ///
    /// # Errors
    /// [`MapError`].
    pub const fn of_words(words: &'a [u16], fingerprint: u32) -> Result<Self, MapError> {
        let (head, plan) = match checked(Stored::Words(words), fingerprint) {
            Ok(parts) => parts,
            Err(error) => return Err(error),
        };
        let parts = (words::columns(words, head.columns_from()), words::bounds(words, head.parts_from()));
        let (Some(columns), Some(bounds)) = parts else { return Err(MapError::NotAMap) };
        Ok(Self { words, columns, bounds, plan })
    }
}

impl<W: WordSource> ResponseMap<W> {
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
        let (head, plan) = checked(words.stored(), fingerprint)?;
        let parts = (words.columns(head.columns_from()), words.bounds(head.parts_from()));
        let (Some(columns), Some(bounds)) = parts else { return Err(MapError::NotAMap) };
        Ok(Self { words, columns, bounds, plan })
    }

    /// Whether the values are charge per second in A, for a storage at a stated voltage; otherwise power in W.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.plan.is_current
    }

    fn word(&self, index: usize) -> u16 {
        self.words.stored().word(index)
    }

    /// Fingerprint of the harvester.
    #[must_use]
    pub fn fingerprint(&self) -> u32 {
        u32::from(self.word(3)) | u32::from(self.word(4)) << 16
    }

    /// CRC-32 of the map.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        let end = usize::from(self.word(2));
        let word = |back: usize| u32::from(self.word(end.saturating_sub(back)));
        word(2) | word(1) << 16
    }

    /// Lowest and highest amplitude in m/s².
    #[must_use]
    pub fn amplitudes(&self) -> [f32; 2] {
        [18, 19].map(|index| number(i32::from(self.word(index)) - AMPLITUDE_OCTAVES * LEVELS_PER_OCTAVE))
    }

    /// Number of slices.
    #[must_use]
    pub fn slices(&self) -> usize {
        self.plan.slices.into()
    }

    /// Voltage of the storage of a slice in V; 0 of a map of power.
    #[must_use]
    pub fn voltage(&self, slice: usize) -> f32 {
        match u16::try_from(slice).map_or(0, |slice| self.voltage_level(slice)) {
            0 => 0.0,
            level => number(level - AMPLITUDE_OCTAVES * LEVELS_PER_OCTAVE),
        }
    }

    /// How well the map was found to agree with the full model.
    #[must_use]
    pub fn agreement(&self) -> Agreement {
        let part = |index| f32::from(self.word(index)) * 1e-4;
        Agreement {
            places: u32::from(self.word(22)),
            median: part(23),
            percentile_90: part(24),
            bounds_hold: part(25),
        }
    }

    /// The steady motion under a sine of `amplitude` in m/s² and `frequency` in Hz, by the first slice.
    #[must_use]
    #[inline]
    pub fn at(&self, amplitude: f32, frequency: f32) -> Response {
        match self.plan.place(amplitude.to_bits(), frequency.to_bits()) {
            Some((level, place)) => self.answer(&self.columns, &self.bounds, level, place),
            None => Response::Outside(self.plan.edge(amplitude, frequency)),
        }
    }

    /// As [`ResponseMap::at`] by another slice, at its own voltage; [`Outside::Voltage`] if there is no such slice.
    #[must_use]
    pub fn in_slice_at(&self, slice: usize, amplitude: f32, frequency: f32) -> Response {
        let Some(slice) = u16::try_from(slice).ok().filter(|&slice| slice < self.plan.slices) else {
            return Response::Outside(Outside::Voltage);
        };
        match self.plan.place(amplitude.to_bits(), frequency.to_bits()) {
            Some((level, place)) => self.in_slice(slice, level, place),
            None => Response::Outside(self.plan.edge(amplitude, frequency)),
        }
    }

    /// As [`ResponseMap::at`] at a voltage of the storage in V, between that of two slices.
    ///
    /// Where the two slices do not agree about the motion, both motions are given, with bounds of both slices.
    #[must_use]
    pub fn at_voltage(&self, amplitude: f32, frequency: f32, voltage: f32) -> Response {
        let place = self.plan.place(amplitude.to_bits(), frequency.to_bits());
        let (at, voltage) = match (place, level(voltage)) {
            (Some(at), Some(voltage)) => (at, voltage),
            (None, _) => return Response::Outside(self.plan.edge(amplitude, frequency)),
            (_, None) => return Response::Outside(Outside::NoNumber),
        };
        let above = (0..self.plan.slices).find(|&slice| self.voltage_level(slice) >= voltage);
        match above {
            Some(0) if self.voltage_level(0) == voltage => self.in_slice(0, at.0, at.1),
            Some(slice @ 1..) => {
                let [low, high] = [slice - 1, slice].map(|slice| self.voltage_level(slice));
                let nearer_high = voltage.abs_diff(low) >= high.abs_diff(voltage);
                between(self.in_slice(slice - 1, at.0, at.1), self.in_slice(slice, at.0, at.1), nearer_high)
            }
            _ => Response::Outside(Outside::Voltage),
        }
    }

    /// The output power under vibration of a one-sided spectral density in (m/s²)²/Hz near the resonance, as
    /// [`Lines::density`](crate::excitation::Lines::density), averaged over blocks; `None` for a map without a linear lower
    /// branch, and for a density that is negative or from 2⁶⁴ on.
    #[must_use]
    pub fn broadband(&self, density: f32) -> Option<Broadband> {
        let [factor, largest] = [26, 27].map(|index| i32::from(self.word(index)));
        let level = level_of_density(density)?;
        if factor == 0 {
            return None;
        }
        let power = level.wrapping_add(factor).wrapping_sub(POWER_OCTAVES * LEVELS_PER_OCTAVE);
        let value = if density > 0.0 { number(power) } else { 0.0 };
        let is_linear = level.wrapping_add(DENSITY_OCTAVES * LEVELS_PER_OCTAVE) <= largest;
        Some(Broadband { value, is_linear })
    }

    fn voltage_level(&self, slice: u16) -> i32 {
        i32::from(self.word(HEAD + usize::from(slice)))
    }

    /// Resonance of the harvester in Hz.
    pub(crate) fn resonance(&self) -> f32 {
        // A unit of 2^−shift Hz.
        f32::from_i32(self.plan.resonance) * f32::from_bits(self.plan.right.wrapping_sub(31) << 23)
    }

    /// Whether the map reaches over a frequency in Hz.
    pub(crate) const fn has_frequency(&self, frequency: f32) -> bool {
        self.plan.has_frequency(frequency.to_bits())
    }

    /// The answer of a slice; `Outside` if there is none of this number.
    fn in_slice(&self, slice: u16, level: i32, place: Place) -> Response {
        let [columns, bounds] = self.plan.slice(slice);
        match (self.words.columns(columns), self.words.bounds(bounds)) {
            (Some(columns), Some(bounds)) => self.answer(&columns, &bounds, level, place),
            _ => Response::Outside(Outside::Voltage),
        }
    }

    /// The answer by the columns and bounds of a slice.
    #[inline(always)]
    fn answer(
        &self,
        columns: &Columns<W::Word>,
        bounds: &Bounds<W::Word>,
        level: i32,
        place: Place,
    ) -> Response {
        let left = place.column();
        let (Some([left, right]), Some([lower, upper])) =
            (columns.get(left..left + 2), bounds.get(place.part()))
        else {
            // A checked map has them.
            return Response::Outside(Outside::NoNumber);
        };
        let columns = [left, right];
        let plan = &self.plan;
        let [rising, falling] = boundaries(columns, place);
        let [below, above] = [rising.wrapping_sub(level), level.wrapping_sub(falling)];
        let (branch, income) = if above.wrapping_add(plan.margin) < 0 {
            (Branch::Lower, plan.income(&plan.lower, columns, lower, below, place))
        } else if below.wrapping_add(plan.margin) < 0 {
            (Branch::Upper, plan.income(&plan.upper, columns, upper, above, place))
        } else {
            let [lower, upper] = plan.both(columns, [lower, upper], [below, above], place);
            return Response::Two { lower, upper };
        };
        let income = match income {
            Some(income) => income,
            None => nothing(),
        };
        Response::One { branch, income }
    }
}

/// The numbers of a map that is whole and of this harvester.
const fn checked(words: Stored<'_>, fingerprint: u32) -> Result<(Head, Plan), MapError> {
    match Head::read(words, fingerprint) {
        Ok(head) => match Plan::new(&head) {
            Some(plan) => Ok((head, plan)),
            // Word 12 is where the columns begin.
            None => Err(MapError::Malformed { word: 12 }),
        },
        Err(error) => Err(error),
    }
}

/// The output power of a branch without values. A call keeps it out of the usual way, where the numbers are in registers.
#[cold]
#[inline(never)]
fn nothing() -> Bounded {
    Bounded::default()
}

/// The level of a density, not shifted; −80 octaves at 2⁻⁸⁰ and less. `None` for a negative one and from 2⁶⁴ on.
fn level_of_density(density: f32) -> Option<i32> {
    /// Octaves by which the exponent is raised: densities are small, and levels begin at 2⁻¹⁶.
    const RAISED: i32 = 64;
    let raised = density.to_bits().checked_add(RAISED.cast_unsigned() << 23)?;
    Some(level(f32::from_bits(raised))?.wrapping_sub((AMPLITUDE_OCTAVES + RAISED) * LEVELS_PER_OCTAVE))
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
