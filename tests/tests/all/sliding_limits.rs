//! Analytic limits of the sliding harvester, which the core and the independent reference must meet alike.

use std::f64::consts::{PI, TAU};

use cross_crate_tests::{
    GRAVITY, adaptive, assert_close, fixed, mean_square_current, on_all_cores, periods, reference, resistor,
    rub, sine, single, slide, sliding, value,
};
use host_bench::method::{Failure, Options};
use host_bench::run::run_scene;
use host_bench::scene_file::{Excitation, ForceLaw, RunSpan, Scene, Sliding, StickCharge};
use model_core::part::VACUUM_PERMITTIVITY;

const RADIUS: f64 = 10e-3;
const PATCH: f64 = PI * RADIUS * RADIUS;
/// `ε0 ε_r S`.
const PERMITTIVITY_AREA: f64 = VACUUM_PERMITTIVITY * 2.0 * PATCH;
const DIELECTRIC: f64 = 0.05e-3;
const WEIGHT: f64 = 8e-3 * GRAVITY;

/// The first mode of Table 1, from the root of the clamped beam's equation with a mass at its tip.
struct Mode {
    omega: f64,
    /// `M`.
    mass: f64,
    /// `κ`.
    participation: f64,
}

impl Mode {
    /// The shape normalised to 1 at the tip, integrated by the midpoint rule; `∫ φ dz` and `∫ φ² dz`.
    fn of_table_1() -> Self {
        let (length, beam) = (0.1_f64, 7800.0 * 20e-3 * 0.5e-3 * 0.1);
        let ratio = 8e-3 / beam;
        let equation = |root: f64| {
            1.0 + root.cos() * root.cosh()
                + root * ratio * (root.cos() * root.sinh() - root.sin() * root.cosh())
        };
        let root = bisect([1.0, 1.5], |root| equation(root) > 0.0);
        let stiffness = 210e9 * 20e-3 * 0.5e-3_f64.powi(3) / 12.0;
        let side = (root.sin() - root.sinh() + root * ratio * (root.cos() - root.cosh()))
            / (root.cos() + root.cosh() - root * ratio * (root.sin() - root.sinh()));
        let shape = |z: f64| {
            let at = root * z;
            at.cos() - at.cosh() + side * (at.sin() - at.sinh())
        };
        let mean = |of: &dyn Fn(f64) -> f64| midpoints(20_000).map(of).sum::<f64>() / 20_000.0;
        let tip = shape(1.0);
        let [first, second] = [mean(&|z| shape(z) / tip), mean(&|z| (shape(z) / tip).powi(2))];
        let mass = beam * second + 8e-3;
        Self {
            omega: root * root * (stiffness / (beam * length.powi(3))).sqrt(),
            mass,
            participation: (beam * first + 8e-3) / mass,
        }
    }

    fn frequency(&self) -> f64 {
        self.omega / TAU
    }
}

/// Middles of so many equal parts of 0 to 1.
fn midpoints(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |index| (f64::from(index) + 0.5) / f64::from(count))
}

/// Where `above` changes from true to false.
fn bisect([mut low, mut high]: [f64; 2], above: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if above(middle) { low = middle } else { high = middle }
    }
    low
}

/// `S1 / S`: two discs of the same radius.
fn active(x: f64) -> f64 {
    let away = x.abs() / (2.0 * RADIUS);
    (away.acos() - away * (1.0 - away * away).sqrt()) * 2.0 / PI
}

/// Without friction, damped so much that nothing is left of the transient after `settle` periods.
fn linear(frequency: f64, change: impl FnOnce(&mut Scene, &mut Sliding)) -> Scene {
    sliding(|scene, model| {
        rub(&mut model.parameters, 0.0);
        model.parameters.damping_ratio = 0.05;
        scene.excitation = sine(0.3, frequency);
        scene.run = periods(frequency, 75, 10);
        change(scene, model);
    })
}

/// `κ A / √((ω² − Ω²)² + (2 ζ ω Ω)²)` at 0.3 g.
fn linear_amplitude(mode: &Mode, frequency: f64) -> f64 {
    let drive = TAU * frequency;
    let response = (mode.omega.powi(2) - drive.powi(2)).hypot(2.0 * 0.05 * mode.omega * drive);
    mode.participation * 0.3 * GRAVITY / response
}

