//! The words of a map, and the bounds of its slices.

use model_core::energy::ResponseMap;
use model_core::energy::response_map::{
    BOUNDS, COLUMNS, CURRENT, DENSITY_OCTAVES, HEAD, LEVELS_PER_OCTAVE, LOWER, MAGIC, NEAR, NOWHERE, PARTS,
    POWER_OCTAVES, ROWS, Spacing, TAIL, UPPER, VERSION, level, row, row_distance, seal,
};

use super::agreement::{ALLOWANCE, Agreement, Judged, OperatingPoint, predicted_of};
use super::axes::{Axes, amplitude_of};
use super::column::{Column, along, fitted};
use crate::method::Failure;

/// The largest amplitude in m/s² up to which the lower branch of a column is within a tenth of the square law.
fn straight(column: &Column, over_square: f64) -> f64 {
    let bends = |&&(level, value): &&(f64, f64)| {
        (value / (over_square * amplitude_of(level).powi(2)) - 1.0).abs() > 0.1
    };
    let end = column.lower.iter().find(bends).map_or(column.rising, |&(level, _)| level);
    amplitude_of(end)
}

/// The least bound in octaves: the roundings of levels and values.
const LEAST: f64 = 1.0 / 128.0;
/// Largest deviation in octaves of the lower branch from the square of the amplitude, over an octave.
const LINEAR: f64 = 0.1;

/// What broadband vibration gives on the lower branch.
pub(super) struct Broadband {
    /// Mean power in W, or charge per second in A, over the density in (m/s²)²/Hz.
    pub(super) factor: f64,
    /// Largest density in (m/s²)²/Hz.
    pub(super) largest: f64,
}

/// The words of a map, and the fingerprint of its scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    pub words: Vec<u16>,
    pub fingerprint: u32,
}

/// Parts of a branch that have bounds of their own: those of the columns near the boundary, then the others. Each has the
/// parts by which the true value may be lower and higher, in octaves.
pub(super) type Bounds = [[f64; 2]; BOUNDS];

/// What is measured for a slice: bounds of the lower and of the upper branch.
pub(super) type SliceBounds = [Bounds; 2];

/// All that is in an image.
pub(super) struct Content<'a> {
    pub(super) axes: &'a Axes,
    pub(super) fingerprint: u32,
    /// Voltage of each slice in V; one of 0 with a resistor.
    pub(super) voltages: &'a [f64],
    pub(super) is_current: bool,
    pub(super) slices: &'a [Vec<Column>],
    /// Margin beside a boundary, in levels.
    pub(super) margin: f64,
    pub(super) bounds: &'a [SliceBounds],
}

/// The boundaries of a slice in levels, and where each branch is.
pub(super) struct Curves {
    pub(super) rising: Vec<f64>,
    pub(super) falling: Vec<f64>,
}

