use super::super::test_support::{advance, checksum, oscillator};
use super::*;
use core::f64::consts::TAU;

const POINTS: [[f64; 2]; 3] = [[10.0, 1.0], [40.0, 1.0], [200.0, 0.02]];

fn single(points: &[[f64; 2]]) -> Vec<[f32; 2], 8> {
    points.iter().map(|point| point.map(|value| value as f32)).collect()
}

fn drawn<const LINES: usize>(points: &[[f64; 2]], seed: u64) -> Random<f64, LINES> {
    let density = SpectralDensity::new(points).expect("valid");
    Random::new(&density, LINES as u32, seed).expect("valid")
}

fn at(seconds: f64) -> Instant {
    Instant::from_seconds(seconds).expect("in range")
}

/// Mean and its standard error.
fn estimate(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, (squares / (count - 1.0) / count).sqrt()]
}

#[test]
fn the_spline_is_the_sum_of_its_lines() {
    let random = drawn::<64>(&POINTS, 3);
    let lines: std::vec::Vec<_> = random.lines().collect();
    let root_mean_square = (0.5 * lines.iter().map(|line| line.amplitude.powi(2)).sum::<f64>()).sqrt();
    let mut squares = 0.0;
    for k in 0..2000 {
        let instant = at(f64::from(k) * 0.037_123);
        let time = instant.seconds::<f64>();
        let sum: f64 =
            lines.iter().map(|line| line.amplitude * (TAU * line.frequency * time + line.phase).sin()).sum();
        squares += (random.acceleration(instant) - sum).powi(2);
        let rate: f64 = lines
            .iter()
            .map(|line| {
                line.amplitude * TAU * line.frequency * (TAU * line.frequency * time + line.phase).cos()
            })
            .sum();
        let highest = TAU * 200.0 * root_mean_square;
        assert!((random.jerk(instant) - rate).abs() < 3e-6 * highest, "{k}");
    }
    // The images of a line at the highest frequency have 1.7·10⁻⁷ of its amplitude together, of lower ones less.
    let error = (squares / 2000.0).sqrt() / root_mean_square;
    assert!(error < 1.7e-7, "{error}");
}

#[test]
fn both_precisions_draw_the_same_lines() {
    let double = drawn::<256>(&POINTS, 77);
    let points = single(&POINTS);
    let density = SpectralDensity::new(&points).expect("valid");
    let narrow = Random::<f32, 256>::new(&density, 256, 77).expect("valid");
    for (one, two) in double.lines.iter().zip(&narrow.lines) {
        assert_eq!((one.turns, one.phase), (two.turns, two.phase));
        assert!((f64::from(two.coefficient) / one.coefficient - 1.0).abs() < 2e-6);
    }
    for k in 0..500 {
        let instant = at(f64::from(k) * 1.731);
        let difference = f64::from(narrow.acceleration(instant)) - double.acceleration(instant);
        assert!(difference.abs() < 1e-4, "{k}: {difference}");
    }
}

#[test]
fn the_bits_are_those_recorded_in_any_order() {
    let double = drawn::<32>(&POINTS, 5);
    let points = single(&POINTS);
    let narrow =
        Random::<f32, 32>::new(&SpectralDensity::new(&points).expect("valid"), 32, 5).expect("valid");
    let instants: std::vec::Vec<Instant> =
        (0..3000).map(|k: u64| Instant::from_ticks(k * 987_654_321 + k * k * 1_234)).collect();
    let forwards: std::vec::Vec<u64> = instants.iter().map(|&at| double.acceleration(at).to_bits()).collect();
    let mut backwards: std::vec::Vec<u64> =
        instants.iter().rev().map(|&at| double.acceleration(at).to_bits()).collect();
    backwards.reverse();
    assert!(forwards == backwards);
    let leaping = |k: usize| drawn::<32>(&POINTS, 5).acceleration(instants[k]).to_bits();
    assert!((0..3000).step_by(499).all(|k| leaping(k) == forwards[k]));
    let narrow = instants.iter().map(|&at| u64::from(narrow.acceleration(at).to_bits()));
    let found = [checksum(forwards.iter().copied()), checksum(narrow)];
    assert_eq!(found, [0x6c8c_3910_a12e_aee8, 0xed1c_aeb8_3c1d_6cf7], "{found:x?}");
}

