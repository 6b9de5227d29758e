//! Order of convergence and energy ledger on the sliding scene, measured against the independent
//! reference: through reversals, sticks and the corner of the overlap.

use cross_crate_tests::{fixed, order, periods, reference, resistor, sine, slide, sliding, value};
use host_bench::method::{Method, Options};
use host_bench::scene_file::{ForceLaw, Scene, StickCharge};

/// The shipped scene from rest, towards resonance.
fn sliding_through() -> Scene {
    sliding(|scene, _| scene.run = periods(18.373, 55, 20))
}

/// Two sticks in each period.
fn sticking() -> Scene {
    sliding(|scene, _| {
        scene.excitation = sine(0.3, 10.0);
        scene.run = periods(10.0, 30, 10);
    })
}

/// The field pulls along the patch, and its charge flows in a stick.
fn pulled() -> Scene {
    sliding(|scene, model| {
        model.parameters.lateral_force = true;
        model.parameters.force_law = ForceLaw::GapField;
        model.parameters.stick_charge = StickCharge::Relaxing;
        model.parameters.charge_density_c_per_m2 = 20e-6;
        scene.excitation = sine(0.33, 10.0);
        scene.run = periods(10.0, 30, 10);
    })
}

fn scenes() -> [(&'static str, Scene, f64); 3] {
    [("sliding", sliding_through(), 1.0 / 18.373), ("sticking", sticking(), 0.1), ("pulled", pulled(), 0.1)]
}

/// Orders in mean power, RMS voltage, amplitude and stick fraction at so many steps a period, and the
/// errors at the last of them.
fn orders(scene: &Scene, period: f64, method: Method, divisions: &[f64]) -> Vec<(f64, f64)> {
    let numbers = |options: &Options| {
        let (outcome, motion) = slide(scene, options);
        [outcome.mean_power_w, outcome.rms_voltage_v, motion.amplitude_m, motion.stick_fraction].map(value)
    };
    let exact = numbers(&reference());
    let mut points = [const { Vec::new() }; 4];
    for division in divisions {
        let step = period / division;
        let found = numbers(&Options { method, ..fixed(step) });
        for ((points, found), exact) in points.iter_mut().zip(found).zip(exact) {
            points.push((step, (found / exact - 1.0).abs()));
        }
    }
    // Where nothing sticks the last is not a number.
    let found = points.iter().filter(|points| points.iter().all(|point| point.1.is_finite()));
    found.map(|points| (order(points), points[points.len() - 1].1)).collect()
}

#[test]
fn the_methods_are_of_second_and_of_fourth_order_through_all_events() {
    for (name, scene, period) in scenes() {
        for (method, divisions, wanted, most) in [
            (Method::TrBdf2, &[400.0, 565.685, 800.0, 1131.37, 1600.0][..], 1.9..=2.1, 1.5e-5),
            (Method::Rk4, &[70.711, 100.0, 141.421, 200.0], 3.5..=f64::INFINITY, 1e-6),
        ] {
            let found = orders(&scene, period, method, divisions);
            println!("{name}, {method:?}: orders and last errors {found:.3?}");
            assert_eq!(found.len(), if name == "sliding" { 3 } else { 4 });
            for (order, last) in found {
                assert!(wanted.contains(&order), "{name}, {method:?}: order {order}");
                assert!(last < most, "{name}, {method:?}: {last:e} at the last step");
            }
        }
    }
}

/// The ledgers of motion and of circuit close each by itself, and with the lateral force their sum: at
/// the order of the method, whatever the load and the law.
#[test]
fn the_energy_ledgers_close_at_the_order_of_the_method() {
    let divisions = [400.0, 800.0, 1600.0];
    for law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
        for lateral in [false, true] {
            for (frequency, resistance) in [(18.373, 1e8), (10.0, 1e6), (10.0, 0.0), (10.0, f64::INFINITY)] {
                let scene = sliding(|scene, model| {
                    model.parameters.force_law = law;
                    model.parameters.lateral_force = lateral;
                    model.parameters.charge_density_c_per_m2 = 20e-6;
                    scene.load = resistor(resistance);
                    scene.excitation = sine(0.33, frequency);
                    scene.run = periods(frequency, 20, 10);
                });
                for (method, expected, most) in
                    [(Method::TrBdf2, 1.8..=2.2, 1e-5), (Method::Rk4, 3.5..=6.0, 1e-7)]
                {
                    // There it would not be stable.
                    if method == Method::Rk4 && resistance == 1e6 {
                        continue;
                    }
                    // Beyond 400 steps a period only roundings are left of the explicit method.
                    let scale = if method == Method::Rk4 { 0.25 } else { 1.0 };
                    let points = divisions.map(|division| {
                        let step = 1.0 / (frequency * division * scale);
                        let (outcome, motion) = slide(&scene, &Options { method, ..fixed(step) });
                        assert!(motion.amplitude_m > Some(1e-4) && outcome.events > 20);
                        (step, value(outcome.energy_residual))
                    });
                    let order = order(&points);
                    println!(
                        "{law:?}, lateral force {lateral}, {resistance:e} Ω, {method:?}: residuals {:.1e} {:.1e} {:.1e}, order {order:.2}",
                        points[0].1, points[1].1, points[2].1
                    );
                    assert!(expected.contains(&order), "{law:?} {lateral} {resistance}: order {order}");
                    assert!(points[1].1 < most, "{law:?} {lateral} {resistance}: {:e}", points[1].1);
                }
            }
        }
    }
}
