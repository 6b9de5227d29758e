//! The equations against another form of themselves, and their derivative against differences.

use super::*;
use crate::triboelectric::tests::check_jacobian;

fn physics(force_law: ForceLaw, resistance_ohm: f64, charge_c: Option<f64>) -> (Physics, Motion) {
    let parameters = crate::contact_separation::tests::table_2(50e-6, force_law);
    let start = TriboelectricStart { charge_c, ..Default::default() };
    Physics::new(&parameters, Load::Resistor { resistance_ohm }, &start)
}

/// The charge form of the same equations, straight from (23): the derivation must agree.
#[test]
fn voltage_rate_agrees_with_the_charge_equation() {
    let (physics, _) = physics(ForceLaw::TransferredCharge, 1e8, None);
    let motion = Motion { position: 0.7e-3, velocity: 0.05, voltage: 23.0, ..Motion::default() };
    let spacing = motion.position + physics.dielectric;
    let c = physics.permittivity_area;
    let q = physics.charge(&motion);
    let v_again = (physics.tribo_charge * motion.position - q * spacing) / c;
    assert!((v_again - 23.0).abs() < 1e-9);
    let q_rate = (23.0 / 1e8 + physics.parasitic * (physics.tribo_charge - q) * motion.velocity / c)
        / (1.0 + physics.parasitic * spacing / c);
    let voltage_rate = (physics.tribo_charge * motion.velocity - q_rate * spacing - q * motion.velocity) / c;
    let [_, _, ours, _] = physics.rates(&motion, 0.0);
    assert!((ours / voltage_rate - 1.0).abs() < 1e-9, "{ours} {voltage_rate}");
}

#[test]
fn the_jacobian_is_the_derivative_of_the_rates() {
    for force_law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
        for resistance in [0.0, 1e8, f64::INFINITY] {
            let (physics, start) = physics(force_law, resistance, None);
            let voltage = if start.voltage == 0.0 { 0.0 } else { 11.0 };
            let at = Motion { position: 0.2e-3, velocity: -0.03, voltage, ..start };
            check_jacobian(&physics, &at, &format!("{force_law:?} {resistance}"));
        }
    }
}

#[test]
fn an_open_circuit_holds_its_total_charge() {
    let (physics, start) = physics(ForceLaw::GapField, f64::INFINITY, Some(1.2e-8));
    let total = |motion: &Motion| physics.charge(motion) - physics.parasitic * physics.voltage(motion);
    let before = total(&start);
    let after = total(&Motion { position: 0.1e-3, ..start });
    assert!((after / before - 1.0).abs() < 1e-12);
    assert!((physics.charge(&start) / 1.2e-8 - 1.0).abs() < 1e-12);
}

#[test]
fn a_tiny_resistance_continues_the_dynamic_circuit() {
    let motion = Motion { position: 0.4e-3, velocity: 0.05, ..Motion::default() };
    let (fast, _) = physics(ForceLaw::TransferredCharge, 1e-10, None);
    assert_eq!(fast.load.kind, CircuitKind::QuasiStatic);
    // The dynamic circuit's voltage at rest, V' = 0, with a resistance just large enough.
    let (slow, _) = physics(ForceLaw::TransferredCharge, 1e-3, None);
    assert_eq!(slow.load.kind, CircuitKind::Dynamic);
    let quasi = fast.voltage(&motion) * 1e7;
    let rest = slow.rates(&Motion { voltage: quasi, ..motion }, 0.0)[2];
    let driven = slow.rates(&motion, 0.0)[2];
    assert!((rest / driven).abs() < 1e-9, "{rest} {driven}");
}
