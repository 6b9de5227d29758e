//! In contact: static limits, conserved energy, impacts of restitution.

use super::*;
use harvester_scene::scene_file::modes::BumpStopModes;

/// A base acceleration of 5 m/s² that presses the beam against the stop.
fn pressing() -> Excitation {
    let phase_rad = -std::f64::consts::FRAC_PI_2;
    Excitation::Sine(Tone { amplitude_m_per_s2: 5.0, frequency_hz: 0.0, phase_rad })
}

/// Under a steady acceleration, at rest on a rigid prop: a prop at the tip turns the tip's slope to −1/8 of
/// what it is without one, a prop at mid-span to 13/64, and the open-circuit voltage with it. The prop at the
/// tip carries 3/8 of the load, the one at mid-span 17/16.
#[test]
fn static_voltage_and_force_on_a_prop() {
    for (contact, restitution) in [(Contact::ResidualFlexibility, None), (Contact::Restitution, Some(0.5))] {
        for (position_m, slope, share) in [(50e-3, -0.125, 0.375), (25e-3, 13.0 / 64.0, 17.0 / 16.0)] {
            let (mut model, mut scene) = scene([20, 0], [0.0299, 0.03]);
            model.parameters.damping_ratio = 0.5;
            model.parameters.coupling = Coupling::OneWay;
            scene.load = Load::Resistor { resistance_ohm: f64::INFINITY };
            scene.excitation = pressing();
            model.stop = None;
            let (free, _) = run(&model, &scene, None);
            let modes = BumpStopModes::new(&model.parameters, None);
            // Slope of the free tip q L³ / 6EI, charge ν times it; ν from the first mode.
            let charge: f64 = modes
                .beam
                .iter()
                .map(|mode| mode.coupling * mode.participation * 5.0 / mode.angular_frequency.powi(2))
                .sum();
            close(number(free.mean_voltage_v), charge / modes.capacitance, 1e-6);
            let young_modulus_pa = 7e13;
            model.stop = Some(StopParameters {
                position_m,
                gap_m: 0.0,
                young_modulus_pa,
                contact,
                restitution,
                ..stop(0)
            });
            let (propped, _) = run(&model, &scene, None);
            let found = particular(&propped);
            close(number(found.contact_fraction), 1.0, 1e-9);
            // The slope of 20 modes misses 2 % of that of a force at the tip.
            let ratio = number(propped.mean_voltage_v) / number(free.mean_voltage_v);
            assert!((ratio - slope).abs() < 0.03 * (1.0 - slope), "{contact:?} {ratio} {slope}");
            let load = modes.beam_mass * 5.0;
            close(number(found.mean_force_n), share * load, 2e-3);
            close(number(found.peak_force_n), share * load, 2e-3);
        }
    }
}

/// Undamped, open-circuit and with the base at rest nothing is lost, whatever happens at the stop, and the
/// ledger says so.
#[test]
fn energy_is_conserved_through_contacts() {
    for (contact, restitution) in [(Contact::ResidualFlexibility, None), (Contact::Restitution, Some(1.0))] {
        let (mut model, mut scene) = scene([6, 2], [0.0, 0.02]);
        model.parameters.damping_ratio = 0.0;
        model.stop = Some(StopParameters { contact, restitution, ..stop(2) });
        model.initial.modal_velocity[0] = 1e-3;
        scene.load = Load::Resistor { resistance_ohm: f64::INFINITY };
        scene.excitation = Excitation::Silence;
        let (outcome, events) = run(&model, &scene, None);
        assert!(events.len() > 30, "{}", events.len());
        assert!(number(outcome.energy_residual) < 1e-11, "{:?}", outcome.energy_residual);
    }
}

/// A beam of one mode on a rigid wall: each impact reverses its speed times the coefficient, and it comes
/// to rest on the wall after infinitely many, which closing the contact cuts short.
#[test]
fn impacts_of_restitution_reverse_the_speed_and_come_to_rest() {
    let (mut model, mut scene) = scene([1, 0], [0.0, 0.1]);
    model.parameters.damping_ratio = 0.0;
    model.parameters.coupling = Coupling::OneWay;
    scene.excitation = pressing();
    let wall = StopParameters { contact: Contact::Restitution, restitution: Some(0.5), ..stop(0) };
    model.stop = Some(StopParameters { gap_m: 1e-6, ..wall });
    let (outcome, events) = run(&model, &scene, None);
    let found = particular(&outcome);
    // One mode without damping returns with the speed it left with.
    for pair in events.windows(2) {
        close(pair[1].speed, 0.5 * pair[0].speed, 1e-6);
    }
    let [first, .., last] = events[..] else { panic!("there are impacts") };
    assert!(last.speed < 1e-5 && last.speed > 0.4e-5, "{last:?}");
    assert_eq!(found.contacts, events.len() as u64);
    close(number(found.contact_fraction), 1.0 - last.time / 0.1, 1e-9);
    // Pressed by γ a φ − ω² g of one mode; and the momentum of all impacts, 1.5 p + 0.75 p + … .
    let mode = BumpStopModes::new(&model.parameters, model.stop.as_ref()).beam[0];
    let mass = mode.at_tip.powi(-2);
    let force = mass * (mode.at_tip * mode.participation * 5.0 - mode.angular_frequency.powi(2) * 1e-6);
    let impacts: f64 =
        events.iter().map(|event| 1.5 * mass * event.speed).sum::<f64>() - 0.5 * mass * last.speed;
    close(number(found.mean_force_n), (impacts + force * (0.1 - last.time)) / 0.1, 1e-9);
    close(number(found.peak_force_n), force, 1e-9);
    assert!(first.speed > 1e-3);
    assert!(number(outcome.energy_residual) < 1e-12, "{:?}", outcome.energy_residual);
}

/// A compliance in series with the contact is another spring: alone with the first mode, at rest.
#[test]
fn a_compliance_in_series_adds_to_that_of_the_contact() {
    let static_force = |contact_compliance_m_per_n: f64| {
        let (mut model, mut scene) = scene([1, 0], [0.0299, 0.03]);
        model.parameters.damping_ratio = 0.5;
        scene.excitation = pressing();
        scene.load = Load::Resistor { resistance_ohm: 0.0 };
        model.stop = Some(StopParameters { gap_m: 0.0, contact_compliance_m_per_n, ..stop(0) });
        let (outcome, _) = run(&model, &scene, None);
        (number(particular(&outcome).mean_force_n), model)
    };
    for compliance in [0.0, 1e-5, 1e-3] {
        let (force, model) = static_force(compliance);
        let modes = BumpStopModes::new(&model.parameters, model.stop.as_ref());
        let mode = modes.beam[0];
        let squared = mode.angular_frequency.powi(2);
        let free = mode.at_tip * mode.participation * 5.0 / squared;
        let whole = mode.at_tip.powi(2) / squared + modes.beam_residual + modes.rod_residual + compliance;
        close(force, free / whole, 1e-9);
    }
}
