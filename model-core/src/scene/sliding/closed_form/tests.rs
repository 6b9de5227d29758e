//! Against published limits.

use super::*;
use crate::part::load::AnyLoad;
use crate::part::stick_charge::AnyStickCharge;
use crate::scene::sliding::{AnyForceLaw, AnyLateralForce, AnyParts, Parameters, PatchFriction};

const GRAVITY: f64 = 9.81;

fn scene<S: Scalar>(density: f64, ohms: f64, mu: [f64; 4], zeta: f64) -> Sliding<S, AnyParts> {
    let n = S::literal;
    Parameters {
        beam_length: n(0.1),
        beam_width: n(0.02),
        beam_thickness: n(0.5e-3),
        young_modulus: n(210e9),
        density: n(7800.0),
        damping_ratio: n(zeta),
        slider_mass: n(8e-3),
        patch_radius: n(0.01),
        friction: PatchFriction {
            static_active: n(mu[0]),
            static_inert: n(mu[1]),
            kinetic_active: n(mu[2]),
            kinetic_inert: n(mu[3]),
        },
        dielectric_thickness: n(5e-5),
        relative_permittivity: n(2.0),
        charge_density: n(1e-6 * density),
        load: AnyLoad { ohms: n(ohms) },
        force_law: AnyForceLaw::TransferredCharge,
        sticking: AnyStickCharge::Frozen,
        lateral_force: AnyLateralForce::None,
    }
    .build()
    .expect("valid")
}

#[test]
fn probe() {
    let mu = [0.35, 0.25, 0.3, 0.2];
    let fn_ = scene::<f64>(0.0, 0.0, mu, 0.0035).angular_frequency / core::f64::consts::TAU;
    for d in [0.0, 10.0, 20.0, 40.0, 80.0, 120.0] {
        for r in [0.0, 1e12] {
            println!("{d} {r} {:?}", scene::<f64>(d, r, mu, 0.0035).closed_form(0.36 * GRAVITY, fn_));
        }
    }
    for f in [14.0, 16.0, 22.0, 25.0] {
        println!("{f} {:?}", scene::<f64>(0.0, 0.0, [0.2; 4], 0.0).closed_form(0.36 * GRAVITY, f));
    }
    for d in [20.0, 120.0] {
        for r in [0.0, 1e5, 1e6, 1e7, 5e7, 1e8, 1e9, 1e10] {
            let s = scene::<f64>(d, r, mu, 0.0035);
            let best = (0..2000)
                .map(|k| fn_ - 0.04 + 0.00003 * f64::from(k))
                .max_by(|a, b| {
                    s.closed_form(0.36 * GRAVITY, *a)
                        .amplitude
                        .total_cmp(&s.closed_form(0.36 * GRAVITY, *b).amplitude)
                })
                .unwrap();
            println!("{d} {r} {:.5} {:?}", best - fn_, s.closed_form(0.36 * GRAVITY, best));
        }
    }
}