/// The mode of the beam of Table 1; the expected numbers are from another program, to ten digits.
#[test]
fn the_beam_has_the_mode_of_table_1() {
    let mode = Mode::of_table_1();
    assert_close("ω", mode.omega, 115.441_779_0, 1e-9);
    assert_close("M", mode.mass, 9.858_671_590e-3, 1e-8);
    assert_close("κ", mode.participation, 1.110_563_269_8, 1e-8);
    for options in [adaptive(1e-3), reference()] {
        let (_, found) = slide(&linear(15.0, |scene, _| scene.run = periods(15.0, 1, 1)), &options);
        assert_close("natural frequency", value(found.natural_frequency_hz), mode.frequency(), 1e-12);
    }
}

#[test]
fn without_friction_the_amplitude_is_the_linear_one() {
    let mode = Mode::of_table_1();
    for frequency in [10.0, 18.0, 25.0] {
        let expected = linear_amplitude(&mode, frequency);
        let scene = linear(frequency, |scene, model| {
            model.parameters.charge_density_c_per_m2 = 0.0;
            scene.run = periods(frequency, 160, 10);
        });
        for (options, tolerance) in
            [(adaptive(1e-5), 1e-5), (single(adaptive(1e-4)), 3e-4), (reference(), 1e-9)]
        {
            let (outcome, found) = slide(&scene, &options);
            assert_close("amplitude", value(found.amplitude_m), expected, tolerance);
            assert_close("largest displacement", value(found.peak_displacement_m), expected, tolerance);
            assert_eq!((found.stick_fraction, outcome.peak_voltage_v), (Some(0.0), Some(0.0)));
            assert_eq!((outcome.mean_power_w, outcome.mean_voltage_v), (Some(0.0), Some(0.0)));
        }
    }
}

/// Den Hartog (1931): an undamped oscillator under Coulomb friction in steady motion without stops.
#[test]
fn under_coulomb_friction_it_has_den_hartogs_amplitude() {
    let mode = Mode::of_table_1();
    for (frequency, millimetres) in [(14.0, 0.637432), (16.0, 1.071944), (22.0, 0.564334), (25.0, 0.282935)] {
        let ratio = TAU * frequency / mode.omega;
        let response = 1.0 / (1.0 - ratio * ratio);
        let damping = (PI / ratio).sin() / (ratio * (1.0 + (PI / ratio).cos()));
        let drive = mode.participation * 0.36 * GRAVITY / mode.omega.powi(2);
        let friction = 0.2 * WEIGHT / (mode.mass * mode.omega.powi(2));
        let expected = ((drive * response).powi(2) - (friction * damping).powi(2)).sqrt();
        assert_close("the closed form", 1e3 * expected, millimetres, 3e-6);
        let scene = sliding(|scene, model| {
            rub(&mut model.parameters, 0.2);
            model.parameters.damping_ratio = 0.0;
            model.parameters.charge_density_c_per_m2 = 0.0;
            scene.excitation = sine(0.36, frequency);
            scene.run = periods(frequency, 155, 5);
        });
        // What is left of the transient limits the reference.
        for (options, tolerance) in
            [(adaptive(1e-5), 1e-5), (single(adaptive(1e-4)), 1e-3), (reference(), 2e-6)]
        {
            let (_, found) = slide(&scene, &options);
            assert_close("amplitude", value(found.amplitude_m), expected, tolerance);
        }
    }
}

/// What acts on the slider beside its weight, at a displacement and a charge.
fn attraction(law: ForceLaw, density: f64, charge: f64, x: f64) -> f64 {
    match law {
        ForceLaw::TransferredCharge => charge * charge / (2.0 * PERMITTIVITY_AREA * active(x)),
        ForceLaw::GapField => (density * PATCH - charge).powi(2) / (PERMITTIVITY_AREA * active(x)),
        ForceLaw::None => 0.0,
    }
}

/// The charge that a motion of amplitude X keeps where the load is open and no mean voltage is left:
/// `σ <S2/S1> / <1/S1>`.
fn kept_charge(density: f64, amplitude: f64) -> f64 {
    let mean = |of: &dyn Fn(f64) -> f64| {
        midpoints(400).map(|part| of(amplitude * (PI * part).cos())).sum::<f64>() / 400.0
    };
    density * PATCH * mean(&|x| (1.0 - active(x)) / active(x)) / mean(&|x| 1.0 / active(x))
}

