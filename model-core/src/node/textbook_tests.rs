//! The filter against a Kalman filter with dense matrices in `f64`, in the form of Joseph.

use super::filter::{Filter, FilterState, StoreReading};
use super::heard::PowerMeasurement;
use super::tests::{CELL, Random, filter, only, storage};
use crate::scalar::Scalar;

const N: usize = 6;
type Matrix = [[f64; N]; N];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..N).map(|k| a[row][k] * b[k][column]).sum()))
}

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| a[column][row]))
}

fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| a[row][column] + b[row][column]))
}

fn diagonal(entries: [f64; N]) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { entries[row] } else { 0.0 }))
}

/// Part of what a listen says of the gain that is believed.
const OF_GAIN: f64 = 0.7;

/// Energy, power, gain, excess draw, income of the hour, income of all.
struct Dense {
    mean: [f64; N],
    covariance: Matrix,
}

impl Dense {
    fn predict(&mut self, time: f64, standing: f64, spent: f64, walk: f64, deviation: f64) {
        let mut flow = diagonal([1.0; N]);
        flow[0][1] = time;
        flow[0][3] = -time;
        flow[4][1] = time;
        flow[5][1] = time;
        self.mean = std::array::from_fn(|row| (0..N).map(|k| flow[row][k] * self.mean[k]).sum());
        self.mean[0] -= standing * time + spent;
        self.covariance = product(&product(&flow, &self.covariance), &transposed(&flow));
        self.walk(time, walk);
        self.covariance[0][0] += deviation * deviation;
    }

    fn walk(&mut self, time: f64, walk: f64) {
        // The integral over the interval of the walk's effect: 1 on the power, the time left on energy and incomes.
        let effect = [1, 0, 0, 0, 1, 1].map(|is_integral| f64::from(is_integral) * time);
        let noise: Matrix = std::array::from_fn(|row| {
            std::array::from_fn(|column| match (row == 1, column == 1) {
                (true, true) => walk * time,
                (true, false) => walk * time * effect[column] / 2.0,
                (false, true) => walk * time * effect[row] / 2.0,
                (false, false) => walk * time * effect[row] * effect[column] / 3.0,
            })
        });
        self.covariance = sum(&self.covariance, &noise);
    }

    /// A jump of the power is taken as one since the reading just before where the storage would have shown it.
    fn unseen(&self, elapsed: f64, moved: f64) -> f64 {
        if (moved * elapsed).powi(2) > 9.0 * self.covariance[0][0] { 1.0 } else { elapsed }
    }

    /// Takes in what was heard: the power moves with the gain times the change, unless it has; then `P = g m`.
    fn hear(&mut self, elapsed: f64, hour: f64, [modelled, lasting, change, variance]: [f64; 4]) {
        let gain = self.mean[2];
        let departure = gain * modelled - self.mean[1];
        if (departure - gain * change).abs() < departure.abs() {
            let time = self.unseen(elapsed, gain * change);
            // A jump at each of many times: the time after it, in the interval and in the hour.
            let count = 20_000;
            let after = |part: u32| time * (f64::from(part) + 0.5) / f64::from(count);
            let mean = |of: &dyn Fn(f64) -> f64| {
                (0..count).map(|part| of(after(part))).sum::<f64>() / f64::from(count)
            };
            let within = |after: f64| after.min(hour);
            let means = [mean(&|after| after), mean(&within)];
            let effect = [means[0], 1.0, 0.0, 0.0, means[1], means[0]];
            let mut flow = diagonal([1.0; N]);
            for (row, effect) in flow.iter_mut().zip(effect) {
                row[2] += change * effect;
            }
            self.mean = std::array::from_fn(|row| (0..N).map(|k| flow[row][k] * self.mean[k]).sum());
            self.covariance = product(&product(&flow, &self.covariance), &transposed(&flow));
            for row in [0, 4, 5] {
                for column in [0, 4, 5] {
                    let of = |index: usize, after: f64| {
                        if index == 4 { within(after) - means[1] } else { after - means[0] }
                    };
                    self.covariance[row][column] +=
                        (gain * change).powi(2) * mean(&|after| of(row, after) * of(column, after));
                }
            }
        }
        let h = [0.0, 1.0, -lasting, 0.0, 0.0, 0.0];
        let departure = gain * modelled - self.mean[1];
        let expected: f64 =
            (0..N).map(|i| (0..N).map(|j| h[i] * self.covariance[i][j] * h[j]).sum::<f64>()).sum();
        if departure.powi(2) > expected + variance {
            let time = self.unseen(elapsed, departure).min(hour).max(1.0);
            self.walk(time, departure.powi(2) / time);
        }
        let measured = departure + (0..N).map(|k| h[k] * self.mean[k]).sum::<f64>();
        self.update(h, measured, variance, OF_GAIN);
    }

    /// Takes in `measured = h x` with a noise of variance `noise`; the gain of the map moves by a part of what would be best.
    fn update(&mut self, h: [f64; N], measured: f64, noise: f64, of_gain: f64) {
        let with: [f64; N] = std::array::from_fn(|row| (0..N).map(|k| self.covariance[row][k] * h[k]).sum());
        let variance = noise + (0..N).map(|k| h[k] * with[k]).sum::<f64>();
        let mut gain = with.map(|with| with / variance);
        gain[2] *= of_gain;
        let departure = measured - (0..N).map(|k| h[k] * self.mean[k]).sum::<f64>();
        for (mean, gain) in self.mean.iter_mut().zip(gain) {
            *mean += gain * departure;
        }
        let left: Matrix = std::array::from_fn(|row| {
            std::array::from_fn(|column| f64::from(row == column) - gain[row] * h[column])
        });
        let of_noise: Matrix =
            std::array::from_fn(|row| std::array::from_fn(|column| gain[row] * noise * gain[column]));
        let joseph = product(&product(&left, &self.covariance), &transposed(&left));
        self.covariance = sum(&joseph, &of_noise);
    }
}

