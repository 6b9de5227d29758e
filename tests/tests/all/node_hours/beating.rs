//! Lines that beat: what a node says of them covers what the harvester yields at the amplitudes of the beat.

use std::f64::consts::TAU;

use model_core::energy::response_map::Branch;
use model_core::energy::{Response, ResponseMap};
use model_core::excitation::{LineBank, Lines};
use model_core::node::{Finding, PredictedPower};

use host_bench::simulated_node::Kind;

/// A line in Hz, and one beside it that the bank does not mix with it.
const LINES: [f64; 2] = [20.2, 19.3];
/// Samples in a second, and m/s² of a count.
const RATE: f64 = 400.0;
const UNIT: f64 = 1e-3;

/// Two blocks of the sum of both lines, in m/s².
fn blocks(amplitudes: [f64; 2]) -> Vec<Lines> {
    let bank = LineBank::<80, 16>::new(RATE as f32, 20.13, 0.1, UNIT as f32).expect("in bounds");
    let sample = |n: usize| {
        let parts = LINES
            .iter()
            .zip(amplitudes)
            .map(|(hertz, amplitude)| amplitude * (TAU * hertz * n as f64 / RATE).sin());
        (parts.sum::<f64>() / UNIT).round() as i16
    };
    let samples: Vec<i16> = (0..2 * bank.block()).map(sample).collect();
    let (mut state, mut left, mut found) = (bank.start(), &samples[..], Vec::new());
    while !left.is_empty() {
        let (taken, lines) = bank.take(&mut state, left);
        found.extend(lines);
        left = &left[taken..];
    }
    found
}

#[test]
fn a_beat_that_reaches_beyond_the_boundary_is_told_with_the_yield_there() {
    let bytes = Kind::ContactSeparation.map();
    let fingerprint = u32::from_le_bytes([bytes[6], bytes[7], bytes[8], bytes[9]]);
    let response = ResponseMap::new(bytes, fingerprint).expect("a map");
    let at = |amplitude: f64| response.at(amplitude as f32, LINES[0] as f32);
    // Just below the amplitude from which the map tells an upper motion.
    let boundary = (0..400)
        .map(|index| 0.11 * (1.01_f64).powi(index))
        .find(|&amplitude| !matches!(at(amplitude), Response::One { branch: Branch::Lower, .. }))
        .expect("a boundary");
    let amplitude = 0.85 * boundary;
    let upper = match at(1.05 * boundary) {
        Response::One { branch: Branch::Upper, income } => income.value,
        Response::Two { upper, .. } => upper.value,
        other => panic!("{other:?}"),
    };

    let told =
        |beside: f64| PredictedPower::of_blocks(&response, &blocks([amplitude, beside * amplitude]), 0.0);
    let steady = told(0.0);
    assert_eq!(steady.finding, Finding::Line);
    let income = at(amplitude).income().expect("inside");
    let (value, bound) = (steady.lower.value, steady.lower.bound());
    assert!((value / income.value - 1.0).abs() < 0.03, "{steady:?} {income:?}");
    assert!(value + bound < 0.5 * upper, "{steady:?} {upper}");

    // The beat is at up to 1.3 times the amplitude of the line, beyond the boundary.
    let beating = told(0.3);
    assert_eq!(beating.finding, Finding::Line);
    assert!(beating.lower.value + beating.lower.bound() >= 0.95 * upper, "{beating:?} {upper}");
    // A weak one beside it does not reach the boundary: the bound covers its amplitudes and no upper motion.
    let weak = told(0.1);
    let ends = [0.92, 1.08].map(|part| at(part * amplitude).income().expect("inside").value);
    let (value, bound) = (weak.lower.value, weak.lower.bound());
    assert!(value - bound <= ends[0] && ends[1] <= value + bound, "{weak:?} {ends:?}");
    assert!(value + bound < 0.5 * upper, "{weak:?} {upper}");
}
