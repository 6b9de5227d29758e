use super::super::{AnyChoices, AnyContact, AnyCoupling, Stepper, Stop};
use super::*;
use crate::excitation::Silence;
use crate::part::load::AnyLoad;
use crate::part::monomorph::Layer;
use crate::scene::Harvester;
use crate::scene::bump_stop::{Resistive, Start};

const LENGTH: f64 = 50e-3;
/// Steel and PZT-5A, 10 mm wide and 0.5 mm thick each.
const RIGIDITY: f64 = 0.089_738_408_5;
const MASS_PER_LENGTH: f64 = 0.078_25;
const COUPLING: f64 = 4.714_285_71e-5;

fn parameters(position: f64, coupling: AnyCoupling) -> Parameters<f64, AnyChoices<f64>> {
    let layer = |young_modulus, density| Layer { thickness: 0.5e-3, young_modulus, density };
    Parameters {
        beam_length: LENGTH,
        beam_width: 10e-3,
        substrate: layer(200e9, 7850.0),
        piezo: layer(66e9, 7800.0),
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.0,
        choices: Choices {
            load: Resistive(AnyLoad { resistance: 0.0 }),
            stop: Stop {
                length: 20e-3,
                section: 4e-6,
                young_modulus: 70e9,
                density: 2700.0,
                position,
                gap: 1e-3,
                contact_compliance: 0.0,
                contact: AnyContact::ResidualFlexibility,
            },
            coupling,
            tip_mass: None,
            transducer: None,
        },
    }
}

/// The beam at rest under a force at the stop, a base acceleration and a voltage has the curvature of a cantilever under
/// a point force, a uniform load and a moment at its tip, whatever the number of modes.
#[test]
fn static_loads_bend_the_clamp_as_a_cantilever() {
    for modes in [1, 2, 4, 10] {
        for position in [LENGTH, 0.5 * LENGTH] {
            let parameters = parameters(position, AnyCoupling::TwoWay);
            let bending: ClampBending<f64, 10> =
                parameters.clamp_bending::<10, 4>(modes, 2).expect("in bounds");
            let harvester: BumpStop<f64, _, 10, 4> = parameters.build_first(modes, 2).expect("in bounds");
            let (force, acceleration, voltage) = (1.5, 30.0, 4.0);
            for [f, a, v] in [[force, 0.0, 0.0], [0.0, acceleration, 0.0], [0.0, 0.0, voltage]] {
                let mut state = [0.0; 20];
                for (mode, at) in harvester.beam.iter().zip(state.iter_mut().step_by(2)) {
                    let load = mode.contact * f + mode.base * a + mode.voltage * v;
                    *at = -load / (mode.angular_frequency * mode.angular_frequency);
                }
                let expected =
                    -(f * position + a * 0.5 * MASS_PER_LENGTH * LENGTH * LENGTH + v * COUPLING) / RIGIDITY;
                let found = bending.curvature(&state, f, a, v);
                assert!(
                    (found / expected - 1.0).abs() < 1e-7,
                    "{modes} modes: {found} instead of {expected}"
                );
            }
        }
    }
}

/// The sum over the modes alone has these curvatures to what the omitted modes contribute.
#[test]
fn ten_modes_lack_little_of_the_static_curvature() {
    let bending: ClampBending<f64, 10> =
        parameters(LENGTH, AnyCoupling::TwoWay).clamp_bending::<10, 4>(10, 2).expect("in bounds");
    let lacking = [
        (bending.force, LENGTH),
        (bending.base, 0.5 * MASS_PER_LENGTH * LENGTH * LENGTH),
        (bending.voltage, COUPLING),
    ]
    .map(|(omitted, all)| (omitted * RIGIDITY / all).abs());
    assert!(lacking[0] < 3e-3 && lacking[1] < 2e-3 && lacking[2] < 8e-2, "{lacking:?}");
    let one_way: ClampBending<f64, 10> =
        parameters(LENGTH, AnyCoupling::OneWay).clamp_bending::<10, 4>(10, 2).expect("in bounds");
    assert_eq!(one_way.voltage, 0.0);
}

/// The free vibration of the first mode: `y''(0) = 2 λ² r/(L² √m_b)`, with λ = 1.8751; peak over RMS is √2.
#[test]
fn the_first_mode_has_its_closed_form() {
    let parameters = parameters(LENGTH, AnyCoupling::OneWay);
    let bending: ClampBending<f64, 4> = parameters.clamp_bending::<4, 2>(4, 2).expect("in bounds");
    let harvester: BumpStop<f64, _, 4, 2> = parameters.build_first(4, 2).expect("in bounds");
    let stepper = Stepper::new(harvester, 1e-6, 2e-5).expect("steps in bounds");
    let mut start = Start::default();
    start.beam[0] = [1e-7, 0.0];
    let mut state = stepper.start(&start, &Silence).expect("in bounds");
    let mut meter = ClampMeter::new(bending, Silence);
    // 48 periods of 239.705 Hz.
    let until = Instant::from_seconds(48.0 / 239.705_436).expect("in range");
    while state.clock < until {
        stepper.advance(&mut state, &Silence, until, 1 << 12, &mut meter).expect("it can be stepped");
    }
    let lambda = 1.875_104_07_f64;
    let expected = 2.0 * lambda * lambda * 1e-7 / (LENGTH * LENGTH * (MASS_PER_LENGTH * LENGTH).sqrt());
    let (peak, rms) = (meter.curvature().magnitude(), meter.rms_curvature());
    assert!((peak / expected - 1.0).abs() < 1e-3, "{peak} instead of {expected}");
    assert!((rms * core::f64::consts::SQRT_2 / expected - 1.0).abs() < 1e-3, "{rms} of {expected}");
    let steel = bending.substrate;
    assert!((steel.stress(peak) / (200e9 * 0.374_060_150e-3 * expected) - 1.0).abs() < 1e-3);
    assert!((bending.piezo.strain(peak) / (0.625_939_850e-3 * expected) - 1.0).abs() < 1e-3);
}
