//! Maps with known values: what is stored is read, between nodes by the stated rule, outside not at all.

mod interpolation;

use super::image::COLUMN_WORDS;
use super::test_map::{FINGERPRINT, factors, head};
use super::*;

const SPACING: Spacing = Spacing { shift: 11, bits: 1 };

/// What a test map has.
#[derive(Clone, Copy)]
struct Plan {
    flags: u16,
    /// Levels of the rising and the falling boundary, at every column.
    boundaries: [u16; 2],
    voltages: &'static [u16],
    /// Level of the value on a branch (0 lower, 1 upper) of a slice, at a column and a row.
    value: fn(usize, u32, u32, u32) -> u16,
}

/// Boundaries at 1 and 2 m/s², levels of values shifted by −20 octaves.
const BOTH: Plan = Plan {
    flags: LOWER | UPPER,
    boundaries: [17 * 2048, 16 * 2048],
    voltages: &[0],
    value: |_, branch, column, row| (1000 + 20_000 * branch + 100 * column + 10 * row) as u16,
};

/// The map of a plan, with the [`head`] of all test maps.
fn built(plan: &Plan) -> Vec<u16> {
    let rows = match plan.flags & (LOWER | UPPER) {
        LOWER => [ROWS as u16, 0],
        UPPER => [0, ROWS as u16],
        _ => [ROWS as u16 / 2; 2],
    };
    let columns = |slice: usize| {
        let column = move |column: usize| {
            let mut words = plan.boundaries.to_vec();
            for (branch, rows) in rows.into_iter().enumerate() {
                let value = |row| (plan.value)(slice, branch as u32, column as u32, u32::from(row));
                words.extend((0..rows).map(value));
            }
            words
        };
        (0..COLUMNS).flat_map(column)
    };
    let mut words = head(plan.flags, rows, plan.voltages.len());
    words.extend(plan.voltages);
    words.extend((0..plan.voltages.len()).flat_map(columns));
    // An eighth lower, a half higher; far rows a quarter and twice.
    words.extend(factors([0.875, 1.5, 0.75, 2.0]).repeat(2 * PARTS * plan.voltages.len()));
    words.extend([0; TAIL]);
    seal(&mut words);
    words
}

