// Made by `host-bench needs host-bench/scenes/contact-separation-passive.toml --accuracy 1e-2 --emit contact_separation.rs`.
//
// Left out: sticking, restitution by speed (0.753 instead), electrostatic force.

use model_core::excitation::Sine;
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::force_law::NoForce;
use model_core::part::load::Resistor;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::ConstantRestitution;
use model_core::part::stick_charge::NeverSticks;
use model_core::scene::Simulation;
use model_core::scene::contact_separation::{Choices, ContactSeparation, Parameters, Start};

/// Mean power of the full scene in W, in double precision.
pub const MEAN_POWER: f32 = 1.174873e-5;
/// Relative accuracy to which this module holds it.
pub const ACCURACY: f32 = 0.01;
/// Start and end of the window of the mean power in ticks of the clock.
pub const WINDOW_TICKS: [u64; 2] = [2681735677502, 4022603516254];

/// The parts that the scene needs.
pub type Parts = Choices<Resistor<f32>, ConstantRestitution<f32>, NoForce, ParasiticCapacitance<f32>, NeverSticks>;

/// The harvester.
pub type Model = Simulation<ContactSeparation<f32, Parts>, ExponentialRadau, Adaptive<f32>, 3, 1>;

/// Its parameters in SI units.
pub const PARAMETERS: Parameters<f32, Parts> = Parameters {
    mass: 0.005,
    stiffness: 80.0,
    damping_ratio: 0.005,
    initial_gap: 0.003,
    electrode_area: 0.0004,
    dielectric_thickness: 5e-5,
    relative_permittivity: 2.0,
    charge_density: 5e-5,
    choices: Choices {
        load: Resistor { resistance: 100000000.0 },
        restitution: ConstantRestitution { coefficient: 0.7527891 },
        force_law: NoForce,
        parasitic: ParasiticCapacitance { capacitance: 1e-12 },
        sticking: NeverSticks,
    },
};

/// The harvester; `None` if a parameter is refused.
pub fn harvester() -> Option<Model> {
    let scene = PARAMETERS.build().ok()?;
    Some(Simulation::new(scene, ExponentialRadau, Adaptive::new(0.02).ok()?))
}

/// Its initial values.
pub fn start() -> Start<f32> {
    Start { ..Start::default() }
}

/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<Sine<f32>> {
    Sine::new(1.962, 20.5, 0.0).ok()
}

#[cfg(test)]
mod tests {
    use model_core::clock::{Instant, TICKS_PER_SECOND};
    use model_core::energy::PowerMeter;
    use model_core::scene::Harvester;

    use super::{ACCURACY, MEAN_POWER, WINDOW_TICKS, excitation, harvester, start};

    #[test]
    fn the_mean_power_is_that_of_the_full_scene() {
        let (Some(harvester), Some(excitation)) = (harvester(), excitation()) else { panic!("refused") };
        let mut state = harvester.start(&start(), &excitation).expect("starts");
        let mut meter = PowerMeter::new();
        for ticks in WINDOW_TICKS {
            meter = PowerMeter::new();
            let until = Instant::from_ticks(ticks);
            let advance = harvester.advance(&mut state, &excitation, until, u32::MAX, &mut meter);
            assert!(advance.is_ok());
        }
        let [settled, end] = WINDOW_TICKS;
        let seconds = (end - settled) as f32 / TICKS_PER_SECOND as f32;
        let change = meter.delivered_energy() / seconds / MEAN_POWER - 1.0;
        assert!(change.abs() <= ACCURACY, "{change}");
    }
}
