//! Lines, noise and large samples with known results.

use super::*;
use std::f64::consts::TAU;

/// 20.13 Hz at 400 samples per second, 1 mg a count.
fn bank() -> LineBank<80, 16> {
    LineBank::new(400.0, 20.13, 0.1, 9.81e-3).expect("in bounds")
}

fn lines<const M: usize, const P: usize>(
    bank: &LineBank<M, P>,
    rate: f64,
    signal: impl Fn(f64) -> f64,
) -> Vec<Lines> {
    let count = bank.block() * 4;
    let unit = f64::from(bank.unit);
    let samples: Vec<i16> = (0..count).map(|n| (signal(n as f64 / rate) / unit).round() as i16).collect();
    let (mut state, mut found, mut left) = (bank.start(), Vec::new(), &samples[..]);
    while !left.is_empty() {
        // As a FIFO hands them over.
        let burst = left.len().min(171);
        let (taken, block) = bank.take(&mut state, &left[..burst]);
        found.extend(block);
        left = &left[taken..];
    }
    found
}

#[test]
fn a_line_on_gravity_is_found_wherever_it_is_between_the_bins() {
    let bank = bank();
    for step in 0..40 {
        let frequency = f64::from(bank.reference_hz) + 0.025 * f64::from(step - 20);
        for amplitude in [0.2, 2.0, 20.0] {
            let found = lines(&bank, 400.0, |t| 9.81 + amplitude * (TAU * frequency * t + 0.7).sin());
            assert_eq!(found.len(), 4);
            for line in found {
                let off = (f64::from(line.amplitude) / amplitude - 1.0).abs();
                let far = (f64::from(line.frequency) - frequency).abs();
                assert!(
                    off < 0.006 && far < 0.003 && line.purity > 0.998,
                    "{frequency} {amplitude} {line:?}"
                );
            }
        }
    }
}

#[test]
fn gravity_and_harmonics_alone_are_no_line() {
    let bank = bank();
    let f = f64::from(bank.reference_hz);
    let found =
        lines(&bank, 400.0, |t| 9.81 + 5.0 * (TAU * 2.0 * f * t).sin() + 3.0 * (TAU * 3.0 * f * t).cos());
    assert!(found.iter().all(|line| line.amplitude < 0.02), "{found:?}");
    assert!(lines(&bank, 400.0, |_| 9.81).iter().all(|line| line.amplitude == 0.0));
}

#[test]
fn the_stronger_of_two_lines_is_found_and_is_not_pure() {
    let bank = bank();
    let found = lines(&bank, 400.0, |t| (TAU * 20.1 * t).sin() + 0.5 * (TAU * 21.1 * t + 1.0).sin());
    for line in &found {
        assert!((line.amplitude - 1.0).abs() < 0.02 && (line.frequency - 20.1).abs() < 0.02, "{line:?}");
        // 1²/(1² + 0.5²).
        assert!((line.purity - 0.8).abs() < 0.03, "{line:?}");
        assert_eq!(line.rest, 0.0);
    }
    // A weak line at the resonance beside a strong one off it.
    for line in lines(&bank, 400.0, |t| (TAU * 21.4 * t).sin() + 0.05 * (TAU * 20.1 * t + 1.0).sin()) {
        assert!(line.purity > 0.98 && (line.frequency - 21.4).abs() < 0.02, "{line:?}");
        // Its mean square over the two bins near the resonance, which hold nearly all of it, and leakage at −40 dB.
        assert_eq!(bank.near, [-1, 0]);
        let exact = 0.5 * 0.05_f32.powi(2) / (2.0 * bank.bin_hz);
        assert!((line.rest / exact - 1.0).abs() < 0.25, "{line:?} {exact}");
    }
}