fn one(response: Response) -> (Branch, Bounded) {
    match response {
        Response::One { branch, income } => (branch, income),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_stored_node_is_read_from_words_and_from_bytes() {
    let words = built(&BOTH);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    // A map is identified by its own words, in a longer buffer too.
    let checksum = u32::from(words[words.len() - 2]) | u32::from(words[words.len() - 1]) << 16;
    let longer = [&words[..], &[7; 100]].concat();
    for given in [&words, &longer] {
        assert_eq!(ResponseMap::new(&given[..], FINGERPRINT).expect("valid").checksum(), checksum);
    }
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let of_bytes = ResponseMap::new(&bytes[..], FINGERPRINT).expect("valid");
    assert_eq!(map.resonance(), 20.0);
    // The resonance is column 16. Row 3 is two octaves above the falling boundary of 1 m/s².
    assert_eq!(row_distance(3, SPACING), 4096);
    let (branch, income) = one(map.at(4.0, 20.0));
    assert_eq!(branch, Branch::Upper);
    let expected = number(21_000 + 1600 + 30 - 20 * 2048);
    // The column is a 2⁻³² of the map to the right of the resonance, and numbers between are rounded down.
    assert!((f64::from(expected / income.value).log2() * 2048.0 - 0.5).abs() < 0.6, "{income:?} {expected}");
    assert_eq!(of_bytes.at(4.0, 20.0), map.at(4.0, 20.0));
    // The lower branch, 1.15 octaves below the rising boundary of 2 m/s².
    let level_of = level(0.9).expect("positive");
    let (_, income) = one(map.at(0.9, 20.0));
    let distance = (17 * 2048 - level_of) as u32;
    let (row, above) = super::row(distance, SPACING);
    let exact = 2600.0 + 10.0 * (f64::from(row) + f64::from(above) / 1024.0);
    let found = f64::from(income.value).log2() * 2048.0 + 20.0 * 2048.0;
    assert!((found - exact).abs() < 2.0, "{found} {exact}");
}

#[test]
fn bounds_are_those_of_their_part() {
    // The fourth row is 3/4 octave below the boundary.
    let mut words = built(&BOTH);
    words[16] = 1 << 8 | 9;
    seal(&mut words);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    let Response::Two { lower: near, .. } = map.at(1.9, 20.0) else { panic!("between the boundaries") };
    // The products of eight and sixteen significant bits are exact.
    assert_eq!((near.low, near.high), (0.875 * near.value, 1.5 * near.value));
    let (_, far) = one(map.at(0.9, 20.0));
    assert_eq!((far.low, far.high), (0.75 * far.value, 2.0 * far.value));
}

#[test]
fn between_the_boundaries_both_branches_are_told_and_the_lower_counts() {
    let words = built(&BOTH);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    for amplitude in [1.0_f32, 1.5, 2.0] {
        let response = map.at(amplitude, 20.05);
        let Response::Two { lower, upper } = response else { panic!("{response:?}") };
        assert!(upper.low > lower.high);
        let income = response.income().expect("inside");
        assert_eq!((income.value, income.low, income.high), (lower.value, lower.low, upper.high));
    }
    // The margin is 40 levels, 1.4 %.
    assert!(matches!(map.at(2.04, 20.05), Response::One { branch: Branch::Upper, .. }));
    assert!(matches!(map.at(0.98, 20.05), Response::One { branch: Branch::Lower, .. }));
}

#[test]
fn beyond_an_edge_there_is_no_value() {
    let words = built(&BOTH);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    let outside = |amplitude, frequency| match map.at(amplitude, frequency) {
        Response::Outside(outside) => outside,
        inside => panic!("{amplitude} {frequency}: {inside:?}"),
    };
    // sinh 2 half-bandwidths on both sides.
    let reach = 2.0_f32.sinh() * 0.1;
    assert!(map.at(1.0, 20.0 + 0.999 * reach).income().is_some());
    assert_eq!(outside(1.0, 20.0 + 1.004 * reach), Outside::FrequencyAbove);
    assert_eq!(outside(1.0, 20.0 - 1.004 * reach), Outside::FrequencyBelow);
    assert_eq!(outside(1.0, 1e-9), Outside::FrequencyBelow);
    assert_eq!(outside(1.0, 8000.0), Outside::FrequencyAbove);
    assert_eq!(outside(0.2499, 20.0), Outside::AmplitudeBelow);
    assert_eq!(outside(0.0, 20.0), Outside::AmplitudeBelow);
    assert_eq!(outside(8.01, 20.0), Outside::AmplitudeAbove);
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert_eq!(outside(bad, 20.0), Outside::NoNumber);
        assert_eq!(outside(1.0, bad), Outside::NoNumber);
    }
    assert_eq!(outside(1.0, 0.0), Outside::NoNumber);
}

#[test]
fn a_map_with_one_branch_has_no_other_and_one_without_a_lower_branch_yields_nothing_there() {
    let single = Plan { flags: LOWER, boundaries: [19 * 2048, NOWHERE], ..BOTH };
    let words = built(&single);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    assert_eq!(one(map.at(7.9, 20.0)).0, Branch::Lower);
    let stuck = Plan { flags: UPPER, ..BOTH };
    let words = built(&stuck);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    assert_eq!(one(map.at(0.5, 20.0)), (Branch::Lower, Bounded::default()));
    let Response::Two { lower, upper } = map.at(1.5, 20.0) else { panic!("two motions") };
    assert_eq!(lower, Bounded::default());
    assert!(upper.value > 0.0);
}

#[test]
fn between_two_voltages_the_bounds_of_both_hold() {
    let plan = Plan {
        flags: LOWER | UPPER | CURRENT,
        voltages: &[17 * 2048, 18 * 2048],
        value: |slice, branch, column, row| {
            (1000 + 500 * slice as u32 + 20_000 * branch + 100 * column + 10 * row) as u16
        },
        ..BOTH
    };
    let words = built(&plan);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    assert!(map.is_current());
    assert_eq!((map.slices(), map.voltage(0), map.voltage(1)), (2, 2.0, 4.0));
    let [low, high] = [2.0, 4.0].map(|voltage| one(map.at_voltage(4.0, 20.0, voltage)).1);
    let (_, middle) = one(map.at_voltage(4.0, 20.0, 3.0));
    assert_eq!((middle.low, middle.high, middle.value), (low.low, high.high, high.value));
    for beyond in [1.99, 4.01] {
        assert_eq!(map.at_voltage(4.0, 20.0, beyond), Response::Outside(Outside::Voltage));
    }
    assert_eq!(map.at_voltage(4.0, 20.0, f32::NAN), Response::Outside(Outside::NoNumber));
}

#[test]
fn between_slices_with_one_and_two_motions_the_nearer_slice_gives_the_value() {
    let told = |value: f32| Bounded { value, low: 0.9 * value, high: 1.1 * value };
    let two = Response::Two { lower: told(3.0), upper: told(10.0) };
    for (branch, single) in [(Branch::Lower, 1.0), (Branch::Upper, 20.0)] {
        let one = Response::One { branch, income: told(single) };
        let other: f32 = if branch == Branch::Lower { 3.0 } else { 10.0 };
        let expected = |single_is_nearer| {
            let value = if single_is_nearer { single } else { other };
            let joined = Bounded { value, low: 0.9 * single.min(other), high: 1.1 * single.max(other) };
            match branch {
                Branch::Lower => Response::Two { lower: joined, upper: told(10.0) },
                Branch::Upper => Response::Two { lower: told(3.0), upper: joined },
            }
        };
        for nearer_high in [false, true] {
            assert_eq!(between(one, two, nearer_high), expected(!nearer_high), "{branch:?} {nearer_high}");
            assert_eq!(between(two, one, nearer_high), expected(nearer_high), "{branch:?} {nearer_high}");
        }
    }
}

#[test]
fn maps_of_another_harvester_and_damaged_ones_are_refused() {
    let words = built(&BOTH);
    assert_eq!(ResponseMap::new(&words[..], 1).err(), Some(MapError::ForeignHarvester { of: FINGERPRINT }));
    let last = words.len() - 1;
    for index in 0..words.len() {
        for bit in [0, 7, 15] {
            let mut flipped = words.clone();
            flipped[index] ^= 1 << bit;
            assert!(ResponseMap::new(&flipped[..], FINGERPRINT).is_err(), "{index}");
        }
    }
    assert!(matches!(ResponseMap::new(&words[..last], FINGERPRINT), Err(MapError::TooShort { .. })));
    assert_eq!(ResponseMap::new(&[0_u16; 4][..], FINGERPRINT).err(), Some(MapError::NotAMap));
    let bytes: &[u8] = &[];
    assert_eq!(ResponseMap::new(bytes, FINGERPRINT).err(), Some(MapError::NotAMap));
}

#[test]
fn a_map_with_a_word_outside_its_bounds_is_refused_by_that_word() {
    let columns = HEAD + 1;
    let bounds = columns + COLUMNS * COLUMN_WORDS;
    // Amplitudes are from 14 to 19 octaves, boundaries are at 17 and 16.
    let cases = [
        (5, 0, 5),
        (6, 65, 6),
        (7, 0, 7),
        (13, 0, 13),
        (14, 13, 15),
        (14, 1, 14),
        (16, 3 << 8 | 11, 16),
        (17, 13, 17),
        (18, 0, 18),
        (19, 14 * 2048, 19),
        // Shorter rows end above the lowest amplitude, and below the highest one.
        (16, 1 << 8 | 6, columns),
        (17, 1 << 8 | 6, columns + 1),
        // A lower bound above the value, or of less than a quarter; an upper bound below the value, or above four times.
        (bounds, 0x3f81, bounds),
        (bounds, 0x3e7f, bounds),
        (bounds + 63, 0x3f7f, bounds + 63),
        (bounds + 63, 0x4081, bounds + 63),
    ];
    for (index, word, told) in cases {
        let mut words = built(&BOTH);
        words[index] = word;
        seal(&mut words);
        let refused = ResponseMap::new(&words[..], FINGERPRINT).err();
        assert_eq!(refused, Some(MapError::Malformed { word: told }), "{index} {word}");
    }
    let mut words = built(&BOTH);
    words[bounds] = 0;
    seal(&mut words);
    assert!(ResponseMap::new(&words[..], FINGERPRINT).is_ok(), "no lower bound");
    let mut words = built(&Plan { flags: LOWER, boundaries: [19 * 2048, NOWHERE - 1], ..BOTH });
    seal(&mut words);
    let refused = ResponseMap::new(&words[..], FINGERPRINT).err();
    assert_eq!(refused, Some(MapError::Malformed { word: columns + 1 }));
}

#[test]
fn any_words_with_a_valid_checksum_are_refused_or_answer_without_panic() {
    // A linear congruential generator: the words need no quality.
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed >> 16
    };
    let mut accepted = 0;
    for _ in 0..20_000 {
        let mut words = built(&BOTH);
        for _ in 0..1 + random() % 3 {
            let index = 5 + random() as usize % (words.len() - 5 - TAIL);
            words[index] = random() as u16;
        }
        seal(&mut words);
        if let Ok(map) = ResponseMap::new(&words[..], FINGERPRINT) {
            accepted += 1;
            for _ in 0..8 {
                let amplitude = f32::from_bits(random() << 16 | random());
                let frequency = f32::from_bits(random() << 16 | random());
                for place in [(amplitude, frequency), (1.0, 20.0), (7.0, 19.8), (amplitude, 20.0)] {
                    let voltage = f32::from_bits(random() << 16 | random());
                    let answers = [
                        map.at(place.0, place.1),
                        map.in_slice_at(random() as usize % 4, place.0, place.1),
                        map.at_voltage(place.0, place.1, voltage),
                    ];
                    for income in answers.iter().filter_map(Response::income) {
                        assert!(income.low <= income.high, "{income:?}");
                    }
                    assert!(map.broadband(place.0).is_none_or(|found| found.value >= 0.0));
                }
            }
        }
    }
    assert!(accepted > 1000, "{accepted}");
}