/// At resonance the work of the base over a cycle, `π κ M A X`, is what damper and friction take from a
/// sinusoidal motion: the amplitude in a short circuit, and with the load open.
fn balanced_amplitude(mode: &Mode, law: ForceLaw, density: f64, gravities: f64, open: bool) -> f64 {
    let surplus = |amplitude: f64| {
        let kept = kept_charge(density, amplitude);
        let friction = |x: f64| {
            let charge = if open { kept } else { density * PATCH * (1.0 - active(x)) };
            (0.2 + 0.1 * active(x)) * (WEIGHT + attraction(law, density, charge, x))
        };
        let mean = midpoints(400).map(|part| friction(part * amplitude)).sum::<f64>() / 400.0;
        let damper = TAU * 0.0035 * mode.mass * mode.omega.powi(2) * amplitude.powi(2);
        PI * mode.participation * mode.mass * gravities * GRAVITY * amplitude
            - damper
            - 4.0 * mean * amplitude
    };
    bisect([5e-3, 19.5e-3], |amplitude| surplus(amplitude) > 0.0)
}

/// A run at resonance that starts on the turning point of the amplitude: little is left of a transient.
fn at_resonance(mode: &Mode, law: ForceLaw, density: f64, load: f64, gravities: f64, near: f64) -> Scene {
    sliding(|scene, model| {
        model.parameters.charge_density_c_per_m2 = density;
        model.parameters.force_law = law;
        model.initial.position_m = Some(near);
        model.initial.charge_c = (load > 0.0).then(|| kept_charge(density, near));
        scene.load = resistor(load);
        scene.excitation = sine(gravities, mode.frequency());
        scene.run = periods(mode.frequency(), 130, 5);
    })
}

#[test]
fn at_resonance_the_energy_balances() {
    let mode = Mode::of_table_1();
    for (density, shorted, open) in [
        (0.0, 14.115, 14.115),
        (20e-6, 13.148, 12.909),
        (40e-6, 11.511, 11.054),
        (80e-6, 8.860, 8.302),
        (120e-6, 7.113, 6.590),
    ] {
        let law = ForceLaw::TransferredCharge;
        for (load, millimetres) in [(0.0, shorted), (f64::INFINITY, open)] {
            let expected = balanced_amplitude(&mode, law, density, 0.36, load > 0.0);
            assert_close("the balance", 1e3 * expected, millimetres, 1e-4);
            let scene = at_resonance(&mode, law, density, load, 0.36, expected);
            for (options, tolerance) in
                [(adaptive(1e-5), 6e-4), (single(adaptive(1e-4)), 1e-3), (reference(), 6e-4)]
            {
                let (_, found) = slide(&scene, &options);
                let what = format!("σ = {density:e} C/m², {load} Ω: amplitude");
                println!("{what} off by {:.1e}", value(found.amplitude_m) / expected - 1.0);
                assert_close(&what, value(found.amplitude_m), expected, tolerance);
            }
        }
    }
}

/// The field's own law brakes less the larger the load, the transferred charge's brakes more: the
/// trend by which the two were told apart.
#[test]
fn the_laws_have_opposite_trends_over_the_load() {
    let mode = Mode::of_table_1();
    let loads = [(0.0, 15.431), (1e7, 15.469), (1e8, 16.183), (1e10, 17.016)];
    let amplitudes = |law: ForceLaw, gravities: f64| {
        on_all_cores(&loads, |&(load, near)| {
            let near = if law == ForceLaw::GapField { near * 1e-3 } else { 14e-3 };
            let mut scene = at_resonance(&mode, law, 20e-6, load, gravities, near);
            // As the values were found: at the peak of the response.
            scene.run = periods(mode.frequency(), 300, 20);
            value(slide(&scene, &adaptive(1e-4)).1.amplitude_m)
        })
    };
    let field = amplitudes(ForceLaw::GapField, 0.38);
    for (found, (load, millimetres)) in field.iter().zip(loads) {
        println!("gap-field at {load:e} Ω: {:.3} mm", found * 1e3);
        assert_close("gap-field: amplitude", found * 1e3, millimetres, 2e-3);
    }
    assert!(field.windows(2).all(|pair| pair[0] < pair[1]), "{field:?}");
    let ends = [false, true].map(|open| balanced_amplitude(&mode, ForceLaw::GapField, 20e-6, 0.38, open));
    assert_close("gap-field in a short circuit", field[0], ends[0], 2e-3);
    assert_close("gap-field with a large load", field[3], ends[1], 2e-3);
    let transferred = amplitudes(ForceLaw::TransferredCharge, 0.38);
    println!("transferred-charge: {transferred:?}");
    assert!(transferred[1..].windows(2).all(|pair| pair[0] > pair[1]), "{transferred:?}");
}