impl Content<'_> {
    /// Whether any column has an upper motion within the map.
    pub(super) fn has_upper(&self) -> bool {
        let highest = f64::from(self.axes.levels[1]);
        self.slices.iter().flatten().any(|column| {
            !column.upper.is_empty() && column.falling.min(column.rising) <= highest + self.margin
        })
    }

    fn has_lower(&self) -> bool {
        self.slices.iter().flatten().any(|column| column.lower.iter().any(|(_, value)| *value > 0.0))
    }

    /// The boundaries of a slice; of a map with one branch the highest level.
    pub(super) fn curves(&self, slice: usize) -> Curves {
        let highest = f64::from(self.axes.levels[1]);
        let of = |get: fn(&Column) -> f64| -> Vec<f64> {
            let clip = |level: f64| level.round().clamp(0.0, 65535.0);
            let column = |column: &Column| if self.has_upper() { clip(get(column)) } else { highest };
            self.slices[slice].iter().map(column).collect()
        };
        Curves { rising: of(|column| column.rising), falling: of(|column| column.falling) }
    }

    /// Binary logarithm of the number of rows in an octave: of a single branch there are twice as many.
    fn row_bits(&self) -> u32 {
        if self.has_lower() && self.has_upper() { 1 } else { 2 }
    }

    fn rows(&self) -> u32 {
        (ROWS as u32 / 2) << (self.row_bits() - 1)
    }

    /// Spacing of the rows of the lower (0) or the upper (1) branch: the closest that reach over the map.
    pub(super) fn spacing(&self, branch: usize) -> Spacing {
        let [lowest, highest] = self.axes.levels.map(f64::from);
        let farthest = (0..self.slices.len())
            .map(|slice| {
                let curves = self.curves(slice);
                let distances: Vec<f64> = match branch {
                    0 => curves.rising.iter().map(|rising| rising - lowest).collect(),
                    _ => curves.falling.iter().map(|falling| highest - falling).collect(),
                };
                distances.into_iter().fold(0.0, f64::max)
            })
            .fold(0.0, f64::max);
        let bits = self.row_bits();
        let reaches = |shift: &u32| {
            f64::from(row_distance(self.rows() - 1, Spacing { shift: *shift, bits })) > farthest
        };
        Spacing { shift: (4..=12).find(reaches).unwrap_or(12), bits }
    }

    /// Binary logarithms of the values of a branch: for each column its rows.
    fn values(&self, slice: usize, branch: usize) -> Vec<Vec<f64>> {
        let curves = self.curves(slice);
        let spacing = self.spacing(branch);
        let columns = &self.slices[slice];
        let own: Vec<Option<Vec<f64>>> = columns
            .iter()
            .enumerate()
            .map(|(index, column)| {
                let distance = |row: u32| f64::from(row_distance(row, spacing));
                let end = f64::from(self.axes.levels[1]);
                if branch == 0 {
                    let nodes: Vec<f64> =
                        (0..self.rows()).rev().map(|row| curves.rising[index] - distance(row)).collect();
                    let values = fitted(&column.lower, &nodes, end)?;
                    Some(values.into_iter().rev().collect())
                } else {
                    let nodes: Vec<f64> =
                        (0..self.rows()).map(|row| curves.falling[index] + distance(row)).collect();
                    fitted(&column.upper, &nodes, end)
                }
            })
            .collect();
        // A column without this motion has the values of the nearest one with it: it is asked only beside that one.
        (0..columns.len())
            .map(|index| {
                let nearest = (0..columns.len())
                    .filter(|&other| own[other].is_some())
                    .min_by_key(|&other| other.abs_diff(index));
                nearest
                    .and_then(|other| own[other].clone())
                    .unwrap_or_else(|| vec![0.0; self.rows() as usize])
            })
            .collect()
    }

    pub(super) fn image(&self) -> Result<Image, Failure> {
        let branches: Vec<usize> = [self.has_lower(), self.has_upper()]
            .iter()
            .enumerate()
            .filter_map(|(index, has)| has.then_some(index))
            .collect();
        let values: Vec<Vec<Vec<Vec<f64>>>> = (0..self.slices.len())
            .map(|slice| branches.iter().map(|&branch| self.values(slice, branch)).collect())
            .collect();
        let all = values.iter().flatten().flatten().flatten().copied();
        let (least, most) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
        if !(least.is_finite() && most.is_finite()) {
            return Err(Failure::Step("no steady motion of this map gives any power".to_owned()));
        }
        // The largest value is below the end of the range; 32 octaves below it values are those of the lowest level.
        let octaves = most.floor() - 30.0;
        let encode = |value: f64| {
            ((value - octaves) * f64::from(LEVELS_PER_OCTAVE)).round().clamp(0.0, 65535.0) as u16
        };
        let mut words = self.head(&branches, octaves);
        for &voltage in self.voltages {
            words.push(level(voltage as f32).and_then(|level| u16::try_from(level).ok()).unwrap_or(0));
        }
        for (slice, of_slice) in values.iter().enumerate() {
            let curves = self.curves(slice);
            for (column, (rising, falling)) in curves.rising.iter().zip(&curves.falling).enumerate() {
                words.extend([*rising as u16, if branches.contains(&1) { *falling as u16 } else { NOWHERE }]);
                words.extend(of_slice.iter().flat_map(|branch| &branch[column]).map(|&value| encode(value)));
            }
        }
        for bounds in self.bounds {
            for part in 0..PARTS {
                words.extend(
                    bounds.iter().flat_map(|branch| [branch[part], branch[part + PARTS]]).flat_map(factors),
                );
            }
        }
        words.extend([0; TAIL]);
        seal(&mut words);
        let image = Image { words, fingerprint: self.fingerprint };
        image.map()?;
        Ok(image)
    }

    fn head(&self, branches: &[usize], octaves: f64) -> Vec<u16> {
        let axes = self.axes;
        let [factor, density] = self.broadband();
        let spaced = |branch: usize| {
            let Spacing { shift, bits } = self.spacing(branch);
            shift as u16 | (bits as u16) << 8
        };
        let flags =
            [(self.is_current, CURRENT), (branches.contains(&0), LOWER), (branches.contains(&1), UPPER)];
        let flags = flags.iter().filter(|(is, _)| *is).fold(0, |flags, (_, flag)| flags | flag);
        let rows = |branch: usize| if branches.contains(&branch) { self.rows() as u16 } else { 0 };
        let signed = |number: i32| (number as i16).cast_unsigned();
        let head: [u16; HEAD] = [
            MAGIC,
            VERSION,
            0,
            self.fingerprint as u16,
            (self.fingerprint >> 16) as u16,
            flags,
            COLUMNS as u16,
            self.slices.len() as u16,
            axes.resonance as u16,
            (axes.resonance >> 16) as u16,
            signed(axes.shift),
            axes.slope as u16,
            signed(axes.first),
            axes.span as u16,
            rows(0),
            rows(1),
            spaced(0),
            spaced(1),
            axes.levels[0] as u16,
            axes.levels[1] as u16,
            self.margin.ceil() as u16,
            signed(octaves as i32),
            0,
            0,
            0,
            0,
            factor,
            density,
        ];
        head.to_vec()
    }

    /// Levels of the power over the density of broadband vibration and of the largest density, by the first slice; zeros where
    /// the lower branch at the lowest amplitude is not linear.
    fn broadband(&self) -> [u16; 2] {
        let Some(Broadband { factor, largest }) = self.linear() else { return [0; 2] };
        let level =
            |number: f64, octaves: i32| (number.log2() + f64::from(octaves)) * f64::from(LEVELS_PER_OCTAVE);
        let factor = level(factor, POWER_OCTAVES).round();
        // An output power that the word does not hold is none: a clipped one would be taken for the truth.
        if !(1.0..=65535.0).contains(&factor) {
            return [0; 2];
        }
        [factor as u16, level(largest, DENSITY_OCTAVES).round().clamp(0.0, 65535.0) as u16]
    }

    /// The output power over the density, `2 ∫ h df`, and the largest density; `None` unless every column's lower branch is as the
    /// square of the amplitude at its lowest amplitudes.
    pub(super) fn linear(&self) -> Option<Broadband> {
        let columns = self.slices.first()?;
        let octave = f64::from(LEVELS_PER_OCTAVE);
        let mut over_square = Vec::new();
        for column in columns {
            let (start, _) = *column.lower.first()?;
            // A boundary this near leaves no room for a slope.
            if column.rising < start + octave {
                return None;
            }
            let [low, high] = [start, start + octave].map(|level| along(&column.lower, level));
            let (low, high) = (low?, high?);
            if (high - low - 2.0).abs() > LINEAR {
                return None;
            }
            over_square.push(low.exp2() / amplitude_of(start).powi(2));
        }
        let frequencies = &self.axes.frequencies;
        let centre = self.axes.centre_hz;
        let mut integral = 0.0;
        for (pair, value) in frequencies.windows(2).zip(over_square.windows(2)) {
            let (ratio, width) = ((value[1] / value[0]).ln(), pair[1] - pair[0]);
            // The integral of an exponential through both values.
            let mean = if ratio.abs() < 1e-6 { value[0] } else { (value[1] - value[0]) / ratio };
            integral += mean * width;
        }
        for (edge, value) in
            [(frequencies.first()?, over_square.first()?), (frequencies.last()?, over_square.last()?)]
        {
            integral += (edge - centre).abs() * value;
        }
        let (below, _) = self.axes.column(centre);
        let [linear, rising] = [below, below + 1]
            .map(|index| (straight(&columns[index], over_square[index]), amplitude_of(columns[index].rising)))
            .into_iter()
            .fold([f64::INFINITY; 2], |[a, b], (linear, rising)| [a.min(linear), b.min(rising)]);
        let pi_bandwidth = std::f64::consts::PI * self.axes.half_bandwidth_hz;
        // The mean of the fourth power of the amplitude of noise is twice the square of that of its square.
        let largest = (rising * rising / (9.0 * pi_bandwidth)).min(linear * linear / (4.0 * pi_bandwidth));
        Some(Broadband { factor: 2.0 * integral, largest })
    }

    /// The part of a branch that a place is in, by its frequency and amplitude.
    pub(super) fn part(&self, slice: usize, branch: usize, frequency_hz: f64, amplitude: f64) -> usize {
        let (below, place) = self.axes.column(frequency_hz);
        let curves = self.curves(slice);
        let curve = if branch == 0 { &curves.rising } else { &curves.falling };
        let boundary = curve[below] + (curve[below + 1] - curve[below]) * place;
        let at = f64::from(level(amplitude as f32).unwrap_or(0));
        let distance = if branch == 0 { boundary - at } else { at - boundary };
        let spacing = self.spacing(branch);
        let (row, _) = row(distance.max(0.0) as u32, spacing);
        below * PARTS / (COLUMNS - 1) + if row < NEAR << (spacing.bits - 1) { 0 } else { BOUNDS / 2 }
    }
}

