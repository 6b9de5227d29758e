//! Amplitudes of the lines of a record.

use std::f64::consts::TAU;

/// Most lines of a spectrum.
const MOST_LINES: f64 = 4000.0;

/// Frequency in Hz and amplitude of lines up to a frequency, one over the length of the record apart, by the sum over the
/// rows, at equal distances, of the last part of a window. A Hann window keeps a line that is between two from spreading: a sine has its amplitude
/// at its frequency, to 15 % between two lines.
pub(super) fn amplitudes(points: &[(f64, f64)], [from, to]: [f64; 2], highest_hz: f64) -> Vec<(f64, f64)> {
    let length = (to - from).min(MOST_LINES / highest_hz);
    let rows: Vec<&(f64, f64)> =
        points.iter().filter(|(time, _)| (to - length..=to).contains(time)).collect();
    let (Some(first), Some(last), true) = (rows.first(), rows.last(), rows.len() > 2) else {
        return Vec::new();
    };
    let span = last.0 - first.0;
    let count = rows.len() as f64;
    let every = span / (count - 1.0);
    let mean = rows.iter().map(|point| point.1).sum::<f64>() / count;
    let weighted: Vec<f64> = rows
        .iter()
        .map(|(time, value)| (value - mean) * (1.0 - (TAU * (time - first.0) / span).cos()))
        .collect();
    let lines = (highest_hz.min(0.5 / every) * span) as usize;
    (0..=lines)
        .map(|line| {
            let frequency = line as f64 / span;
            // One turn from row to row: all rows are needed, because what is left out would appear at other frequencies.
            let (sine, cosine) = (TAU * frequency * every).sin_cos();
            let (mut turned, mut sum) = ([1.0, 0.0], [0.0, 0.0]);
            for value in &weighted {
                sum = [sum[0] + value * turned[0], sum[1] + value * turned[1]];
                turned = [turned[0] * cosine - turned[1] * sine, turned[0] * sine + turned[1] * cosine];
            }
            (frequency, 2.0 / count * f64::hypot(sum[0], sum[1]))
        })
        .collect()
}
