//! The bump-stop scene: its variants.
//!
//! Four modes of the beam and one of the rod: the smallest numbers whose voltage is right to a few per cent.

use core::hint::black_box;

use model_core::hybrid::Work;
use model_core::part::load::Resistor;
use model_core::part::monomorph::Layer;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    BumpStop, Choices, Parameters, Parts, ResidualFlexibility, Resistive, Start, StateOf, StepDoubling,
    StepDoublingState, Stepper, Stop,
};

use super::run::{self, Building, Plan, Run};
use super::{Visit, Workload, show};

pub const BEAM_MODES: usize = 4;
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
    impacting(visit, whole(GAP), LONG)
}

/// [`CHECKED`]: the default scene with the estimate of the error of its steps, which takes 6 kB of RAM.
pub fn checked(visit: Visit<'_>) -> Option<()> {
    show(visit, run_checked())
}

#[inline(never)]
fn run_checked() -> Option<impl Workload> {
    let scene: BumpStop<f32, Whole, BEAM_MODES, ROD_MODES> = black_box(whole(GAP)).build().ok()?;
    let stepper = Stepper::new(scene, black_box(SHORT), black_box(LONG)).ok()?;
    let checked = StepDoubling::new(stepper, black_box(CHECKED_EVERY));
    Run::new(CHECKED, checked, &Start::default(), with_statement)
}

type OfWhole = StateOf<f32, Whole, BEAM_MODES, ROD_MODES>;

/// As [`run::piezoelectric`], without the last two words; then the stated error of the steps, relative, and the part of the
/// time in which the motion is irregular.
fn with_statement(
    checked: &StepDoubling<f32, Whole, BEAM_MODES, ROD_MODES>,
    state: &StepDoublingState<f32, OfWhole>,
    delivered: f32,
    work: Work,
    words: &mut [u32; 8],
) {
    run::piezoelectric(checked.stepper(), state.run(), delivered, work, words);
    let [.., relative, irregular] = words;
    let stated = checked.step_doubling_error(state);
    *relative = stated.map_or(f32::INFINITY, |stated| stated.relative).to_bits();
    *irregular = stated.map_or(f32::INFINITY, |stated| stated.irregular).to_bits();
}

/// [`TOUCHING`], and the build of the coefficients, the compliance of the modes left out included.
pub fn others(visit: Visit<'_>) -> Option<()> {
    show(visit, run::<_, BEAM_MODES, ROD_MODES>(TOUCHING, whole(0.0), TOUCHING_STEPS))?;
    visit(&mut Building::new("bump-stop-build", || {
        let scene: BumpStop<f32, _, BEAM_MODES, ROD_MODES> = black_box(whole(GAP)).build().ok()?;
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
            show(visit, run::<_, BEAM_MODES, ROD_MODES>(SETTLING, whole(gap), steps))?;
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

/// The load of the default scene.
pub const LOAD: Resistor<f32> = Resistor { resistance: 1e6 };
/// Distance of beam and rod at rest in the default scene, in m.
pub const GAP: f32 = 10e-6;

/// 50 mm × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A.
#[must_use]
pub fn parameters<C>(choices: C) -> Parameters<f32, C> {
    Parameters {
        beam_length: 50e-3,
        beam_width: 10e-3,
        substrate: Layer { thickness: 0.5e-3, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 0.5e-3, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01,
        choices,
    }
}

/// An aluminium rod of 20 mm × 2 mm × 2 mm, `gap` metres from the beam's tip.
#[must_use]
pub fn stop(gap: f32) -> Stop<f32> {
    Stop {
        length: 20e-3,
        section: 4e-6,
        young_modulus: 70e9,
        density: 2700.0,
        position: 50e-3,
        gap,
        contact_compliance: 0.0,
        contact: ResidualFlexibility,
    }
}

/// What the default scene is made of.
pub type Whole = Choices<Resistive<Resistor<f32>>, Stop<f32>>;

/// The default scene with a gap of its own.
#[must_use]
pub fn whole(gap: f32) -> Parameters<f32, Whole> {
    parameters(Choices::new(LOAD).stop(stop(gap)))
}
