//! The vibration modes of the beams that a scene file describes: for the checks of the reader, the reference
//! and the peers.

mod bump_stop;
mod cantilever;

pub use self::bump_stop::BumpStopModes;
pub use self::cantilever::Cantilever;

/// Means of a function and of its square from 0 to 1: the Gauss-Legendre rule of five points on `pieces` equal pieces.
pub(super) fn means(pieces: u32, of: impl Fn(f64) -> f64) -> [f64; 2] {
    let root = (10f64 / 7.0).sqrt();
    let [inner, outer] = [(5.0 - 2.0 * root).sqrt() / 3.0, (5.0 + 2.0 * root).sqrt() / 3.0];
    let [near, far] = [(322.0 + 13.0 * 70f64.sqrt()) / 900.0, (322.0 - 13.0 * 70f64.sqrt()) / 900.0];
    let points = [(-outer, far), (-inner, near), (0.0, 128.0 / 225.0), (inner, near), (outer, far)];
    let mut means = [0.0, 0.0];
    for piece in 0..pieces {
        for (abscissa, weight) in points {
            let value = of((f64::from(piece) + 0.5 + 0.5 * abscissa) / f64::from(pieces));
            let weight = 0.5 * weight / f64::from(pieces);
            means[0] += weight * value;
            means[1] += weight * value * value;
        }
    }
    means
}
