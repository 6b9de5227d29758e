//! What a harvester delivers minute by minute, as the days of a node need it: trajectories of the full model over ten minutes.

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::AnyExcitation;
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::scalar::Polynomial;
use model_core::scene::bump_stop::Stepper;
use model_core::scene::{Harvester, Simulation};

use super::{bump_stop_parameters, contact_separation_parameters, sliding_parameters};
use harvester_scene::method::Failure;
use harvester_scene::scene_file::{Load, Scene};

/// Sines of a random acceleration.
pub const LINES: usize = 200;

/// Relative tolerance of the trajectories.
const TOLERANCE: f64 = 1e-3;

/// The acceleration of the base in a minute.
pub type Vibration = AnyExcitation<'static, f64, LINES>;

/// By what factors the true harvester differs from that of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Of charge density, or of the piezoelectric coefficient: the output power goes with its square.
    pub charge: f64,
    pub damping: f64,
    pub resistance: f64,
    pub resonance: f64,
}

impl Deviation {
    /// As designed.
    pub const NONE: Self = Self { charge: 1.0, damping: 1.0, resistance: 1.0, resonance: 1.0 };
}

/// Energies in J that the harvester of a scene with a resistor delivers in each minute, under the vibration of that minute. `off` says at
/// each tenth minute by how much it differs from the scene. A beam has its first mode only, whose share of the power near the resonance
/// is all but 10⁻³.
///
/// # Errors
/// If there is another load or a stop, the parameters are refused, or a step fails.
pub fn energies_by_minute(
    scene: &Scene,
    vibration: &[Vibration],
    off: &dyn Fn(usize) -> Deviation,
) -> Result<Vec<f64>, Failure> {
    if !matches!(scene.load, Load::Resistor { .. })
        || scene.bump_stop().is_ok_and(|model| model.stop.is_some())
    {
        return Err(Failure::of_file(scene, "load.kind must be \"resistor\", and [stop] absent".to_owned()));
    }
    let load = scene.load;
    let adaptive = Adaptive::new(TOLERANCE).map_err(fail)?;
    // The two are off alike, but for what makes their stiffness.
    macro_rules! triboelectric {
        ($parameters:expr, $stiffness:ident) => {
            energies(vibration, off, |Deviation { charge, damping, resistance, resonance }| {
                let mut with = $parameters;
                with.$stiffness *= resonance * resonance;
                with.damping_ratio *= damping;
                with.charge_density *= charge;
                with.choices.load.resistance *= resistance;
                Ok(Simulation::new(with.build().map_err(fail)?, ExponentialRadau, adaptive))
            })
        };
    }
    if let Ok(model) = scene.contact_separation() {
        return triboelectric!(contact_separation_parameters::<f64, Polynomial>(model, load), stiffness);
    }
    if let Ok(model) = scene.sliding() {
        return triboelectric!(sliding_parameters::<f64>(model, load), young_modulus);
    }
    let model = scene.bump_stop()?;
    energies(vibration, off, |Deviation { charge, damping, resistance, resonance }| {
        let mut with = bump_stop_parameters::<f64>(model, load);
        with.substrate.young_modulus *= resonance * resonance;
        with.piezo.young_modulus *= resonance * resonance;
        with.damping_ratio *= damping;
        with.piezo_d31 *= charge;
        with.choices.load.0.resistance *= resistance;
        Stepper::new(with.build::<1, 0>().map_err(fail)?, 1e-4, 2e-4).map_err(fail)
    })
}

fn fail(error: impl std::fmt::Display) -> Failure {
    Failure::Step(error.to_string())
}

/// Each ten minutes the harvester is another one, at rest. The same ten minutes give the same.
fn energies<H: Harvester<f64>>(
    vibration: &[Vibration],
    off: &dyn Fn(usize) -> Deviation,
    harvester: impl Fn(Deviation) -> Result<H, Failure>,
) -> Result<Vec<f64>, Failure> {
    let mut energies = Vec::new();
    for (part, chunk) in vibration.chunks(10).enumerate() {
        let is_same = |other: &usize| {
            off(10 * other) == off(10 * part) && vibration[10 * other..][..chunk.len()] == *chunk
        };
        if let Some(same) = (0..part).find(is_same) {
            energies.extend_from_within(10 * same..10 * same + chunk.len());
            continue;
        }
        let harvester = harvester(off(10 * part))?;
        let mut state = harvester.start(&H::Start::default(), &chunk[0]).map_err(fail)?;
        for (index, vibration) in chunk.iter().enumerate() {
            let mut meter = PowerMeter::new();
            let end = Instant::from_whole_seconds(60 * (index as u32 + 1));
            harvester.advance(&mut state, vibration, end, u32::MAX, &mut meter).map_err(fail)?;
            energies.push(meter.delivered_energy());
        }
    }
    Ok(energies)
}
