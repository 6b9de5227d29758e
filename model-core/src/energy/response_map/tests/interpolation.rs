//! A look-up in integers against the interpolation of the same nodes in `f64`, read from the words by their layout.

use super::super::image::COLUMN_WORDS;
use super::*;

/// Levels by which integers may be off in a boundary: a place is in 2⁻¹⁰ of the distance of columns whose boundaries differ by 2500.
const OFF: f64 = 5.0;

/// A place between two numbers: the one below, and the part of the way, in `f64`.
type Between = (usize, f64);

fn mixed((below, part): Between, value: impl Fn(usize) -> f64) -> f64 {
    value(below) + (value(below + 1) - value(below)) * part
}

/// What a slice of a map with boundaries says, by the layout, in `f64`.
struct Told<'a> {
    words: &'a [u16],
    slice: usize,
}

impl Told<'_> {
    fn number(&self, index: usize) -> f64 {
        f64::from(self.words[index])
    }

    /// First word of a column.
    fn column(&self, column: usize) -> usize {
        HEAD + usize::from(self.words[7]) + (self.slice * COLUMNS + column) * COLUMN_WORDS
    }

    /// The place on the columns by the detuning; `None` beyond them.
    fn place(&self, frequency: f32) -> Option<Between> {
        let signed = |index: usize| i32::from(self.words[index].cast_signed());
        let wide = i32::from(self.words[8]) | i32::from(self.words[9]) << 16;
        let distance = fixed(frequency, signed(10))?.cast_signed() - wide;
        if distance.unsigned_abs() > FARTHEST {
            return None;
        }
        let from_first = f64::from(detuning(distance, u32::from(self.words[11])) - signed(12));
        let place = from_first / self.number(13) * (COLUMNS - 1) as f64;
        let below = (place.max(0.0) as usize).min(COLUMNS - 2);
        (0.0..=(COLUMNS - 1) as f64).contains(&place).then_some((below, place - below as f64))
    }

    fn boundary(&self, which: usize, place: Between) -> f64 {
        mixed(place, |column| self.number(self.column(column) + which))
    }

    /// Levels of a value, the factors of its bounds, and by how much integers may be off; the factors are 0 where the place
    /// is too near to another row or column to tell. `None` of a branch without values.
    fn branch(&self, which: usize, distance: f64, place: Between) -> Option<([f64; 3], f64)> {
        let rows = usize::from(self.words[14 + which]);
        if rows == 0 {
            return None;
        }
        let spacing = self.words[16 + which];
        let spacing = Spacing { shift: u32::from(spacing & 0xff), bits: u32::from(spacing >> 8) };
        let at = |row: usize| f64::from(row_distance(row as u32, spacing));
        let distance = distance.max(0.0);
        let row = (0..rows - 1).find(|&row| distance < at(row + 1)).expect("the rows reach over the map");
        let length = at(row + 1) - at(row);
        let first = 2 + if which == 1 { usize::from(self.words[14]) } else { 0 };
        let value = |column: usize, row: usize| self.number(self.column(column) + first + row);
        let level =
            mixed(place, |column| mixed((row, (distance - at(row)) / length), |row| value(column, row)));
        let spread =
            |along: usize, across: usize| (value(place.0 + along, row + across) - value(place.0, row)).abs();
        let off = spread(1, 0).max(spread(0, 1)).max(spread(1, 1));
        // Three numbers are rounded down; places are in 2⁻¹⁰.
        let off = 3.0 + 2.0 * off * (4.0 / 1024.0 + OFF / length);
        let far = usize::from(row >= (NEAR as usize) << (spacing.bits - 1));
        let part = place.0 * PARTS / (COLUMNS - 1);
        let slices = usize::from(self.words[7]) - self.slice;
        let bounds = self.column(slices * COLUMNS) + 8 * (self.slice * PARTS + part) + 4 * which + 2 * far;
        let factor = |index| f64::from(f32::from_bits(u32::from(self.words[index]) << 16));
        let octaves = f64::from(self.words[21].cast_signed());
        let [low, high] = [at(row), at(row + 1)].map(|edge| (edge - distance).abs());
        let is_edge = low.min(high) < OFF || place.1 < 1e-4;
        let factors = if is_edge { [0.0; 2] } else { [factor(bounds), factor(bounds + 1)] };
        Some(([level + octaves * 2048.0, factors[0], factors[1]], off))
    }
}