/// The words of a pair of bounds in octaves: factors of eight significant bits, rounded away from 1. From two octaves on there
/// is no lower bound, and the upper one is two octaves.
fn factors([lower, higher]: [f64; 2]) -> [u16; 2] {
    let bits = |octaves: f64| (octaves.exp2() as f32).to_bits();
    let low = if lower < 2.0 { bits(-lower) >> 16 } else { 0 };
    let high = (bits(higher.min(2.0)) + 0xffff) >> 16;
    [low as u16, high as u16]
}

impl Image {
    /// The map as a node has it.
    pub fn map(&self) -> Result<ResponseMap<&[u16]>, Failure> {
        ResponseMap::new(&self.words[..], self.fingerprint)
            .map_err(|error| Failure::Step(format!("the map cannot be written: {error}")))
    }

    /// Writes what was measured into the image.
    pub(super) fn state(&mut self, agreement: &Agreement) {
        let part = |value: f64| (value * 1e4).round().clamp(0.0, 65535.0) as u16;
        let numbers = [
            agreement.places.min(65535) as u16,
            part(agreement.median),
            part(agreement.percentile_90),
            part(agreement.bounds_hold),
        ];
        self.words[22..26].copy_from_slice(&numbers);
        seal(&mut self.words);
    }

    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        2 * self.words.len()
    }
}

