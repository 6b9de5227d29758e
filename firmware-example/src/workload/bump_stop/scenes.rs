//! The workloads of each binary. The host calls these very functions.
//!
//! Four modes of the beam and one of the rod: the smallest numbers whose voltage is right to a few per cent.

use model_core::part::load::OpenCircuit;
use model_core::scene::bump_stop::{Choices, OneWay};

use super::building::Building;
use super::modal_run::{ModalRun, Plan};
use super::parts::{self, GAP, LOAD};
use crate::workload::Workload;

/// Modes of the beam.
pub const BEAM_MODES: usize = 4;
/// Modes of the rod.
pub const ROD_MODES: usize = 1;

/// 20 m/s² at 220 Hz, below the first natural frequency of 239.7 Hz. Two seconds from rest, of which the
/// last one and a half are settled.
pub const IMPACTING: Plan =
    Plan { name: "bump-stop", amplitude: 20.0, frequency: 220.0, short: SHORT, long: LONG, halves: 4 };
/// The same with the rod touching the beam at rest.
pub const TOUCHING: Plan = Plan { name: "touching", ..IMPACTING };
/// Four seconds, as weak chaos needs for its averages.
pub const SETTLING: Plan = Plan { name: "settling", halves: 8, ..IMPACTING };

/// Step near contact in seconds: a contact lasts some 20 µs.
pub const SHORT: f32 = 9e-6;
/// Step in free flight in seconds.
pub const LONG: f32 = 80e-6;

/// The workload of most binaries.
type Run<P> = ModalRun<P, BEAM_MODES, ROD_MODES>;

/// The default scene, as `bump_stop` runs it.
#[must_use]
pub fn bench() -> Option<impl Workload> {
    Run::new(IMPACTING, parts::whole(GAP))
}

/// The default scene without the stop, and without the rod.
#[must_use]
pub fn without_stop() -> Option<impl Workload> {
    ModalRun::<_, BEAM_MODES, 0>::new(IMPACTING, parts::parameters(Choices::new(LOAD)))
}

/// The default scene without the voltage acting back on the beam.
#[must_use]
pub fn one_way() -> Option<impl Workload> {
    let choices = Choices::new(LOAD).stop(parts::stop(GAP)).coupling(OneWay);
    Run::new(IMPACTING, parts::parameters(choices))
}

/// The default scene with the load open.
#[must_use]
pub fn open() -> Option<impl Workload> {
    Run::new(IMPACTING, parts::parameters(Choices::new(OpenCircuit).stop(parts::stop(GAP))))
}

/// The default scene with the short step only.
#[must_use]
pub fn single_rate() -> Option<impl Workload> {
    Run::new(Plan { long: SHORT, ..IMPACTING }, parts::whole(GAP))
}

/// Gives `work` what the bench leaves out, to compare its bits: the rod touching the beam at rest, and the
/// making of the coefficients; `None` if one is refused.
pub fn with_others<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let Some(mut touching) = Run::new(TOUCHING, parts::whole(0.0)) else { return work(None) };
    work(Some(&mut [&mut touching, &mut Building::default()]))
}

/// Distances of beam and rod at rest of [`with_precision`], in m.
pub const GAPS: [f32; 2] = [0.0, GAP];
/// Short and long steps of [`with_precision`], in seconds.
pub const STEPS: [[f32; 2]; 7] = [
    [6e-6, 60e-6],
    [8e-6, 50e-6],
    [9e-6, 50e-6],
    [9e-6, 60e-6],
    [SHORT, LONG],
    [12e-6, 60e-6],
    [SHORT, SHORT],
];

/// Gives `work` the scene over four seconds with each of [`STEPS`], first the one and then the other of
/// [`GAPS`]; `None` if one is refused.
pub fn with_precision<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let mut runs = GAPS
        .map(|gap| STEPS.map(|[short, long]| Run::new(Plan { short, long, ..SETTLING }, parts::whole(gap))));
    let [
        [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f), Some(g)],
        [Some(h), Some(i), Some(j), Some(k), Some(l), Some(m), Some(n)],
    ] = &mut runs
    else {
        return work(None);
    };
    work(Some(&mut [a, b, c, d, e, f, g, h, i, j, k, l, m, n]))
}