/// `V → R σ sgn(x) √(4r² − x²) x'`: of a sinusoidal motion `P / R → σ² X² Ω² (2 r² − X²/8)`, less the
/// square of what the circuit lags.
#[test]
fn power_of_a_small_load_is_proportional_to_it() {
    let mode = Mode::of_table_1();
    let frequency = 15.0;
    let amplitude = linear_amplitude(&mode, frequency);
    let speed = TAU * frequency * amplitude;
    let density = 80e-6_f64;
    let per_ohm = (density * speed).powi(2) * (2.0 * RADIUS.powi(2) - amplitude.powi(2) / 8.0);
    for resistance in [1e-6, 1.0, 1e2, 1e3, 1e4, 1e5, 1e6] {
        let scene = linear(frequency, |scene, _| scene.load = resistor(resistance));
        let lag = mode.omega * resistance * PERMITTIVITY_AREA / DIELECTRIC;
        for (options, tolerance) in [(adaptive(1e-5), 3e-5), (single(adaptive(1e-4)), 1e-3)] {
            let (outcome, _) = slide(&scene, &options);
            let found = value(outcome.mean_power_w) / resistance;
            println!("{resistance:e} Ω: power per ohm off by {:.1e}", found / per_ohm - 1.0);
            assert_close(
                &format!("{resistance:e} Ω: power"),
                found,
                per_ohm,
                tolerance + 2.0 * lag + 10.0 * lag * lag,
            );
        }
    }
}

/// `q' = (σ S2 − q) / R C` with `C = ε0 ε_r S1 / d`: of a sinusoidal motion the power is a quadrature.
#[test]
fn in_a_sinusoidal_slide_the_power_is_a_quadrature() {
    let amplitude = linear_amplitude(&Mode::of_table_1(), 15.0);
    let active = |phase: f64| active(amplitude * phase.sin());
    for resistance in [1e7, 1e8, 3e8, 1e9] {
        let rate = |phase: f64| DIELECTRIC / (resistance * PERMITTIVITY_AREA * active(phase));
        let squared = mean_square_current(1.0 / 15.0, rate, |phase| 80e-6 * PATCH * (1.0 - active(phase)));
        let scene = linear(15.0, |scene, model| {
            model.parameters.force_law = ForceLaw::None;
            scene.load = resistor(resistance);
        });
        for (options, tolerance) in [(adaptive(1e-6), 1e-5), (single(adaptive(1e-4)), 1e-3)] {
            let power = value(slide(&scene, &options).0.mean_power_w);
            println!("{resistance:e} Ω: off by {:.1e}", power / (resistance * squared) - 1.0);
            assert_close(&format!("{resistance:e} Ω: power"), power, resistance * squared, tolerance);
        }
    }
}

/// Along a run with friction: in a short circuit the charge is `σ S2`, with the load open the voltage is `(σ S2 − q) / C`.
#[test]
fn without_and_with_an_infinite_load_charge_and_voltage_follow_the_overlap() {
    let core = Options { ends_every_s: Some(1.3e-3), ..adaptive(1e-5) };
    for (load, options) in
        [(0.0, core), (0.0, reference()), (f64::INFINITY, core), (f64::INFINITY, reference())]
    {
        let options = Options { trace_every_s: Some(1.3e-3), ..options };
        let scene = sliding(|scene, model| {
            model.initial.charge_c = (load > 0.0).then_some(3e-9);
            scene.load = resistor(load);
            scene.run = periods(18.373, 40, 20);
        });
        let rows = run_scene(&scene, &options).expect("it runs").trace.expect("a trace was asked for").rows;
        assert!(rows.len() > 1000);
        // The terminals of a slider that sticks with a frozen charge are at 0 V.
        for row in rows.iter().filter(|row| row[6] == 0.0) {
            let relaxed = 80e-6 * PATCH * (1.0 - active(row[1]));
            let charge = if load > 0.0 { 3e-9 } else { relaxed };
            let voltage = (relaxed - charge) * DIELECTRIC / (PERMITTIVITY_AREA * active(row[1]));
            let off = [(row[3] - charge).abs() / (80e-6 * PATCH), (row[4] - voltage).abs()];
            assert!(off[0] < 1e-9 && off[1] < 1e-6 * (1.0 + voltage.abs()), "{load} Ω: {row:?}: {off:?}");
        }
    }
}

