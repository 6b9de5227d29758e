//! The embedded core's sliding scene beside the independent reference and two other programs: scenes off the
//! shipped one, and motions with sticks.
//!
//! The other programs are not in this repository: TR-BDF2 with bisected events, and SciPy's Radau at a relative
//! tolerance of 10⁻⁹ with event location.

use std::sync::Arc;

use cross_crate_tests::{
    GRAVITY, adaptive, assert_close, assert_rows_within, on_all_cores, periods, reference,
    relative_difference, resistor, rough, rub, shown, sine, single, slide, sliding, value,
};
use host_bench::method::{Method, Options};
use host_bench::outcome::{Outcome, SlidingOutcome};
use host_bench::scene_file::{Excitation, ForceLaw, RunSpan, Scene, Sliding, StickCharge, Tone, Trace};

/// Samples of a sweep from 12 to 22 Hz, at 500 a second.
fn sweep() -> Excitation {
    let samples: Arc<[f64]> = (0..1501)
        .map(|index| {
            let time = f64::from(index) / 500.0;
            0.4 * GRAVITY * (std::f64::consts::TAU * (12.0 + 10.0 / 6.0 * time) * time).sin()
        })
        .collect();
    Excitation::File(Trace { samples_m_per_s2: samples, rate_hz: 500.0, repeat: false, resampled: None })
}

fn tone(amplitude_m_per_s2: f64, frequency_hz: f64, phase_rad: f64) -> Tone {
    Tone { amplitude_m_per_s2, frequency_hz, phase_rad }
}

type Change = fn(&mut Scene, &mut Sliding);

/// Scenes off the shipped one: each changes something, over 30 periods of its base unless it says so.
const SCENES: [(&str, Change); 15] = [
    ("a short stiff beam", |scene, model| {
        let beam = &mut model.parameters;
        (beam.beam_length_m, beam.beam_width_m, beam.beam_thickness_m) = (0.05, 8e-3, 0.3e-3);
        (beam.slider_mass_kg, beam.patch_radius_m) = (1e-3, 3e-3);
        (beam.dielectric_thickness_m, beam.relative_permittivity) = (25e-6, 3.5);
        scene.excitation = sine(0.4, beam.natural_frequency_hz());
        scene.load = resistor(1e7);
        scene.run = periods(beam.natural_frequency_hz(), 60, 20);
    }),
    ("a long soft beam", |scene, model| {
        let beam = &mut model.parameters;
        (beam.beam_length_m, beam.young_modulus_pa, beam.density_kg_per_m3) = (0.25, 70e9, 2700.0);
        (beam.beam_thickness_m, beam.damping_ratio) = (1.5e-3, 0.05);
        scene.excitation = sine(0.8, 11.0);
        scene.run = periods(11.0, 40, 20);
    }),
    ("a short circuit", |scene, _| scene.load = resistor(0.0)),
    ("1 Ω", |scene, _| scene.load = resistor(1.0)),
    ("10 kΩ", |scene, _| scene.load = resistor(1e4)),
    ("1 MΩ", |scene, _| scene.load = resistor(1e6)),
    ("10 GΩ", |scene, _| scene.load = resistor(1e10)),
    ("open, with a charge", |scene, model| {
        model.initial.charge_c = Some(5e-9);
        scene.load = resistor(f64::INFINITY);
    }),
    ("gap-field", |_, model| {
        model.parameters.force_law = ForceLaw::GapField;
        model.parameters.charge_density_c_per_m2 = 20e-6;
    }),
    ("gap-field, lateral force, relaxing, with sticks", |scene, model| {
        model.parameters.force_law = ForceLaw::GapField;
        model.parameters.charge_density_c_per_m2 = 20e-6;
        model.parameters.lateral_force = true;
        model.parameters.stick_charge = StickCharge::Relaxing;
        scene.excitation = sine(0.33, 10.0);
        scene.run = periods(10.0, 30, 10);
    }),
    ("lateral force of a strong charge", |scene, model| {
        model.parameters.lateral_force = true;
        model.parameters.charge_density_c_per_m2 = 120e-6;
        scene.load = resistor(3e7);
    }),
    ("two tones", |scene, _| {
        scene.excitation = Excitation::Sines(vec![tone(3.0, 18.0, 0.3), tone(1.2, 31.0, 1.0)]);
        scene.run = RunSpan { duration_s: 2.0, settle_s: 0.5 };
    }),
    ("a rough trace", |scene, _| {
        scene.excitation = rough(6.0);
        scene.run = RunSpan { duration_s: 1.5, settle_s: 0.3 };
    }),
    ("a sweep", |scene, model| {
        model.parameters.stick_charge = StickCharge::Relaxing;
        scene.excitation = sweep();
        scene.run = RunSpan { duration_s: 3.0, settle_s: 0.0 };
    }),
    ("let go off the middle", |scene, model| {
        rub(&mut model.parameters, 0.1);
        model.initial.position_m = Some(15e-3);
        model.initial.velocity_m_per_s = Some(-0.5);
        model.parameters.stick_charge = StickCharge::Relaxing;
        scene.excitation = Excitation::Silence;
        scene.run = RunSpan { duration_s: 0.8, settle_s: 0.0 };
    }),
];