#[test]
fn the_density_of_white_noise_is_its_variance_over_half_the_rate() {
    let bank = LineBank::<80, 16>::new(400.0, 20.13, 0.1, 1e-3).expect("in bounds");
    let mut seed = 7_u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut state = bank.start();
    let mut densities = Vec::new();
    for _ in 0..1600 * bank.block() {
        // Variance 3²/12 (m/s²)².
        let sample = (3.0 * uniform() / 1e-3).round() as i16;
        if let (_, Some(line)) = bank.take(&mut state, &[sample]) {
            densities.push(f64::from(line.density));
        }
    }
    let count = densities.len() as f64;
    let mean = densities.iter().sum::<f64>() / count;
    let variance = densities.iter().map(|density| (density - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let exact = 0.75 / 200.0;
    // The powers of two bins that are neighbours have the correlation 4/9.
    assert_eq!(bank.near[1] - bank.near[0], 1);
    let scatter = ((1.0 + 4.0 / 9.0) / 2.0_f64).sqrt();
    assert!((mean / exact - 1.0).abs() < 3.0 * scatter / count.sqrt(), "{mean} {exact}");
    assert!((variance.sqrt() / mean / scatter - 1.0).abs() < 0.08, "{} {scatter}", variance.sqrt() / mean);
}

#[test]
fn what_cannot_be_resolved_is_refused() {
    let new = |rate, frequency, half, unit| LineBank::<80, 16>::new(rate, frequency, half, unit).err();
    let field = |error: Option<ExcitationError>| match error {
        Some(ExcitationError::Bank(error)) => error.field,
        other => panic!("{other:?}"),
    };
    assert_eq!(new(400.0, 20.0, 0.1, 1e-3), None);
    // Two section rates, 10 Hz, to 0.45 of the rate.
    assert_eq!(new(400.0, 10.0, 0.1, 1e-3), None);
    assert_eq!(new(400.0, 180.0, 0.1, 1e-3), None);
    for frequency in [190.0, 9.9, 5.0, -20.0, f32::NAN] {
        assert_eq!(field(new(400.0, frequency, 0.1, 1e-3)), "frequency", "{frequency}");
    }
    assert_eq!(field(new(0.5, 0.1, 0.1, 1e-3)), "rate");
    for half_bandwidth in [0.0, -0.1, f32::NAN, f32::INFINITY] {
        assert_eq!(field(new(400.0, 20.0, half_bandwidth, 1e-3)), "half_bandwidth", "{half_bandwidth}");
    }
    for unit in [0.0, -1e-3, f32::NAN, f32::INFINITY] {
        assert_eq!(field(new(400.0, 20.0, 0.1, unit)), "unit", "{unit}");
    }
    for error in [
        LineBank::<8, 16>::new(400.0, 20.0, 0.1, 1e-3).err(),
        LineBank::<129, 16>::new(400.0, 20.0, 0.1, 1e-3).err(),
    ] {
        assert_eq!(field(error), "M");
    }
}

#[test]
fn a_bank_that_does_not_fit_its_resonance_says_by_how_much() {
    // Sections of 80 samples at 400 Hz reach a quarter of 5 Hz to both sides of 20 Hz.
    let band = |half| LineBank::<80, 16>::new(400.0, 20.0, half, 1e-3).err();
    assert_eq!(band(1.24), None);
    let error = band(1.26).expect("too wide");
    assert_eq!(error, ExcitationError::Band { section_rate: 5.0, half_bandwidth: 1.26, limit: 1.25 });
    let text = "bank of lines: half-bandwidth 1.26 Hz must be below 1.25 Hz with sections at 5.0 Hz: fewer samples in a section, or \
                a higher rate";
    assert_eq!(error.to_string(), text);
    // 16 sections last 3.2 s, the memory of a half-bandwidth of 0.02 Hz 8 s.
    match band(0.02) {
        Some(ExcitationError::Block { seconds, least }) => {
            assert!((seconds - 3.2).abs() < 1e-5 && (least - 7.957_747).abs() < 1e-4, "{seconds} {least}");
        }
        other => panic!("{other:?}"),
    }
    // Sections of 128 samples at 100 Hz, 0.78 Hz apart.
    let slow = LineBank::<128, 32>::new(100.0, 20.0, 0.5, 1e-3).expect_err("too wide");
    assert!(
        matches!(slow, ExcitationError::Band { section_rate, limit, .. } if section_rate < 1.6 && limit < 0.5),
        "{slow}"
    );
    let low = LineBank::<80, 16>::new(400.0, 5.0, 0.1, 1e-3).expect_err("too low");
    assert_eq!(low.to_string(), "bank of lines: frequency = 5.0 must be from 10.0 to 180.0");
}

#[test]
fn a_line_beyond_the_bins_appears_attenuated() {
    let bank = LineBank::<80, 16>::new(400.0, 20.0, 0.1, 1e-3).expect("in bounds");
    let section_rate = 5.0;
    for part in [0.75_f64, 0.85, 0.9] {
        let frequency = f64::from(bank.reference_hz) + part * section_rate;
        let attenuated = (std::f64::consts::PI * part).sin() / (std::f64::consts::PI * part);
        for line in lines(&bank, 400.0, |t| 1.0 * (TAU * frequency * t).sin()) {
            // The droop of its place among the bins is divided out.
            let found = f64::from(line.amplitude);
            assert!(found > 0.9 * attenuated && found < 1.15 * attenuated, "{part}: {found} {attenuated}");
        }
    }
}

#[test]
fn the_largest_samples_do_not_overflow() {
    let bank = LineBank::<128, 32>::new(1600.0, 40.0, 0.1, 1e-3).expect("in bounds");
    let f = TAU * f64::from(bank.reference_hz);
    for line in lines(&bank, 1600.0, |t| if (f * t + 1e-3).sin() > 0.0 { 32.767 } else { -32.768 }) {
        // The fundamental of a square wave.
        assert!(
            (f64::from(line.amplitude) / (32.767 * 4.0 / std::f64::consts::PI) - 1.0).abs() < 0.01,
            "{line:?}"
        );
    }
}

#[test]
fn the_tables_are_rounded_cosines_and_sines() {
    for whole in 8..=128 {
        for (part, unit) in (0..3 * whole).flat_map(|part| [(part, REFERENCE), (part, ROTATION)]) {
            let angle = TAU * part as f64 / whole as f64;
            let exact = [angle.cos(), -angle.sin()].map(|number| number * f64::from(unit));
            for (found, exact) in turned(part, whole, unit).map(f64::from).into_iter().zip(exact) {
                assert!((found - exact).abs() < 0.501, "{part}/{whole}: {found} {exact}");
            }
        }
    }
    // Quarter turns and turns back are exact: the sections of a block are folded by them.
    for (whole, part) in [8, 16, 32].into_iter().flat_map(|whole| (0..whole).map(move |part| (whole, part))) {
        let [cosine, sine] = turned(part, whole, ROTATION);
        let others = [part + whole / 4, whole - part].map(|part| turned(part, whole, ROTATION));
        assert_eq!(others, [[sine, -cosine], [cosine, -sine]], "{part}/{whole}");
    }
    // Gravity and its multiples vanish exactly.
    let sum = bank().reference.iter().fold([0; 2], |[a, b], [c, s]| [a + c, b + s]);
    assert_eq!(sum, [0; 2]);
}