#[test]
fn broadband_shaking_yields_in_proportion_to_its_density_and_is_flagged_above_the_largest() {
    let words = built(&BOTH);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    // The factor is 2^−20, the largest density 1.
    for density in [1e-12_f32, 1e-9, 1e-6, 1e-3, 0.1, 0.9] {
        let found = map.broadband(density).expect("linear");
        assert!((found.value * f32::from_bits((127 + 20) << 23) / density - 1.0).abs() < 2e-3, "{found:?}");
        assert!(found.is_linear);
    }
    assert!(map.broadband(1.1).is_some_and(|found| !found.is_linear));
    assert_eq!(map.broadband(0.0), Some(Broadband { value: 0.0, is_linear: true }));
    assert_eq!(map.broadband(f32::NAN), None);
}

#[test]
fn the_edges_are_the_first_and_the_last_number_with_a_level_and_a_detuning_in_the_map() {
    let words = built(&BOTH);
    let map = ResponseMap::new(&words[..], FINGERPRINT).expect("valid");
    let is_inside = |amplitude: f32, frequency: f32| map.at(amplitude, frequency).income().is_some();
    for bits in (0.2499_f32.to_bits()..0.2501_f32.to_bits()).chain(7.99_f32.to_bits()..8.01_f32.to_bits()) {
        let amplitude = f32::from_bits(bits);
        let expected = (14 * 2048..=19 * 2048).contains(&level(amplitude).expect("positive"));
        assert_eq!(is_inside(amplitude, 20.0), expected, "{amplitude}");
    }
    let reach = 2.0_f32.sinh() * 0.1;
    for edge in [20.0 - reach, 20.0 + reach] {
        for bits in (0.999_7 * edge).to_bits()..(1.000_3 * edge).to_bits() {
            let frequency = f32::from_bits(bits);
            let units = fixed(frequency, 15).expect("positive").cast_signed() - (20 << 15);
            let from_first = detuning(units, u32::from(words[11])) + 8 * 1024;
            assert_eq!(is_inside(1.0, frequency), (0..=16 * 1024).contains(&from_first), "{frequency}");
        }
    }
}
