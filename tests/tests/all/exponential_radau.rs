//! Exponential Radau beside the independent reference: every load, force law, excitation and stick of the
//! contact-separation scene. Sliding scenes are in `sliding_agreement`, bridges in `rectified`.

use cross_crate_tests::{
    adaptive, assert_rows_within, contact_separation, on_all_cores, periods, reference, relative_difference,
    resistor, rough, run, sine, single, value,
};
use host_bench::method::{Method, Options};
use host_bench::outcome::{ContactSeparationOutcome, Outcome};
use host_bench::scene_file::{
    ContactSeparation, Excitation, ForceLaw, Restitution, RunSpan, Scene, StickCharge, Tone,
};

fn by_the_method(options: Options) -> Options {
    Options { method: Method::ExponentialRadau, ..options }
}

fn tone(amplitude_m_per_s2: f64, frequency_hz: f64) -> Tone {
    Tone { amplitude_m_per_s2, frequency_hz, phase_rad: 0.3 }
}

/// Inelastic impacts of a mass that a slow tone pushes onto the dielectric: it sticks and is released.
fn sticks(scene: &mut Scene, model: &mut ContactSeparation, stick_charge: StickCharge) {
    model.parameters.stick_charge = stick_charge;
    model.parameters.restitution = Restitution::Constant { coefficient: 0.1 };
    scene.excitation = Excitation::Sines(vec![tone(70.0, 0.7), tone(4.0, 23.0)]);
    scene.load = resistor(1e7);
    scene.run = RunSpan { duration_s: 2.0, settle_s: 0.0 };
}

type Change = fn(&mut Scene, &mut ContactSeparation);

/// Scenes off the shipped one, over 30 periods unless they say so.
const SCENES: [(&str, Change); 18] = [
    ("a short circuit", |scene, _| scene.load = resistor(0.0)),
    ("1 Ω", |scene, _| scene.load = resistor(1.0)),
    ("1 kΩ", |scene, _| scene.load = resistor(1e3)),
    ("1 MΩ", |scene, _| scene.load = resistor(1e6)),
    ("100 MΩ", |_, _| ()),
    ("10 GΩ", |scene, _| scene.load = resistor(1e10)),
    ("open, with a charge", |scene, model| {
        scene.load = resistor(f64::INFINITY);
        model.initial.charge_c = Some(5e-9);
    }),
    ("gap-field, 1 MΩ, without parasitic capacitance", |scene, model| {
        scene.load = resistor(1e6);
        model.parameters.force_law = ForceLaw::GapField;
        model.parameters.parasitic_capacitance_f = 0.0;
    }),
    ("gap-field, open", |scene, model| {
        scene.load = resistor(f64::INFINITY);
        model.parameters.force_law = ForceLaw::GapField;
        model.parameters.parasitic_capacitance_f = 100e-12;
    }),
    ("gap-field, a short circuit", |scene, model| {
        scene.load = resistor(0.0);
        model.parameters.force_law = ForceLaw::GapField;
    }),
    ("a large parasitic capacitance", |_, model| model.parameters.parasitic_capacitance_f = 1e-9),
    ("below impact, 1 kΩ", |scene, _| {
        scene.excitation = sine(0.05, 18.0);
        scene.load = resistor(1e3);
    }),
    ("below impact, 100 MΩ", |scene, _| scene.excitation = sine(0.05, 18.0)),
    ("sticks, frozen", |scene, model| sticks(scene, model, StickCharge::Frozen)),
    ("sticks, relaxing", |scene, model| sticks(scene, model, StickCharge::Relaxing)),
    ("two tones", |scene, _| {
        scene.excitation = Excitation::Sines(vec![tone(1.9, 20.0), tone(3.0, 47.0)]);
        scene.run = RunSpan { duration_s: 1.5, settle_s: 0.3 };
    }),
    ("a rough trace", |scene, _| {
        scene.excitation = rough(8.0);
        scene.run = RunSpan { duration_s: 1.5, settle_s: 0.3 };
    }),
    ("let go near the dielectric", |scene, model| {
        model.initial.position_m = Some(1e-4);
        model.initial.velocity_m_per_s = Some(-0.3);
        scene.excitation = Excitation::Silence;
        scene.run = RunSpan { duration_s: 1.0, settle_s: 0.0 };
    }),
];

fn scene((_, change): &(&str, Change)) -> Scene {
    contact_separation(|scene, model| {
        scene.run = periods(20.0, 30, 10);
        change(scene, model);
    })
}

/// Relative differences from the reference: largest gap, RMS voltage, mean power, first impact, impact speed, peak voltage;
/// and the difference of the stuck fractions.
fn differences(exact: &(Outcome, ContactSeparationOutcome), scene: &Scene, options: &Options) -> [f64; 7] {
    let found = run(scene, options);
    assert!(options.precision.is_some() || found.1.impacts == exact.1.impacts, "{}", found.1.impacts);
    [
        relative_difference(found.1.peak_gap_m, exact.1.peak_gap_m),
        relative_difference(found.0.rms_voltage_v, exact.0.rms_voltage_v),
        relative_difference(found.0.mean_power_w, exact.0.mean_power_w),
        relative_difference(found.1.first_impact_s, exact.1.first_impact_s),
        relative_difference(found.1.max_impact_speed_m_per_s, exact.1.max_impact_speed_m_per_s),
        relative_difference(found.0.peak_voltage_v, exact.0.peak_voltage_v),
        (value(found.1.stuck_fraction) - value(exact.1.stuck_fraction)).abs(),
    ]
}

#[test]
fn the_method_agrees_with_the_reference_on_every_load_law_and_excitation() {
    let rows = on_all_cores(&SCENES, |row| {
        let scene = scene(row);
        let exact = run(&scene, &reference());
        let stuck = value(exact.1.stuck_fraction);
        assert!(!row.0.starts_with("sticks") || (0.05..0.95).contains(&stuck), "{}: {stuck}", row.0);
        // The largest gap is that of the cubic through a long step.
        let allowed = |of: f64| [f64::max(of, 2e-4), of, of, of, of, of, of];
        vec![
            ("f64", allowed(2e-5), differences(&exact, &scene, &by_the_method(adaptive(1e-6)))),
            ("f32", allowed(2e-3), differences(&exact, &scene, &by_the_method(single(adaptive(1e-4))))),
        ]
    });
    assert_rows_within(&SCENES, &rows);
}
