//! Without contact: the closed form of the steady state, and excitations that must agree.

use nalgebra::Complex;

use super::*;
use harvester_scene::scene_file::Trace;
use harvester_scene::scene_file::modes::BumpStopModes;

/// The steady state to a sine: phasors of `a = B sin ωt` as imaginary parts.
pub(super) struct Steady {
    pub(super) modal: Vec<Complex<f64>>,
    pub(super) voltage: Complex<f64>,
    tip: Complex<f64>,
}

pub(super) const I: Complex<f64> = Complex::new(0.0, 1.0);

/// `v = B Σ (−jωθγ/D) / (jωC + 1/R + χ Σ jωθ²/D)`, `r = (−γB − χθv)/D`, `D = ω_i² − ω² + 2jζω_iω`.
pub(super) fn steady(model: &BumpStop, resistance: f64) -> Steady {
    let modes = BumpStopModes::new(&model.parameters, None);
    let angular = std::f64::consts::TAU * FREQUENCY;
    let coupled = if model.parameters.coupling == Coupling::TwoWay { 1.0 } else { 0.0 };
    let denominators: Vec<Complex<f64>> = modes
        .beam
        .iter()
        .map(|mode| {
            let own = mode.angular_frequency;
            Complex::new(own * own - angular * angular, 2.0 * model.parameters.damping_ratio * own * angular)
        })
        .collect();
    let (mut current, mut admittance) =
        (Complex::new(0.0, 0.0), I * (angular * modes.capacitance) + 1.0 / resistance);
    for (mode, denominator) in modes.beam.iter().zip(&denominators) {
        current -= I * (angular * mode.coupling * mode.participation) / denominator;
        admittance += I * (coupled * angular * mode.coupling * mode.coupling) / denominator;
    }
    let voltage = if resistance == 0.0 { Complex::new(0.0, 0.0) } else { current * AMPLITUDE / admittance };
    let modal: Vec<Complex<f64>> = modes
        .beam
        .iter()
        .zip(&denominators)
        .map(|(mode, denominator)| {
            (-voltage * (coupled * mode.coupling) - mode.participation * AMPLITUDE) / denominator
        })
        .collect();
    let tip = modal.iter().zip(&modes.beam).map(|(modal, mode)| modal * mode.at_tip).sum();
    Steady { modal, voltage, tip }
}

/// A run without stop that starts in that steady state and must stay there.
fn from_steady(model: &mut BumpStop, scene: &mut Scene, resistance: f64) -> (Steady, Outcome) {
    let steady = steady(model, resistance);
    let angular = std::f64::consts::TAU * FREQUENCY;
    model.stop = None;
    model.initial = BumpStopStart {
        modal_displacement: steady.modal.iter().map(|modal| modal.im).collect(),
        modal_velocity: steady.modal.iter().map(|modal| (I * angular * modal).im).collect(),
        voltage_v: steady.voltage.im,
        ..BumpStopStart::at_rest(0, 0)
    };
    scene.load = Load::Resistor { resistance_ohm: resistance };
    scene.run = RunSpan { duration_s: 5.0 / FREQUENCY, settle_s: 1.0 / FREQUENCY };
    let (outcome, events) = run(model, scene, None);
    assert!(events.is_empty());
    (steady, outcome)
}

#[test]
fn the_steady_state_is_that_of_the_frequency_response() {
    for coupling in [Coupling::TwoWay, Coupling::OneWay] {
        for resistance in [0.0, 1e-3, 1e3, 45.41e3, 1e6, 1e12, f64::INFINITY] {
            let (mut model, mut scene) = scene([6, 0], [0.0, 1.0]);
            model.parameters.coupling = coupling;
            let (steady, outcome) = from_steady(&mut model, &mut scene, resistance);
            let voltage = steady.voltage.norm();
            let power = if resistance > 0.0 { voltage * voltage / (2.0 * resistance) } else { 0.0 };
            let found = number(outcome.mean_power_w);
            assert!((found - power).abs() <= 1e-10 * power, "{resistance}: {found} {power}");
            close(number(particular(&outcome).peak_tip_displacement_m), steady.tip.norm(), 1e-9);
            if resistance > 0.0 {
                let root_mean_square = voltage / 2f64.sqrt();
                close(number(outcome.rms_voltage_v), root_mean_square, 1e-10);
                close(number(outcome.peak_voltage_v), voltage, 1e-9);
                assert!(number(outcome.mean_voltage_v).abs() < 1e-10 * voltage);
            } else {
                assert_eq!(outcome.rms_voltage_v, Some(0.0));
            }
            assert!(number(outcome.energy_residual) < 1e-12, "{:?}", outcome.energy_residual);
        }
    }
}

/// Amplitude of the voltage in V and of the tip in µm, mean power in µW, to the digits of an independent
/// computation.
#[test]
fn numbers_of_the_frequency_response() {
    for (modes, coupling, resistance, voltage, tip, power) in [
        (10, Coupling::TwoWay, 1e6, 5.298_981, 66.9337, 14.0396),
        (10, Coupling::OneWay, 1e6, 7.029_422, 86.8043, 24.7064),
        (6, Coupling::TwoWay, 1e6, 5.307_26, 66.9104, 14.0835),
        (6, Coupling::TwoWay, 45.41e3, 4.188_495, f64::NAN, 193.168),
        (6, Coupling::OneWay, 45.41e3, 4.975_444, f64::NAN, 272.573),
        (6, Coupling::TwoWay, 1e3, 0.154_761_8, f64::NAN, f64::NAN),
    ] {
        let (mut model, mut scene) = scene([modes, 0], [0.0, 1.0]);
        model.parameters.coupling = coupling;
        let (_, outcome) = from_steady(&mut model, &mut scene, resistance);
        close(number(outcome.peak_voltage_v), voltage, 1e-6);
        if !tip.is_nan() {
            close(1e6 * number(particular(&outcome).peak_tip_displacement_m), tip, 2e-6);
        }
        if !power.is_nan() {
            close(1e6 * number(outcome.mean_power_w), power, 4e-6);
        }
    }
}