fn scene((_, change): &(&str, Change)) -> Scene {
    sliding(|scene, model| {
        scene.run = periods(18.373, 30, 10);
        change(scene, model);
    })
}

/// What is compared: each relative to the reference's, the stick fraction to a whole.
fn differences(exact: &(Outcome, SlidingOutcome), scene: &Scene, options: &Options) -> [f64; 5] {
    let found = slide(scene, options);
    let sticks = value(found.1.stick_fraction) - value(exact.1.stick_fraction);
    [
        relative_difference(found.1.amplitude_m, exact.1.amplitude_m),
        relative_difference(found.1.peak_displacement_m, exact.1.peak_displacement_m),
        relative_difference(found.0.rms_voltage_v, exact.0.rms_voltage_v),
        relative_difference(found.0.mean_power_w, exact.0.mean_power_w),
        sticks.abs(),
    ]
}

/// At a tolerance of 1e-6 in double precision and of 1e-4 in single precision, every compared number is
/// within the bound; so it is of the explicit method, where the circuit lets it run.
#[test]
fn scenes_off_the_shipped_one_agree_with_the_reference() {
    let rows = on_all_cores(&SCENES, |row| {
        let scene = scene(row);
        let exact = slide(&scene, &reference());
        let explicit = Options { method: Method::Rk4, ..Options::default() };
        let mut rows = vec![
            ("f64", [2e-5; 5], differences(&exact, &scene, &adaptive(1e-6))),
            ("f32", [2e-3; 5], differences(&exact, &scene, &single(adaptive(1e-4)))),
        ];
        if !["1 Ω", "10 kΩ"].contains(&row.0) {
            rows.push(("explicit", [2e-6; 5], differences(&exact, &scene, &explicit)));
        }
        rows
    });
    assert_rows_within(&SCENES, &rows);
}

/// The error follows the tolerance.
#[test]
fn the_tolerance_bounds_the_error() {
    for resistance in [1e8, 1e6, 1e4] {
        let scene = sliding(|scene, _| {
            scene.load = resistor(resistance);
            scene.run = periods(18.373, 55, 20);
        });
        let exact = slide(&scene, &reference());
        for tolerance in [1e-3, 1e-4, 1e-5] {
            let found = differences(&exact, &scene, &adaptive(tolerance));
            println!("{resistance:e} Ω at {tolerance:e}: off by {}", shown(&found));
            assert!(found.iter().all(|off| *off <= 20.0 * tolerance), "{resistance:e} Ω: {}", shown(&found));
        }
    }
}

