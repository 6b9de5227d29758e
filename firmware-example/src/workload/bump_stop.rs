//! The bump-stop scene: its variants.
//!
//! Four modes of the beam and one of the rod: the smallest numbers whose voltage is right to a few per cent.

pub mod parts;

use core::hint::black_box;

use model_core::hybrid::Work;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    BumpStop, Checked, CheckedState, Parameters, Parts, Start, StateOf, Stepper,
};

use self::parts::{GAP, Whole};
use super::building::Building;
use super::run::{self, Plan, Run};
use super::{Visit, Workload, show};

/// Modes of the beam.
pub const BEAM_MODES: usize = 4;
/// Modes of the rod.
pub const ROD_MODES: usize = 1;

/// 20 m/s² at 220 Hz, below the first natural frequency of 239.7 Hz. Two seconds from rest, of which the
/// last one and a half are settled.
pub const IMPACTING: Plan =
    Plan { name: "bump-stop", amplitude: 20.0, frequency: 220.0, velocity: 0.0, quarters: 2, samples: 4 };
/// The same with the rod touching the beam at rest.
pub const TOUCHING: Plan = Plan { name: "touching", ..IMPACTING };
/// The same with the estimate of the error of its steps.
pub const CHECKED: Plan = Plan { name: "checked", ..IMPACTING };
/// Four seconds, as weak chaos needs for its averages.
pub const SETTLING: Plan = Plan { name: "settling", samples: 8, ..IMPACTING };

/// Step near contact in seconds: a contact lasts some 30 µs.
pub const SHORT: f32 = 13e-6;
/// Step in free flight in seconds.
pub const LONG: f32 = 180e-6;
/// Inverse of the part of the time in which [`checked`] checks its steps.
pub const CHECKED_EVERY: u32 = 128;
/// The same for [`TOUCHING`]: beam and rod touch in every half period, and longer steps lose 3 % of the mean power.
pub const TOUCHING_STEPS: [f32; 2] = [9e-6, 80e-6];
/// Distances of beam and rod at rest of [`precision`], in m.
pub const GAPS: [f32; 2] = [0.0, GAP];
/// Short and long steps of [`precision`], in seconds.
pub const STEPS: [[f32; 2]; 7] = [
    [6e-6, 60e-6],
    [9e-6, 80e-6],
    [12e-6, 96e-6],
    [12e-6, 120e-6],
    [SHORT, LONG],
    [16e-6, 128e-6],
    [SHORT, SHORT],
];

/// The default scene.
pub fn bench(visit: Visit<'_>) -> Option<()> {
    impacting(visit, parts::whole(GAP), LONG)
}

/// [`CHECKED`]: the default scene with the estimate of the error of its steps, which takes 6 kB of RAM.
pub fn checked(visit: Visit<'_>) -> Option<()> {
    show(visit, run_checked())
}

#[inline(never)]
fn run_checked() -> Option<impl Workload> {
    let scene: BumpStop<f32, Whole, BEAM_MODES, ROD_MODES> = black_box(parts::whole(GAP)).build().ok()?;
    let stepper = Stepper::new(scene, black_box(SHORT), black_box(LONG)).ok()?;
    let checked = Checked::new(stepper, black_box(CHECKED_EVERY));
    Run::new(CHECKED, checked, &Start::default(), with_statement)
}

type OfWhole = StateOf<f32, Whole, BEAM_MODES, ROD_MODES>;

/// As [`run::piezoelectric`], without the last two words; then the stated error of the steps, relative, and the part of the
/// time in which the motion is irregular.
fn with_statement(
    checked: &Checked<f32, Whole, BEAM_MODES, ROD_MODES>,
    state: &CheckedState<f32, OfWhole>,
    delivered: f32,
    work: Work,
    words: &mut [u32; 8],
) {
    run::piezoelectric(checked.stepper(), state.run(), delivered, work, words);
    let [.., relative, irregular] = words;
    let stated = checked.checked_error(state);
    *relative = stated.map_or(f32::INFINITY, |stated| stated.relative).to_bits();
    *irregular = stated.map_or(f32::INFINITY, |stated| stated.irregular).to_bits();
}

/// [`TOUCHING`], and the build of the coefficients, the compliance of the modes left out included.
pub fn others(visit: Visit<'_>) -> Option<()> {
    show(visit, run::<_, BEAM_MODES, ROD_MODES>(TOUCHING, parts::whole(0.0), TOUCHING_STEPS))?;
    visit(&mut Building::new("bump-stop-build", || {
        let scene: BumpStop<f32, _, BEAM_MODES, ROD_MODES> = black_box(parts::whole(GAP)).build().ok()?;
        let scene = black_box(scene);
        Some([
            scene.beam_angular_frequency(0).unwrap_or_default(),
            scene.beam_angular_frequency(BEAM_MODES - 1).unwrap_or_default(),
            scene.rod_angular_frequency(0).unwrap_or_default(),
            scene.contact_stiffness(),
        ])
    }));
    Some(())
}

/// [`SETTLING`] with each of [`GAPS`], and for each gap with each of [`STEPS`].
pub fn precision(visit: Visit<'_>) -> Option<()> {
    for gap in GAPS {
        for steps in STEPS {
            show(visit, run::<_, BEAM_MODES, ROD_MODES>(SETTLING, parts::whole(gap), steps))?;
        }
    }
    Some(())
}

#[inline]
fn impacting<P: Parts<f32>>(visit: Visit<'_>, parameters: Parameters<f32, P>, long: f32) -> Option<()> {
    show(visit, run::<_, BEAM_MODES, ROD_MODES>(IMPACTING, parameters, [SHORT, long]))
}

/// A run of `parameters` with a short and a long step in seconds; `None` if something is refused.
#[must_use]
#[inline(never)]
pub fn run<P: Parts<f32>, const B: usize, const R: usize>(
    plan: Plan,
    parameters: Parameters<f32, P>,
    [short, long]: [f32; 2],
) -> Option<impl Workload> {
    let scene: BumpStop<f32, P, B, R> = black_box(parameters).build().ok()?;
    let stepper = Stepper::new(scene, black_box(short), black_box(long)).ok()?;
    Run::new(plan, stepper, &Start::default(), run::piezoelectric)
}