/// A large load leaves the charge as it is: the power goes with its inverse, the voltage becomes that
/// of the open circuit.
#[test]
fn a_large_load_leaves_the_charge_as_it_is() {
    let scene = |resistance: f64| {
        sliding(|scene, _| {
            scene.load = resistor(resistance);
            scene.run = periods(18.373, 40, 20);
        })
    };
    for options in [adaptive(1e-5), reference()] {
        let (open, open_motion) = slide(&scene(f64::INFINITY), &options);
        assert_eq!((open.mean_power_w, open.delivered_energy_j), (Some(0.0), Some(0.0)));
        for (resistance, tolerance) in [(1e15, 1e-5), (1e30, 1e-8)] {
            let (outcome, motion) = slide(&scene(resistance), &options);
            assert_close("RMS voltage", value(outcome.rms_voltage_v), value(open.rms_voltage_v), tolerance);
            let peaks = [&outcome, &open].map(|outcome| value(outcome.peak_voltage_v));
            assert_close("peak voltage", peaks[0], peaks[1], tolerance);
            assert_close("amplitude", value(motion.amplitude_m), value(open_motion.amplitude_m), tolerance);
            let power = value(open.rms_voltage_v).powi(2) / resistance;
            assert_close("power", value(outcome.mean_power_w), power, 2.0 * tolerance);
        }
    }
    let options = Options { trace_every_s: Some(1e-3), ..adaptive(1e-5) };
    let start = sliding(|scene, model| {
        model.initial.charge_c = Some(3e-9);
        *scene = self::open(scene);
    });
    let rows = run_scene(&start, &options).expect("it runs").trace.expect("a trace was asked for").rows;
    assert!(rows.len() > 1000 && rows.iter().all(|row| (row[3] / 3e-9 - 1.0).abs() < 1e-12));
}

fn open(scene: &Scene) -> Scene {
    Scene { load: resistor(f64::INFINITY), run: periods(18.373, 40, 20), ..scene.clone() }
}

/// A weak charge does not move the slider, and the voltage is proportional to it; in a periodic motion
/// there is no direct voltage.
#[test]
fn voltage_is_proportional_to_a_weak_charge_and_has_no_mean() {
    let outcome = |density: f64, options: &Options| {
        let scene = sliding(|scene, model| {
            model.parameters.charge_density_c_per_m2 = density;
            scene.load = resistor(1e7);
            scene.excitation = sine(0.3, 10.0);
            scene.run = periods(10.0, 40, 20);
        });
        slide(&scene, options)
    };
    for (options, tolerance) in [(adaptive(1e-5), 1e-5), (single(adaptive(1e-4)), 1e-3), (reference(), 1e-6)]
    {
        let ((weak, motion), (weaker, _)) = (outcome(1e-8, &options), outcome(1e-9, &options));
        assert!(value(weaker.rms_voltage_v) > 0.0 && value(motion.stick_fraction) > 0.1);
        let tenfold = 10.0 * value(weaker.rms_voltage_v);
        assert_close("RMS voltage", value(weak.rms_voltage_v), tenfold, tolerance);
        let mean = value(weak.mean_voltage_v) / value(weak.rms_voltage_v);
        println!("mean voltage over RMS voltage {mean:.1e}");
        assert!(mean.abs() < tolerance, "{mean}");
    }
    let (none, motion) = outcome(0.0, &adaptive(1e-4));
    assert_eq!((none.rms_voltage_v, none.mean_power_w), (Some(0.0), Some(0.0)));
    assert!(value(motion.amplitude_m) > 1e-4);
}