#[test]
fn every_seed_has_the_mean_square_of_the_density_and_nearly_a_gaussian_distribution() {
    let density = SpectralDensity::new(&POINTS).expect("valid");
    let exact = density.mean_square();
    let (mut squares, mut kurtoses, mut of_lines) = (vec![], vec![], vec![]);
    for seed in 0..60 {
        let random = drawn::<128>(&POINTS, seed);
        let of_seed: f64 = random.lines().map(|line| 0.5 * line.amplitude.powi(2)).sum();
        // One frequency in each part of the band: the sums differ by far less than one over the number of lines.
        assert!((of_seed / exact - 1.0).abs() < 5e-3, "{seed}: {of_seed}");
        of_lines.push(of_seed);
        let quartic: f64 = random.lines().map(|line| line.amplitude.powi(4)).sum();
        let values: std::vec::Vec<f64> =
            (0..2000).map(|k| random.acceleration(at(f64::from(k) * 0.013_7))).collect();
        let moment = |power| values.iter().map(|value: &f64| value.powi(power)).sum::<f64>() / 2000.0;
        squares.push(moment(2));
        kurtoses.push(moment(4) / (exact * exact) + 1.5 * quartic / (2.0 * of_seed).powi(2));
    }
    let [mean, error] = estimate(&of_lines);
    assert!((mean - exact).abs() < 4.0 * error + 1e-12, "{mean} {error} {exact}");
    let [mean, error] = estimate(&squares);
    assert!((mean - exact).abs() < 4.0 * error && error < 0.01 * exact, "{mean} {error} {exact}");
    let [mean, error] = estimate(&kurtoses);
    assert!((mean - 3.0).abs() < 4.0 * error && error < 0.1, "{mean} {error}");
}

#[test]
fn the_periodogram_over_the_seeds_is_the_density() {
    let density = SpectralDensity::new(&POINTS).expect("valid");
    // Hann's window of a second: its main lobe has ±2 Hz.
    let rate = 1600;
    let window = |k: u32| 0.5 - 0.5 * (TAU * f64::from(k) / f64::from(rate)).cos();
    let norm: f64 = (0..rate).map(|k| window(k).powi(2)).sum::<f64>() * f64::from(rate) / 2.0;
    let frequencies = [14.0, 25.0, 35.0, 60.0, 100.0, 180.0, 205.0, 600.0];
    let mut powers = vec![vec![]; frequencies.len()];
    for seed in 0..60 {
        let random = drawn::<256>(&POINTS, seed);
        let values: std::vec::Vec<f64> =
            (0..rate).map(|k| window(k) * random.acceleration(at(f64::from(k) / f64::from(rate)))).collect();
        for (frequency, powers) in frequencies.iter().zip(&mut powers) {
            let [mut cosine, mut sine] = [0.0; 2];
            for (k, value) in (0..rate).zip(&values) {
                let angle = TAU * frequency * f64::from(k) / f64::from(rate);
                cosine += value * angle.cos();
                sine += value * angle.sin();
            }
            powers.push((cosine * cosine + sine * sine) / norm);
        }
    }
    for (frequency, powers) in frequencies.iter().zip(&powers) {
        let [mean, error] = estimate(powers);
        let exact = density.at(*frequency);
        if exact == 0.0 {
            assert!(mean < 1e-6, "{frequency} Hz: {mean}");
        } else {
            // The error of one periodogram is its mean; of 60 an eighth of it.
            assert!((mean - exact).abs() < 3.5 * error, "{frequency} Hz: {mean} {error} {exact}");
            assert!(error < 0.25 * exact, "{frequency} Hz: {mean} {error} {exact}");
        }
    }
}

#[test]
fn seeds_are_uncorrelated_and_a_seed_is_itself() {
    for [one, other] in [[1, 2], [0, u64::MAX], [7, 1 << 40], [1, 1_000_001]] {
        let [first, second] = [one, other].map(|seed| drawn::<128>(&POINTS, seed));
        // The band holds a hundred independent values in a second.
        let count = 4000;
        let products = (0..count).map(|k| {
            let instant = at(f64::from(k) * 0.05);
            first.acceleration(instant) * second.acceleration(instant)
        });
        let exact = SpectralDensity::new(&POINTS).expect("valid").mean_square();
        let correlation = products.sum::<f64>() / f64::from(count) / exact;
        assert!(correlation.abs() < 4.0 / f64::from(count).sqrt(), "{one} {other}: {correlation}");
        assert!(first != second && first == drawn::<128>(&POINTS, one));
    }
}

