//! Node values fitted to all points along a branch.
//!
//! A node that takes the value of one point has all of its scatter where the motion is not periodic, and the chord between two
//! nodes is off by the whole bend of the values between them. The fitted values are those whose chords have the least squares
//! of the distances from the points' own chords, by the integral over the amplitude. Where the value is steep as at a threshold
//! it counts less: a chord cannot follow it, and would be drawn off from the amplitudes beside it.

use super::column::{between, logarithms};

/// Levels between two places at which the distances are taken.
const GRID: f64 = 16.0;
/// Weight of the value by the points at a node itself, for nodes that no point is beside.
const OWN: f64 = 1e-3;
/// Octaves of the value in an octave of the amplitude from which it is steep: twice those of a linear harvester.
const STEEP: f64 = 4.0;
/// Octaves below the largest value of a branch that is nothing, as in an image.
const NOTHING: f64 = 32.0;

/// Values at nodes of rising level, fitted to the binary logarithms of the values along a branch up to the level `end`.
pub(super) fn fitted(branch: &[(f64, f64)], nodes: &[f64], end: f64) -> Option<Vec<f64>> {
    let points = logarithms(branch);
    let (first, last) = (points.first()?.0, points.last()?.0.min(end));
    let floor = points.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max) - NOTHING;
    let value = |level: f64| between(&points, level).max(floor);
    // The normal equations: a symmetric matrix with three diagonals, and the right side.
    let (mut diagonal, mut beside) = (vec![OWN; nodes.len()], vec![0.0; nodes.len()]);
    let mut right: Vec<f64> = nodes.iter().map(|&node| OWN * value(node)).collect();
    for (cell, pair) in nodes.windows(2).enumerate() {
        let width = pair[1] - pair[0];
        let count = (width / GRID).ceil();
        for index in 0..count as usize {
            let part = (index as f64 + 0.5) / count;
            let level = pair[0] + part * width;
            if !(first..=last).contains(&level) {
                continue;
            }
            let slope = (value(level + GRID) - value(level - GRID)) / (2.0 * GRID) * 2048.0;
            let weight = width / count / GRID / (1.0 + (slope / STEEP).powi(2));
            diagonal[cell] += weight * (1.0 - part).powi(2);
            diagonal[cell + 1] += weight * part.powi(2);
            beside[cell] += weight * part * (1.0 - part);
            right[cell] += weight * (1.0 - part) * value(level);
            right[cell + 1] += weight * part * value(level);
        }
    }
    for index in 1..nodes.len() {
        let factor = beside[index - 1] / diagonal[index - 1];
        diagonal[index] -= factor * beside[index - 1];
        right[index] -= factor * right[index - 1];
    }
    let mut values = vec![0.0; nodes.len()];
    let mut above = 0.0;
    for index in (0..nodes.len()).rev() {
        above = (right[index] - beside[index] * above) / diagonal[index];
        values[index] = above;
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::super::column::along;
    use super::*;

    const NODES: [f64; 5] = [1000.0, 1100.0, 1300.0, 1700.0, 2500.0];

    #[test]
    fn chords_between_the_nodes_are_met() {
        let values = [-30.0_f64, -28.0, -27.5, -24.0, -23.0];
        let points: Vec<(f64, f64)> =
            NODES.into_iter().zip(values).map(|(level, value)| (level, value.exp2())).collect();
        let found = fitted(&points, &NODES, 1e9).expect("values above 0");
        for (found, expected) in found.iter().zip(values) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn scatter_from_point_to_point_averages_out() {
        // A power law, every second point 20 % above and every other 20 % below it.
        let exact = |level: f64| level / 1024.0 - 30.0;
        let points: Vec<(f64, f64)> = (0..101)
            .map(|index| {
                let level = 1000.0 + 15.0 * f64::from(index);
                (level, exact(level).exp2() * if index % 2 == 0 { 1.2 } else { 1.0 / 1.2 })
            })
            .collect();
        let found = fitted(&points, &NODES, 1e9).expect("values above 0");
        for (index, (&level, found)) in NODES.iter().zip(&found).enumerate() {
            let own = (along(&points, level).expect("a value") - exact(level)).abs();
            let off = (found - exact(level)).abs();
            assert!(off < 0.12, "{level}: {off}");
            assert!(index == 0 || off < 0.6 * own || own < 0.1, "{level}: {off} {own}");
        }
    }

    #[test]
    fn nodes_beyond_the_points_have_the_value_at_their_end() {
        let points = [(1000.0, 1.0), (1200.0, 1.0)];
        let found = fitted(&points, &NODES, 1150.0).expect("values above 0");
        assert!(found.iter().all(|value| value.abs() < 1e-9), "{found:?}");
        assert_eq!(fitted(&[(1000.0, 0.0)], &NODES, 1e9), None);
    }
}