/// The bounds of each slice, from the values of a map without bounds at operating points with known motions.
pub(super) fn bounds(content: &Content<'_>, judged: &[Judged]) -> Vec<SliceBounds> {
    (0..content.slices.len())
        .map(|slice| {
            [0, 1].map(|branch| {
                let mut largest: [Option<[f64; 2]>; BOUNDS] = [None; BOUNDS];
                for found in judged.iter().filter(|judged| judged.place.slice == slice) {
                    let there = [found.truth.lower, found.truth.upper][branch];
                    if let (Some(predicted), Some(truth)) = (predicted_of(&found.predicted)[branch], there)
                        && predicted.value > 0.0
                    {
                        let OperatingPoint { frequency_hz, amplitude, .. } = found.place;
                        let part = content.part(slice, branch, frequency_hz, amplitude);
                        let octaves = (truth.max(1e-300) / f64::from(predicted.value)).log2();
                        let [lower, higher] = largest[part].unwrap_or_default();
                        largest[part] = Some([lower.max(-octaves), higher.max(octaves)]);
                    }
                }
                spread(&largest)
            })
        })
        .collect()
}

/// The largest of each part and of those beside it in the same rows, with an allowance; of all parts where none of these was measured.
fn spread(largest: &[Option<[f64; 2]>; BOUNDS]) -> Bounds {
    let half = BOUNDS / 2;
    std::array::from_fn(|part| {
        let first = part / half * half;
        let beside = part.saturating_sub(1).max(first)..=(part + 1).min(first + half - 1);
        let near = &largest[beside];
        let measured = if near.iter().any(Option::is_some) { near } else { &largest[..] };
        let of = |side: usize| measured.iter().flatten().map(|found| found[side]).fold(0.0, f64::max);
        [ALLOWANCE * of(0) + LEAST, ALLOWANCE * of(1) + LEAST]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_covers_its_neighbours_and_no_other_rows() {
        let mut largest = [Some([0.0; 2]); BOUNDS];
        largest[3] = Some([0.2, 0.1]);
        largest[8] = Some([0.4, 0.3]);
        for unmeasured in &mut largest[11..14] {
            *unmeasured = None;
        }
        let spread = spread(&largest);
        for (part, found) in spread.iter().enumerate() {
            let expected = match part {
                2..=4 => [0.25 + LEAST, 0.125 + LEAST],
                8 | 9 => [0.5 + LEAST, 0.375 + LEAST],
                // Nothing was measured there: the largest of all.
                12 => [0.5 + LEAST, 0.375 + LEAST],
                _ => [LEAST; 2],
            };
            let off = (0..2).map(|side| (found[side] - expected[side]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{part}: {found:?}");
        }
    }
}