/// `∫ |H|² S df` of the displacement by Simpson's rule, with `H = 1/(ω₀² − ω² + 2iζω₀ω)`.
fn response_integral(density: &SpectralDensity<'_, f64>, hertz: f64, damping_ratio: f64) -> f64 {
    let [low, high] = density.band();
    let parts = 40_000;
    let width = (high - low) / f64::from(parts);
    let value = |k: i32| {
        let frequency = (low + f64::from(k) * width).min(high);
        let (own, driven) = (TAU * hertz, TAU * frequency);
        let [stiff, lossy] = [own * own - driven * driven, 2.0 * damping_ratio * own * driven];
        density.at(frequency) / (stiff * stiff + lossy * lossy)
    };
    let weight = |k: i32| if k == 0 || k == parts { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    (0..=parts).map(|k| weight(k) * value(k)).sum::<f64>() * width / 3.0
}

#[test]
fn the_mean_square_response_of_an_oscillator_is_the_spectral_integral() {
    let density = SpectralDensity::new(&POINTS).expect("valid");
    for (hertz, damping_ratio) in [(30.0, 0.02), (90.0, 0.05)] {
        let exact = response_integral(&density, hertz, damping_ratio);
        let oscillator = oscillator(hertz, damping_ratio);
        let squares: std::vec::Vec<f64> = (0..20)
            .map(|seed| {
                let random = drawn::<256>(&POINTS, seed);
                // Eight time constants of the motion, then 64 values in four seconds.
                let mut now = at(8.0 / (damping_ratio * hertz * TAU));
                let mut motion = [0.0; 2];
                advance(&random, &oscillator, &mut motion, [Instant::START, now]);
                let mut sum = 0.0;
                for _ in 0..256 {
                    let next = Instant::from_ticks(now.ticks() + (1 << 32));
                    advance(&random, &oscillator, &mut motion, [now, next]);
                    sum += motion[0] * motion[0] / 256.0;
                    now = next;
                }
                sum
            })
            .collect();
        let [mean, error] = estimate(&squares);
        // Student's t of 19 degrees of freedom, 95 %: 2.093.
        assert!((mean - exact).abs() < 2.093 * error, "{hertz} Hz: {mean} {error} {exact}");
        assert!(error < 0.1 * exact, "{hertz} Hz: {error} {exact}");
    }
}

#[test]
fn the_parts_of_the_band_are_octaves_and_the_spacing_is_their_width() {
    for points in [
        POINTS.as_slice(),
        &[[20.0, 1.0], [2000.0, 1.0]],
        &[[1e-3, 1.0], [1e5, 1.0]],
        &[[30.0, 1.0], [31.0, 2.0]],
    ] {
        let random = drawn::<200>(points, 11);
        let lines: std::vec::Vec<_> = random.lines().collect();
        let [low, high] = SpectralDensity::new(points).expect("valid").band();
        assert!(lines.windows(2).all(|pair| pair[0].frequency < pair[1].frequency));
        assert!(lines.iter().all(|line| (low..=high).contains(&line.frequency)));
        // Ten lines on end are ten parts apart, give or take one at each end.
        for ten in lines.windows(11) {
            let [first, last] = [ten[0].frequency, ten[10].frequency];
            let widths = [random.spacing(first), random.spacing(last)];
            let distance = last - first;
            assert!(distance > 9.0 * widths[0] && distance < 11.0 * widths[1], "{first} {last} {widths:?}");
        }
        let last = lines[199];
        assert!(high - last.frequency < 2.0 * random.spacing(high));
    }
}

#[test]
fn no_line_and_more_than_the_capacity_are_refused() {
    let density = SpectralDensity::new(&POINTS).expect("valid");
    for lines in [0, 9, u32::MAX] {
        assert_eq!(Random::<f64, 8>::new(&density, lines, 0).err(), Some(ExcitationError::Lines));
    }
}