/// A slider that does not move discharges through the load as `exp(−t / RC)`, unless its charge is
/// frozen.
#[test]
fn a_held_slider_discharges_into_the_load() {
    let covered = active(5e-3);
    let capacitance = PERMITTIVITY_AREA * covered / DIELECTRIC;
    let voltage = 80e-6 * PATCH * (1.0 - covered) / capacitance;
    for elapsed in [0.5, 1.0, 3.0] {
        let scene = |stick_charge: StickCharge| {
            sliding(|scene, model| {
                rub(&mut model.parameters, 10.0);
                model.parameters.stick_charge = stick_charge;
                model.initial.position_m = Some(5e-3);
                model.initial.charge_c = Some(0.0);
                scene.excitation = Excitation::Silence;
                scene.run = RunSpan { duration_s: elapsed * 1e8 * capacitance, settle_s: 0.0 };
            })
        };
        let expected = 0.5 * capacitance * voltage.powi(2) * (1.0 - (-2.0 * elapsed).exp());
        let relaxing = scene(StickCharge::Relaxing);
        for (options, tolerance) in
            [(adaptive(1e-6), 1e-6), (single(adaptive(1e-4)), 5e-4), (reference(), 1e-10)]
        {
            let (outcome, found) = slide(&relaxing, &options);
            assert_close("delivered energy", value(outcome.delivered_energy_j), expected, tolerance);
            assert_close("peak voltage", value(outcome.peak_voltage_v), voltage, tolerance.min(1e-6));
            let mean = voltage * (1.0 - (-elapsed).exp()) / elapsed;
            assert_close("mean voltage", value(outcome.mean_voltage_v), mean, tolerance);
            assert_eq!((found.stick_fraction, found.amplitude_m), (Some(1.0), Some(0.0)));
        }
        for options in [adaptive(1e-6), reference()] {
            let (outcome, found) = slide(&scene(StickCharge::Frozen), &options);
            assert_eq!((outcome.peak_voltage_v, outcome.delivered_energy_j), (Some(0.0), Some(0.0)));
            assert_eq!((found.stick_fraction, found.sticks_per_period), (Some(1.0), None));
            assert_eq!((found.peak_displacement_m, found.amplitude_m), (Some(5e-3), Some(0.0)));
        }
    }
}

/// From rest the slider is held for ever below `A = μ_s1 m g / (κ M)`, and moves above.
#[test]
fn friction_holds_up_to_its_threshold() {
    let mode = Mode::of_table_1();
    let threshold = 0.35 * WEIGHT / (mode.participation * mode.mass);
    assert_close("threshold", threshold, 2.5088, 2e-5);
    for (excess, options) in [(1e-6, adaptive(1e-4)), (1e-5, single(adaptive(1e-3))), (1e-9, reference())] {
        for (sign, moves) in [(-1.0, false), (1.0, true)] {
            let scene = sliding(|scene, _| {
                scene.excitation = sine(threshold * (1.0 + sign * excess) / GRAVITY, 18.0);
                scene.run = periods(18.0, 20, 20);
            });
            let (outcome, found) = slide(&scene, &options);
            assert_eq!(outcome.events > 0, moves, "{sign} {excess}");
            assert_eq!(found.stick_fraction == Some(1.0), !moves, "{sign} {excess}");
            assert_eq!(found.amplitude_m > Some(0.0), moves, "{sign} {excess}");
            assert_eq!(found.sticks_per_period > Some(0.0), moves, "{sign} {excess}");
            assert_eq!(outcome.rms_voltage_v > Some(0.0), moves, "{sign} {excess}");
        }
    }
}

/// An uncharged slider, shaken too hard, swings out of the overlap: an error that names the
/// displacement, at the time of the reference to the length of a step.
#[test]
fn a_slider_that_leaves_the_patch_is_a_step_error() {
    let scene = sliding(|scene, model| {
        model.parameters.charge_density_c_per_m2 = 0.0;
        scene.excitation = sine(0.5, 18.373);
    });
    for options in [reference(), adaptive(1e-5), single(adaptive(1e-5)), fixed(1e-5)] {
        let Err(Failure::Step(told)) = run_scene(&scene, &options) else { panic!("it leaves the patch") };
        assert!(told.contains("displacement"), "{told}");
        let times = told.split(" at ").skip(1).filter_map(|rest| rest.split(' ').next()?.parse::<f64>().ok());
        let time = times.last().unwrap_or(f64::NAN);
        assert!((time - 2.7208).abs() < 1e-4, "{told}");
    }
}

/// Charged a little, the overlap is so small before the slider leaves it that the field of what has been
/// transferred holds it there for ever.
#[test]
fn the_field_locks_a_slider_at_the_end_of_the_overlap() {
    let scene = sliding(|scene, model| {
        model.parameters.charge_density_c_per_m2 = 10e-6;
        scene.excitation = sine(0.5, 18.373);
        scene.run = periods(18.373, 80, 10);
    });
    for options in [reference(), adaptive(1e-5), adaptive(1e-4), single(adaptive(1e-4))] {
        let (outcome, found) = slide(&scene, &options);
        println!("{}: locked at {:.4} mm", outcome.method, 1e3 * value(found.peak_displacement_m));
        assert_close("displacement", value(found.peak_displacement_m), 19.9797e-3, 2e-5);
        assert_eq!((found.stick_fraction, outcome.mean_power_w), (Some(1.0), Some(0.0)));
    }
}