#[test]
fn a_look_up_is_the_interpolation_of_the_nodes_in_f64() {
    // Values and boundaries that neither rise nor fall evenly; some falling boundaries are above the rising ones.
    let value: fn(usize, u32, u32, u32) -> u16 = |slice, branch, column, row| {
        (20_000 + 997 * (3 * slice as u32 + 5 * branch + 11 * column + 17 * row) % 7001) as u16
    };
    let plans = [
        Plan { value, ..BOTH },
        Plan { value, flags: UPPER, ..BOTH },
        Plan { value, flags: LOWER, boundaries: [19 * 2048, NOWHERE], ..BOTH },
        Plan { value, flags: LOWER | UPPER | CURRENT, voltages: &[17 * 2048, 18 * 2048], ..BOTH },
    ];
    let mut seed = 7_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0
    };
    let mut told = [0; 3];
    for plan in &plans {
        for (shift, bits) in [(10, 1), (9, 1), (11, 2), (12, 2)] {
            let mut words = built(plan);
            [words[16], words[17]] = [shift | bits << 8; 2];
            let start = HEAD + plan.voltages.len();
            for column in 0..COLUMNS * plan.voltages.len() {
                words[start + column * COLUMN_WORDS] += (100 * (column * column % 7)) as u16;
                if plan.flags & UPPER != 0 {
                    words[start + column * COLUMN_WORDS + 1] +=
                        if column % 7 == 3 { 2500 } else { (90 * (column * column % 5)) as u16 };
                }
            }
            for (index, factor) in
                words[start + COLUMNS * plan.voltages.len() * COLUMN_WORDS..].iter_mut().enumerate()
            {
                // Lower factors down from 1, upper ones up to 2.
                *factor = if index % 2 == 0 { 0x3f80 - index as u16 } else { 0x3f80 + index as u16 };
            }
            seal(&mut words);
            let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            let of_bytes = ResponseMap::new(&bytes[..], FINGERPRINT).expect("valid");
            for index in 0..4000 {
                let slice = index % plan.voltages.len();
                let (amplitude, frequency) = (9.0 * random() * random(), 19.6 + 0.8 * random());
                let found = map.in_slice_at(slice, amplitude, frequency);
                assert_eq!(of_bytes.in_slice_at(slice, amplitude, frequency), found);
                if slice == 0 {
                    assert_eq!(map.at(amplitude, frequency), found);
                }
                let expected = Told { words: &words, slice };
                let level = level(amplitude).expect("positive");
                let inside = (14 * 2048..=19 * 2048).contains(&level);
                let (Some(place), true) = (expected.place(frequency), inside) else {
                    assert!(matches!(found, Response::Outside(_)), "{amplitude} {frequency}: {found:?}");
                    told[2] += 1;
                    continue;
                };
                let level = f64::from(level);
                let [rising, falling] = [0, 1].map(|which| expected.boundary(which, place));
                let beyond = [falling - 40.0 - level, level - rising - 40.0];
                if beyond.iter().any(|distance| distance.abs() < OFF) {
                    continue;
                }
                let agrees = |income: Bounded, which: usize, distance: f64| {
                    let Some(([level, low, high], off)) = expected.branch(which, distance, place) else {
                        assert_eq!(income, Bounded::default());
                        return;
                    };
                    let [value, lower, higher] = [income.value, income.low, income.high].map(f64::from);
                    // Chords of the exponential are 3e-4 high.
                    let error = value.log2() * 2048.0 - level;
                    assert!(error.abs() < off, "{amplitude} {frequency}: {error} of {off}");
                    if high > 0.0 {
                        assert_eq!((lower, higher), (value * low, value * high), "{amplitude} {frequency}");
                    }
                };
                match found {
                    Response::One { branch: Branch::Lower, income } if beyond[0] > 0.0 => {
                        agrees(income, 0, rising - level);
                        told[0] += 1;
                    }
                    Response::One { branch: Branch::Upper, income } if beyond[0] < 0.0 && beyond[1] > 0.0 => {
                        agrees(income, 1, level - falling);
                        told[0] += 1;
                    }
                    Response::Two { lower, upper } if beyond.iter().all(|&distance| distance < 0.0) => {
                        agrees(lower, 0, rising - level);
                        agrees(upper, 1, level - falling);
                        told[1] += 1;
                    }
                    other => panic!("{amplitude} {frequency}: {other:?}"),
                }
            }
        }
    }
    assert!(told.iter().all(|&count| count > 2000), "{told:?}");
}