/// The differences of means in deviations, and of deviations relative to themselves, at their largest.
fn differences<S: Scalar>(state: &FilterState<S>, dense: &Dense) -> (f64, f64) {
    let known = [state.store(), state.power(), state.gain(), state.draw(), state.hour(), state.all()];
    let mut largest = (0.0_f64, 0.0_f64);
    for (index, known) in known.iter().enumerate() {
        let deviation = dense.covariance[index][index].sqrt();
        largest.0 = largest.0.max((known.mean.to_f64() - dense.mean[index]).abs() / deviation);
        largest.1 = largest.1.max((known.deviation().to_f64() / deviation - 1.0).abs());
    }
    largest
}

/// Ten hours of minutes with a reading, and a listen each ten minutes; the largest differences at the ends of the hours.
fn ten_hours<S: Scalar>(filter: &Filter<S>, double: &Filter<f64>) -> (f64, f64) {
    let capacitance = double.storage.parameters().capacitor.capacitance;
    let volts_of = |energy: f64| (2.0 * energy / capacitance).sqrt();
    let mut random = Random(5);
    let (mut power, mut energy, walk) = (6e-6_f64, 0.5 * capacitance * 9.0, 1e-16_f64);
    let code = |energy: f64, random: &mut Random| {
        ((volts_of(energy) + 0.5 * CELL * random.normal()) / CELL).round() as u32
    };
    let mut state = filter.start();
    let first = code(energy, &mut random);
    filter.observe(&mut state, first, false);
    let [low, high] = [-0.5, 0.5].map(|part| double.storage.energy((f64::from(first) + part) * CELL));
    let noise = |low: f64, high: f64| {
        let width = high - low;
        (width * double.noise / double.cell).powi(2) + width * width / 12.0
    };
    let variances = [noise(low, high), 1e-8, double.gain_variance, double.standing_variance, 0.0, 0.0];
    let mut dense =
        Dense { mean: [0.5 * (low + high), 0.0, 1.0, 0.0, 0.0, 0.0], covariance: diagonal(variances) };
    let (mut largest, mut before) = ((0.0_f64, 0.0_f64), 0.0);
    for minute in 1..=600 {
        if minute % 10 == 1 {
            let modelled = power / 1.3;
            // A tenth of what was heard does not last.
            let lasting = if minute == 1 { modelled } else { before + 0.9 * (modelled - before) };
            let change = if minute == 1 { 0.0 } else { lasting - before };
            before = lasting;
            let variance = (0.1 * modelled).powi(2);
            let heard = [modelled, lasting, change, variance].map(S::from_f64);
            let [modelled, lasting, change, variance] = heard;
            let of_gain = S::from_f64(OF_GAIN);
            filter.hear(&mut state, 600, PowerMeasurement { modelled, lasting, change, variance, of_gain });
            dense.hear(600.0, f64::from(60 * ((minute - 1) % 60)), heard.map(S::to_f64));
        }
        power = (power + (60.0 * walk).sqrt() * random.normal()).max(1e-6);
        // Now and then what came in, so that the storage does not fill up.
        let spent = if minute % 4 == 0 { (energy - 0.5 * capacitance * 9.0).max(0.0) } else { 0.0 };
        energy += 60.0 * (power - 1.1e-6) - spent;
        filter.predict(&mut state, 60, true, S::from_f64(spent), only(S::from_f64(walk)));
        dense.predict(60.0, double.standing, spent, walk, double.spent * spent);
        let code = code(energy, &mut random);
        assert_eq!(filter.observe(&mut state, code, false).0, StoreReading::Used, "minute {minute}");
        let [low, high] = [-0.5, 0.5].map(|part| double.storage.energy((f64::from(code) + part) * CELL));
        dense.update([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.5 * (low + high), noise(low, high), 0.0);
        if minute % 60 == 0 {
            let (mean, deviation) = differences(&state, &dense);
            largest = (largest.0.max(mean), largest.1.max(deviation));
            state.close_hour();
            dense.mean[4] = 0.0;
            for other in 0..N {
                (dense.covariance[4][other], dense.covariance[other][4]) = (0.0, 0.0);
            }
        }
    }
    largest
}

#[test]
fn the_filter_is_that_of_the_textbook_with_dense_matrices() {
    for capacitance in [4e-3, 0.1] {
        let double =
            Filter { gain_variance: 0.25, standing_variance: 0.04e-12, spent: 0.02, ..filter(capacitance) };
        let (mean, deviation) = ten_hours(&double, &double);
        assert!(mean < 1e-5 && deviation < 1e-5, "{capacitance}: {mean} {deviation}");
        let single = Filter::<f32> {
            storage: storage(capacitance as f32),
            standing: double.standing as f32,
            standing_variance: double.standing_variance as f32,
            draw_drift: 0.0,
            spent: double.spent as f32,
            cell: double.cell as f32,
            noise: double.noise as f32,
            lasting: 0.0,
            full_code: double.full_code,
            gain_variance: double.gain_variance as f32,
            gain_drift: 0.0,
            power: double.power as f32,
        };
        let (mean, deviation) = ten_hours(&single, &double);
        assert!(mean < 0.02 && deviation < 0.01, "{capacitance}: {mean} {deviation}");
    }
}
