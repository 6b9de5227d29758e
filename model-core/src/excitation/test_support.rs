//! Integrals by quadrature, and the motion of an oscillator in steps of an excitation's responses.

use super::Excitation;
use crate::clock::{Instant, seconds_of_ticks};
use crate::oscillator::{Kernel, Oscillator};
use crate::scalar::Scalar;

/// Calls `take` with place, 0 to 1, weight and value at the points of Gauss's rule in `pieces` parts of the step.
fn quadrature(
    excitation: &impl Excitation<f64>,
    at: Instant,
    ticks: u32,
    pieces: u32,
    mut take: impl FnMut(f64, f64, f64),
) {
    for piece in 0..pieces {
        for node in [-0.6_f64.sqrt(), 0.0, 0.6_f64.sqrt()] {
            let place = (f64::from(piece) + 0.5 * (1.0 + node)) / f64::from(pieces);
            let offset = (place * f64::from(ticks)).floor();
            let weight = if node == 0.0 { 8.0 } else { 5.0 } / 18.0 / f64::from(pieces);
            let at = at.after(offset as u32);
            // The place is within a tick.
            let rest = (place * f64::from(ticks) - offset) / crate::clock::TICKS_PER_SECOND as f64;
            take(place, weight, excitation.acceleration(at) + rest * excitation.jerk(at));
        }
    }
}

/// Mean and half the rise of the nearest line over a step.
pub(super) fn line_by_quadrature(
    excitation: &impl Excitation<f64>,
    at: Instant,
    ticks: u32,
    pieces: u32,
) -> [f64; 2] {
    let (mut mean, mut tilt) = (0.0, 0.0);
    quadrature(excitation, at, ticks, pieces, |place, weight, value| {
        mean += weight * value;
        tilt += 3.0 * weight * (2.0 * place - 1.0) * value;
    });
    [mean, tilt]
}

/// Displacement and velocity of an oscillator, at rest at the start of a step: `∫ S(h − s) a(s) ds` and its rate.
pub(super) fn response_by_quadrature(
    excitation: &impl Excitation<f64>,
    oscillator: &Oscillator<f64>,
    at: Instant,
    ticks: u32,
) -> [f64; 2] {
    let decay = 0.5 * oscillator.damping;
    let damped = (oscillator.stiffness - decay * decay).sqrt();
    let step: f64 = seconds_of_ticks(ticks);
    let mut sums = [0.0; 2];
    quadrature(excitation, at, ticks, 16, |place, weight, value| {
        let left = (1.0 - place) * step;
        let shrunk = step * weight * value * (-decay * left).exp();
        sums[0] += shrunk * (damped * left).sin() / damped;
        sums[1] += shrunk * ((damped * left).cos() - decay / damped * (damped * left).sin());
    });
    sums
}

/// The oscillator of a frequency in Hz and a damping ratio.
pub(super) fn oscillator<S: Scalar>(hertz: f64, damping_ratio: f64) -> Oscillator<S> {
    let angular = hertz * std::f64::consts::TAU;
    Oscillator {
        stiffness: S::from_f64(angular * angular),
        damping: S::from_f64(2.0 * damping_ratio * angular),
        rest: S::ZERO,
        base_coupling: S::ONE,
    }
}

/// Moves `motion`, displacement and velocity of `x'' + d x' + w x = a(t)`, from one instant to another.
pub(super) fn advance<S: Scalar>(
    excitation: &impl Excitation<S>,
    oscillator: &Oscillator<S>,
    motion: &mut [S; 2],
    [from, until]: [Instant; 2],
) {
    let highest = excitation.angular_frequency().max(oscillator.stiffness.sqrt());
    let longest = crate::clock::ticks_of_seconds(oscillator.longest_step(highest));
    let mut at = from;
    while at < until {
        let limit = longest.min(excitation.resolved_ticks()).min(excitation.smooth_ticks(at));
        let ticks = at.ticks_until(until, limit);
        let kernel = Kernel::new(oscillator, seconds_of_ticks(ticks));
        let response = excitation.response(at, ticks, &kernel);
        let (impulse, impulse_rate) = (kernel.step * kernel.impulse, S::ONE + kernel.impulse_rate);
        let [x, v] = *motion;
        *motion = [
            (impulse_rate + oscillator.damping * impulse) * x + impulse * v + response.displacement,
            impulse_rate * v - oscillator.stiffness * impulse * x + response.velocity,
        ];
        at = at.after(ticks);
    }
}

/// A number of 64 bits that changes with each bit of the values (FNV-1a).
pub(super) fn checksum(bits: impl Iterator<Item = u64>) -> u64 {
    bits.flat_map(u64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
