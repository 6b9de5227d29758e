//! What is known of the figures, on coarse grids.

use super::motion::{Case, WINDOW};
use super::response::Sweep;
use super::*;
use crate::scene_file;

const TOLERANCE: f64 = RESPONSE_TOLERANCE;

fn base() -> Scene {
    scene_file::read_shipped("contact-separation", &[]).expect("the shipped scene")
}

fn strong(frequency: f64) -> Case {
    let [charge_density, resistance] = STRONG;
    Case { charge_density, resistance, frequency, settle: SETTLE }
}

/// How many different gaps there are, to 5 µm.
fn different(gaps: &[f64]) -> usize {
    let mut seen: Vec<f64> = Vec::new();
    for gap in gaps {
        if seen.iter().all(|other| (gap - other).abs() > 5e-6) {
            seen.push(*gap);
        }
    }
    seen.len()
}

#[test]
fn more_charge_moves_the_band_to_the_left_and_less_gap() {
    let grid = Grid { from: 1860, to: 2080, step: 10 };
    let pairs = [(5.0, 100.0), (35.0, 100.0), (50.0, 100.0), (50.0, 1.0)];
    let sweeps = sweeps(&base(), &pairs, grid, TOLERANCE, &|| ()).expect("all can be run");
    // First and last frequency with impacts and the largest gap in mm, by an independent integrator.
    let known = [(19.75, 20.75, 6.018), (19.35, 20.45, 5.792), (18.85, 20.15, 5.537), (19.05, 20.10, 5.522)];
    for (sweep, (first, last, gap)) in sweeps.iter().zip(known) {
        let [from, to] = sweep.band().expect("impacts");
        assert!(
            (from - first).abs() < 0.11 && (to - last).abs() < 0.11,
            "{from} to {to}, not {first} to {last}"
        );
        let largest =
            sweep.responses.iter().filter_map(|response| response.found.peak_gap_m).fold(0.0, f64::max);
        assert!((1e3 * largest / gap - 1.0).abs() < 5e-3, "{largest}, not {gap} mm");
    }
    let width = |sweep: &Sweep| sweep.band().map_or(0.0, |[from, to]| to - from);
    assert!(width(&sweeps[2]) > width(&sweeps[0]), "the band becomes wider with charge");
    assert!(width(&sweeps[2]) > width(&sweeps[3]), "and with resistance");
}

#[test]
fn impacts_begin_and_end_within_a_hundredth_and_a_twentieth_of_a_hertz() {
    let impacts = FREQUENCIES.map(|frequency| {
        let response = strong(frequency).response(&base(), MOTION_TOLERANCE).expect("it can be run");
        response.found.impacts_per_period.expect("one sine")
    });
    let [before, after, edge, beyond] = impacts;
    assert_eq!((before, beyond), (0.0, 0.0));
    assert!((0.02..0.1).contains(&after), "{after} a period at the onset");
    assert!((edge - 1.0).abs() < 1e-9, "{edge} a period at the edge");
}

#[test]
fn the_diagram_is_one_point_then_scattered_then_one_point() {
    let count = |frequency| {
        let case = Case { settle: DIAGRAM_SETTLE, ..strong(frequency) };
        let gaps = case.stroboscopic(&base(), MOTION_TOLERANCE).expect("it can be run");
        assert_eq!(gaps.len(), WINDOW as usize);
        different(&gaps)
    };
    assert_eq!(count(18.83), 1);
    assert!(count(19.2) > 40);
    assert_eq!(count(19.9), 1);
    assert_eq!(count(20.2), 1);
}

#[test]
fn a_gap_over_time_ends_on_the_stroboscopic_one() {
    let case = strong(20.0);
    let gaps = case.motion(&base(), TOLERANCE, 8, SETTLE).expect("it can be run").gaps;
    let strobe = case.stroboscopic(&base(), TOLERANCE).expect("it can be run");
    assert_eq!(gaps.len(), 8 * strobe.len());
    for (index, gap) in strobe.iter().enumerate() {
        let (period, other) = gaps[8 * index];
        assert_eq!(period, f64::from(SETTLE) + index as f64);
        assert!((gap - other).abs() < 1e-9, "{gap} and {other} m in period {period}");
    }
}

#[test]
fn frequencies_are_the_numbers_that_they_are_written_as() {
    let frequencies: Vec<f64> = Grid { from: 1883, to: 1887, step: 2 }.frequencies().collect();
    assert_eq!(frequencies, [18.83, 18.85, 18.87]);
}

#[test]
fn each_impact_of_a_time_history_is_marked() {
    for frequency in [18.83, 18.84, 20.15, 20.20] {
        let motion = strong(frequency).motion(&base(), MOTION_TOLERANCE, 60, SETTLE).expect("it can be run");
        assert_eq!(motion.hits.len() as u64, motion.impacts, "at {frequency} Hz");
    }
}
