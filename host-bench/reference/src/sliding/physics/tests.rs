//! The equations against another form of themselves, and their derivatives against differences.

use super::*;
use crate::triboelectric::tests::check_jacobian;

const LAWS: [ForceLaw; 2] = [ForceLaw::TransferredCharge, ForceLaw::GapField];

fn physics(force_law: ForceLaw, resistance_ohm: f64, charge_c: Option<f64>) -> (Physics, Motion) {
    let parameters =
        SlidingParameters { lateral_force: true, ..crate::sliding::tests::table_1(80e-6, force_law) };
    let start = TriboelectricStart { position_m: Some(4e-3), charge_c, ..Default::default() };
    Physics::new(&parameters, Load::Resistor { resistance_ohm }, &start)
}

/// The charge form of the same equations, straight from (12) to (15): the derivation must agree.
#[test]
fn voltage_rate_agrees_with_the_charge_equation() {
    let (physics, start) = physics(ForceLaw::TransferredCharge, 1e8, None);
    for (displacement, side) in [(7e-3, 1.0), (-3e-3, -1.0)] {
        let branch = Branch { direction: 1.0, side };
        let motion = Motion { position: displacement, velocity: 0.4, voltage: 23.0, branch, ..start };
        let [s1, s2, slope] = {
            let overlap = physics.overlap(&motion);
            [overlap.active, overlap.inert, overlap.slope]
        };
        let capacitance = VACUUM_PERMITTIVITY * 2.0 * std::f64::consts::PI * 1e-4 * s1 / 0.05e-3;
        let open_voltage = 80e-6 * 0.05e-3 * s2 / (VACUUM_PERMITTIVITY * 2.0 * s1);
        let charge = physics.charge(&motion);
        assert!((open_voltage - charge / capacitance - 23.0).abs() < 1e-9);
        // V' = V_oc' − q'/C + q C'/C², of which V_oc' = −(V_oc / (s1 s2)) s1' as s1 + s2 = 1.
        let open_rate = -open_voltage / (s1 * s2) * slope * 0.4;
        let rate = open_rate - 23.0 / 1e8 / capacitance + charge / capacitance * slope / s1 * 0.4;
        let [_, _, ours, _] = physics.rates(&motion, 0.0);
        assert!((ours / rate - 1.0).abs() < 1e-9, "{ours} {rate}");
    }
    // Without a charge given there is no voltage.
    assert_eq!(start.voltage, 0.0);
}

#[test]
fn the_jacobian_is_the_derivative_of_the_rates() {
    for force_law in LAWS {
        for (resistance, charge) in
            [(0.0, None), (1e-7, None), (1e8, Some(1e-9)), (f64::INFINITY, Some(1e-9))]
        {
            let (physics, start) = physics(force_law, resistance, charge);
            let branch = Branch { direction: 1.0, side: -1.0 };
            let at = Motion { position: -6e-3, velocity: 0.3, branch, ..start };
            check_jacobian(&physics, &at, &format!("{force_law:?} {resistance}"));
        }
    }
}

/// The force along the patches is the fall of the energy with the displacement at constant charge, and
/// the current its fall with the charge: `−dW/dx` and `V = −dW/dq` of `W = (q − σS s2)² / (2 c s1)`.
#[test]
fn the_field_force_is_the_gradient_of_the_energy() {
    let (physics, _) = physics(ForceLaw::GapField, 1e8, None);
    let area = std::f64::consts::PI * 1e-4;
    let full = VACUUM_PERMITTIVITY * 2.0 * area / 0.05e-3;
    let energy = |displacement: f64, charge: f64, side: f64| {
        let overlap = Overlap::at(displacement, 10e-3, side);
        (charge - 80e-6 * area * overlap.inert).powi(2) / (2.0 * full * overlap.active)
    };
    for (displacement, side, voltage) in [(5e-3, 1.0, 40.0), (-8e-3, -1.0, -90.0), (2e-3, 1.0, -15.0)] {
        let branch = Branch { direction: 0.0, side };
        let motion = Motion { position: displacement, voltage, branch, ..Motion::default() };
        let charge = physics.charge(&motion);
        let step = 1e-6;
        let force = (energy(displacement - step, charge, side) - energy(displacement + step, charge, side))
            / (2.0 * step);
        let ours = physics.field_force(&motion, &physics.overlap(&motion));
        assert!((ours / force - 1.0).abs() < 1e-5, "{ours} {force}");
        let step = 1e-3 * full * voltage;
        let potential = (energy(displacement, charge - step, side)
            - energy(displacement, charge + step, side))
            / (2.0 * step);
        assert!((potential / voltage - 1.0).abs() < 1e-9, "{potential} {voltage}");
        assert!((physics.energies(&motion)[1] / energy(displacement, charge, side) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn an_open_circuit_holds_its_charge() {
    let (physics, start) = physics(ForceLaw::GapField, f64::INFINITY, Some(3e-9));
    let branch = Branch { direction: 0.0, side: -1.0 };
    let moved = Motion { position: -9e-3, branch, ..start };
    assert_eq!((physics.charge(&start), physics.charge(&moved)), (3e-9, 3e-9));
    let overlap = physics.overlap(&moved);
    let charge =
        physics.tribo_charge * overlap.inert - physics.capacitance * overlap.active * physics.voltage(&moved);
    assert!((charge / 3e-9 - 1.0).abs() < 1e-12);
}

#[test]
fn a_tiny_resistance_continues_the_dynamic_circuit() {
    let branch = Branch { direction: 1.0, side: 1.0 };
    let motion = Motion { position: 4e-3, velocity: 0.5, branch, ..Motion::default() };
    let (fast, _) = physics(ForceLaw::TransferredCharge, 1e-7, None);
    assert_eq!(fast.load.kind, CircuitKind::QuasiStatic);
    // The dynamic circuit's voltage at rest, V' = 0, with a resistance just large enough.
    let (slow, _) = physics(ForceLaw::TransferredCharge, 1.0, None);
    assert_eq!(slow.load.kind, CircuitKind::Dynamic);
    let quasi = fast.voltage(&motion) * 1e7;
    let rest = slow.rates(&Motion { voltage: quasi, ..motion }, 0.0)[2];
    let driven = slow.rates(&motion, 0.0)[2];
    assert!((rest / driven).abs() < 1e-7, "{rest} {driven}");
}

#[test]
fn the_lens_has_its_known_areas_and_slopes() {
    let radius = 10e-3;
    let middle = Overlap::at(0.0, radius, 1.0);
    assert_eq!((middle.active, middle.inert), (1.0, 0.0));
    // Two discs, the centre of one on the edge of the other: 2/3 − √3/(2π) of a disc.
    let edge = Overlap::at(-radius, radius, -1.0);
    assert!((edge.active - (2.0 / 3.0 - 3f64.sqrt() / (2.0 * PI))).abs() < 1e-15);
    let step = 1e-7;
    for (displacement, side) in [(3e-3, 1.0), (-12e-3, -1.0), (19e-3, 1.0), (-1e-4, 1.0)] {
        let [behind, here, ahead] =
            [-step, 0.0, step].map(|shift| Overlap::at(displacement + shift, radius, side));
        let slope = (ahead.active - behind.active) / (2.0 * step);
        let curvature = (ahead.slope - behind.slope) / (2.0 * step);
        assert!((slope / here.slope - 1.0).abs() < 1e-7, "{displacement}");
        assert!((curvature - here.curvature).abs() < 1e-6 * here.curvature.abs() + 1e-4);
        assert!((here.active + here.inert - 1.0).abs() < 1e-15);
    }
}
