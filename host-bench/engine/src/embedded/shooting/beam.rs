//! Shooting for bump-stop: modal coordinates of beam and rod, and the charge through the load.

use std::f64::consts::TAU;

use model_core::scene::Harvester as _;
use model_core::scene::bump_stop::{AnyChoices, BumpStop as Harvester, Circuit, Parts, StateOf, Stepper};

use super::super::bump_stop::{METHOD, begun, by_modes, resistance};
use super::super::excitation::{Setting, bridge};
use super::super::run::{Run, refuse_start};
use super::{Kind, Memory, follow, remembered};
use crate::steady_state::{Coordinates, Orbit, Response, Spent};
use harvester_scene::method::Failure;
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::{BumpStop, Excitation, Load, Scene};

/// Instants of a period at which the extremes of the coordinates are taken.
const WATCHED_INSTANTS: u32 = 64;

impl<P: Parts<f64>, const B: usize, const R: usize, const ALL: usize> Coordinates
    for Stepper<f64, P, B, R, ALL>
{
    const PARTS: u32 = WATCHED_INSTANTS;

    /// Displacement and velocity of each mode, the beam's first, then the charge through the load. With an open circuit the
    /// charge is constant, with a short circuit it is that of the strain.
    fn coordinates(&self, state: &Self::State) -> Vec<f64> {
        let charge = self.outputs(state).charge.value;
        let modes = state.beam.as_flattened().iter().chain(state.rod.as_flattened());
        modes.chain([&charge]).copied().collect()
    }

    fn at(&self, pattern: &Self::State, coordinates: &[f64], acceleration: f64) -> Option<Self::State> {
        let (beam, rest) = coordinates.split_at_checked(2 * B)?;
        let (rod, charge) = rest.split_at_checked(2 * R)?;
        let beam = beam.as_chunks().0.try_into().ok()?;
        let rod = rod.as_chunks().0.try_into().ok()?;
        self.scene().moved(pattern, beam, rod, *charge.first()?, acceleration)
    }

    fn is_like(&self, one: &Self::State, other: &Self::State) -> bool {
        self.outputs(one).mode == self.outputs(other).mode
    }
}

/// A bump-stop scene with the circuit `L`, on the core's harvester for up to `B` and `R` modes.
struct Beam<'a, L: Circuit<f64>, const B: usize, const R: usize> {
    model: &'a BumpStop,
    /// The circuit of a load of the kind of the scene's.
    circuit: fn(Load) -> Option<L>,
    known: Option<Orbit<StateOf<f64, AnyChoices<f64, L>, B, R>>>,
}

/// The kind of a bump-stop scene, by its load and its numbers of modes.
pub(super) fn beam<'a>(scene: &Scene, model: &'a BumpStop) -> Box<dyn Kind + 'a> {
    match scene.load {
        Load::Resistor { .. } => by_modes!(model, boxed::<_>(model, |load| Some(resistance(load)))),
        Load::RectifiedStore(_) | Load::DcBus { .. } => by_modes!(model, boxed::<_>(model, bridge)),
    }
}

fn boxed<'a, L: Circuit<f64, State: Send + Sync> + 'static, const B: usize, const R: usize>(
    model: &'a BumpStop,
    circuit: fn(Load) -> Option<L>,
) -> Box<dyn Kind + 'a> {
    Box::new(Beam::<L, B, R> { model, circuit, known: None })
}

/// A stepper with all powers, its state at the start, and the sizes of its coordinates.
type Begun<L, const B: usize, const R: usize> =
    (Stepper<f64, AnyChoices<f64, L>, B, R, 1>, StateOf<f64, AnyChoices<f64, L>, B, R>, Vec<f64>);

impl<L: Circuit<f64>, const B: usize, const R: usize> Beam<'_, L, B, R> {
    fn begun(&self, setting: &Setting<'_, f64>) -> Result<Begun<L, B, R>, Failure> {
        let Setting { scene, options, excitation, .. } = *setting;
        let circuit = (self.circuit)(scene.load)
            .ok_or_else(|| Failure::of_file(scene, "load.kind: must stay the same in a search"))?;
        let (stepper, start) = begun::<f64, L, B, R>((scene, self.model, options), circuit)?;
        let typical = typical(stepper.scene(), self.model, setting);
        let state = stepper.start(&start, &excitation).map_err(|error| refuse_start(scene, &error))?;
        Ok((stepper, state, typical))
    }
}

/// Amplification of the base's velocity in a wide motion.
const AMPLIFICATION: f64 = 10.0;

/// The sizes of the coordinates in a wide motion: each mode and the charge with the energy of the beam at the amplified
/// velocity of the base.
fn typical<P: Parts<f64>, const B: usize, const R: usize>(
    harvester: &Harvester<f64, P, B, R>,
    model: &BumpStop,
    setting: &Setting<'_, f64>,
) -> Vec<f64> {
    let from = &model.parameters;
    let per_area = from.substrate_thickness_m * from.substrate_density_kg_per_m3
        + from.layers()[0] * from.piezo_thickness_m * from.piezo_density_kg_per_m3;
    let body = from.tip_mass.map_or(0.0, |body| body.mass_kg);
    let mass = per_area * from.beam_width_m * from.beam_length_m + body;
    let base = match &setting.scene.excitation {
        Excitation::Sine(tone) => tone.amplitude_m_per_s2 / (TAU * tone.frequency_hz),
        _ => 0.0,
    };
    // Without excitation any size serves.
    let rate = mass.sqrt() * if base > 0.0 { AMPLIFICATION * base } else { 1.0 };
    let beam = (0..B).map(|i| harvester.beam_angular_frequency(i));
    let rod = (0..R).map(|j| harvester.rod_angular_frequency(j));
    let modes = beam.chain(rod).flat_map(|omega| [rate / omega.unwrap_or(1.0).max(f64::MIN_POSITIVE), rate]);
    modes.chain([rate * harvester.capacitance().sqrt()]).collect()
}

impl<L: Circuit<f64, State: Send + Sync> + 'static, const B: usize, const R: usize> Kind
    for Beam<'_, L, B, R>
{
    fn resume(
        &self,
        setting: Setting<'_, f64>,
        memory: Option<&Memory>,
    ) -> Result<(Outcome, Memory), Failure> {
        let (stepper, state, typical) = self.begun(&setting)?;
        remembered(&run(&stepper, self.model, setting), state, &typical, memory)
    }

    fn follow(&mut self, setting: Setting<'_, f64>, spent: &mut Spent) -> Result<Option<Response>, Failure> {
        let (stepper, state, typical) = self.begun(&setting)?;
        follow(&run(&stepper, self.model, setting), state, &typical, &mut self.known, spent)
    }
}

fn run<'a, H>(harvester: &'a H, model: &'a BumpStop, setting: Setting<'a, f64>) -> Run<'a, f64, H, BumpStop> {
    Run { setting, harvester, report: model, method: METHOD }
}