#[test]
fn without_a_stop_there_is_nothing_about_it() {
    let (mut model, mut scene) = scene([3, 0], [0.0, 1.0]);
    let (_, outcome) = from_steady(&mut model, &mut scene, 1e6);
    let found = particular(&outcome);
    assert_eq!(
        (found.contacts, found.contacts_per_period, found.contact_fraction),
        (0, Some(0.0), Some(0.0))
    );
    assert_eq!([found.beam_natural_frequencies_hz.len(), found.rod_natural_frequencies_hz.len()], [3, 0]);
    for absent in
        [found.first_contact_s, found.peak_force_n, found.mean_force_n, found.peak_stop_point_displacement_m]
    {
        assert_eq!(absent, None);
    }
}

/// A tone may be written as a sum of two, and a constant as one of frequency 0 or as samples: the same
/// motion, contacts included.
#[test]
fn the_base_may_be_written_in_several_ways() {
    let (model, mut scene) = scene([4, 1], [0.0, 6e-3]);
    let ends = |scene: &Scene| {
        let (outcome, events) = run(&model, scene, Some(6e-3));
        let [first, ..] = events[..] else { panic!("there are contacts") };
        let row = row(&outcome, 6e-3).to_vec();
        (first.time, row[1], row[4], row[6])
    };
    let same = |one: (f64, f64, f64, f64), other: (f64, f64, f64, f64), allowed: f64| {
        close(one.0, other.0, allowed);
        close(one.1, other.1, allowed);
        close(one.2, other.2, allowed);
        assert!((one.3 - other.3).abs() < 1e-9);
    };
    let tone = Tone { amplitude_m_per_s2: AMPLITUDE, frequency_hz: FREQUENCY, phase_rad: 0.0 };
    let half = Tone { amplitude_m_per_s2: 0.5 * AMPLITUDE, ..tone };
    let sine = ends(&scene);
    scene.excitation = Excitation::Sines(vec![half, half]);
    same(ends(&scene), sine, 1e-10);

    // Towards the stop.
    let constant =
        Tone { amplitude_m_per_s2: 10.0, frequency_hz: 0.0, phase_rad: -std::f64::consts::FRAC_PI_2 };
    scene.excitation = Excitation::Sine(constant);
    let steady = ends(&scene);
    for repeat in [false, true] {
        scene.excitation = Excitation::File(Trace {
            samples_m_per_s2: vec![-10.0; 8].into(),
            rate_hz: 1e3,
            repeat,
            resampled: None,
        });
        same(ends(&scene), steady, 1e-10);
    }
}

/// A line between samples is a line: finely sampled, the sine is followed with an error of `(ωh)²/12`.
#[test]
fn samples_are_joined_by_lines() {
    let (mut model, mut scene) = scene([2, 0], [0.0, 9e-3]);
    model.stop = None;
    let (smooth, _) = run(&model, &scene, Some(9e-3));
    let rate_hz = 8000.0;
    let angle = std::f64::consts::TAU * FREQUENCY / rate_hz;
    let samples: Vec<f64> = (0..=80).map(|k| AMPLITUDE * (angle * f64::from(k)).sin()).collect();
    scene.excitation =
        Excitation::File(Trace { samples_m_per_s2: samples.into(), rate_hz, repeat: false, resampled: None });
    let (sampled, _) = run(&model, &scene, Some(9e-3));
    let ratio = row(&sampled, 9e-3)[1] / row(&smooth, 9e-3)[1];
    // The lines' fundamental is (sinc(ωh/2))² of the sine's.
    let expected = 1.0 - angle * angle / 12.0;
    assert!((ratio - expected).abs() < 0.1 * (1.0 - expected), "{ratio} {expected}");
}

/// With `RC` far below a grid step: the peak of a free voltage is its start, that of a driven one is `R` times a current
/// which does not depend on `R`, impacts included.
#[test]
fn a_voltage_that_relaxes_within_a_step_has_its_own_peak() {
    let peak = |restitution: Option<f64>, resistance_ohm: f64, voltage_v: f64| {
        let (mut model, mut scene) = scene([2, 0], [0.0, 0.01]);
        scene.load = Load::Resistor { resistance_ohm };
        let hit = StopParameters { contact: Contact::Restitution, restitution, gap_m: 0.0, ..stop(0) };
        model.stop = restitution.map(|_| hit);
        model.initial.voltage_v = voltage_v;
        run(&model, &scene, None).0.peak_voltage_v.expect("finite")
    };
    close(peak(None, 1.0, 62.0), 62.0, 1e-9);
    let [low, high] = [1e-3, 1e-2].map(|resistance| peak(Some(0.0), resistance, 0.0));
    close(high, 10.0 * low, 1e-3);
}