/// Two sticks in each period. Amplitudes with frozen charge are those of SciPy's Radau, all else that of the other
/// TR-BDF2.
#[test]
fn the_sticking_references_are_met() {
    use StickCharge::{Frozen, Relaxing};
    for (gravities, frequency, stick_charge, amplitude, stuck, voltage) in [
        (0.30, 6.0, Frozen, 0.188287e-3, 0.5405, 0.500),
        (0.30, 6.0, Relaxing, 0.18829e-3, 0.5405, 0.555),
        (0.30, 10.0, Frozen, 0.298331e-3, 0.2504, 1.021),
        (0.30, 10.0, Relaxing, 0.29833e-3, 0.2504, 1.099),
        (0.28, 14.0, Frozen, 0.321551e-3, 0.0345, 1.271),
        (0.28, 14.0, Relaxing, 0.32155e-3, 0.0345, 1.288),
    ] {
        let scene = sliding(|scene, model| {
            model.parameters.stick_charge = stick_charge;
            scene.excitation = sine(gravities, frequency);
            scene.run = periods(frequency, 60, 10);
        });
        // The relaxing rows are known to be the same to 1e-4, and the voltages to three digits.
        let digits = if stick_charge == Frozen { [4e-6, 1e-4] } else { [1e-4, 2e-4] };
        for (options, digits, scale) in [
            (reference(), digits[0], 1.0),
            (adaptive(1e-5), digits[1], 1.0),
            (single(adaptive(1e-4)), digits[1], 3.0),
        ] {
            let (outcome, motion) = slide(&scene, &options);
            let name = format!("{} {}, {frequency} Hz, {stick_charge:?}", outcome.method, outcome.precision);
            println!(
                "{name}: {:.6} mm, stuck {:.4}, {:.3} V",
                1e3 * value(motion.amplitude_m),
                value(motion.stick_fraction),
                value(outcome.rms_voltage_v)
            );
            assert_close(&format!("{name}: amplitude"), value(motion.amplitude_m), amplitude, scale * digits);
            assert_close(&format!("{name}: stuck"), value(motion.stick_fraction), stuck, scale * 2e-3);
            assert_close(&name, value(outcome.rms_voltage_v), voltage, scale * 1.1e-3);
            assert_close(&name, value(motion.sticks_per_period), 2.0, 1e-12);
        }
    }
}

/// A large motion by SciPy's Radau to seven digits, and peaks of the response by the other TR-BDF2, with fixed steps of
/// 1/400 to 1/800 of a period; that of the voltage taken over all frequencies.
#[test]
fn large_motions_have_their_known_amplitudes() {
    for (density, resistance, gravities, frequency, amplitude, voltage, digits) in [
        (120e-6, 1e8, 0.5, 18.33, 11.31623e-3, None, [2e-6, 5e-7]),
        (80e-6, 1e8, 0.36, 18.373_129_8 - 0.0145, 8.474e-3, Some(44.18), [1e-4, 1e-4]),
        (120e-6, 1e8, 0.36, 18.373_129_8 - 0.02277, 6.7224e-3, Some(50.056), [1e-4, 1e-4]),
        (120e-6, 0.0, 0.36, 18.373_129_8 - 0.00554, 7.1146e-3, None, [1e-4, 1e-4]),
    ] {
        let (settle, measured) = if gravities == 0.5 { (50, 10) } else { (290, 10) };
        let scene = sliding(|scene, model| {
            model.parameters.charge_density_c_per_m2 = density;
            scene.load = resistor(resistance);
            scene.excitation = sine(gravities, frequency);
            scene.run = periods(frequency, settle + measured, measured);
        });
        for (options, digits) in [adaptive(1e-6), reference()].into_iter().zip(digits) {
            let (outcome, motion) = slide(&scene, &options);
            let name = format!("σ = {density:e} C/m², {resistance:e} Ω, {frequency} Hz, {}", outcome.method);
            println!("{name}: {:.5} mm", 1e3 * value(motion.amplitude_m));
            assert_close(&name, value(motion.amplitude_m), amplitude, digits);
            assert_eq!((motion.stick_fraction, motion.sticks_per_period), (Some(0.0), Some(0.0)));
            if let Some(voltage) = voltage {
                assert_close(&name, value(outcome.rms_voltage_v), voltage, 3e-4);
            }
        }
    }
}
