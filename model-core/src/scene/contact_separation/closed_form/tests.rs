//! Against published limits, and against the equations by other means.

use super::*;
use crate::part::force_law::AnyForceLaw;
use crate::part::load::AnyLoad;
use crate::part::parasitic::ParasiticCapacitance;
use crate::part::restitution::{AnyRestitution, ConstantRestitution};
use crate::part::stick_charge::AnyStickCharge;
use crate::scene::contact_separation::{AnyParts, Parameters};

const GRAVITY: f64 = 9.81;

/// Table 2 of the paper, with a charge density in µC/m² and a resistance in Ω.
fn scene<S: Scalar>(density: f64, ohms: f64, law: AnyForceLaw) -> ContactSeparation<S, AnyParts<S::Build>> {
    Parameters {
        mass: S::literal(5e-3),
        stiffness: S::literal(80.0),
        damping_ratio: S::literal(0.005),
        initial_gap: S::literal(3e-3),
        electrode_area: S::literal(4e-4),
        dielectric_thickness: S::literal(5e-5),
        relative_permittivity: S::literal(2.0),
        charge_density: S::literal(1e-6 * density),
        parasitic: ParasiticCapacitance { farads: S::literal(1e-12) },
        load: AnyLoad { ohms: S::literal(ohms) },
        force_law: law,
        restitution: AnyRestitution::Constant(ConstantRestitution { coefficient: S::literal(0.7) }),
        sticking: AnyStickCharge::Frozen,
    }
    .build()
    .expect("valid")
}

#[test]
fn probe() {
    for (d, r) in [(5.0, 1e6), (20.0, 1e6), (35.0, 1e6), (50.0, 1e6), (50.0, 1e8)] {
        let s = scene::<f64>(d, r, AnyForceLaw::TransferredCharge);
        println!("{d} {r} eq {:?}", s.equilibrium().gap);
        for f in [18.0, 18.8, 19.0, 20.2, 22.0] {
            println!("   {f} {:?}", s.closed_form(0.2 * GRAVITY, f));
        }
        let best = (0..4000)
            .map(|k| 19.0 + 0.0005 * f64::from(k))
            .max_by(|a, b| {
                s.closed_form(0.005 * GRAVITY, *a)
                    .amplitude
                    .total_cmp(&s.closed_form(0.005 * GRAVITY, *b).amplitude)
            })
            .unwrap();
        println!("  peak {best} {:?}", s.closed_form(0.005 * GRAVITY, best));
    }
}

#[test]
fn debug() {
    let s = scene::<f64>(50.0, 1e7, AnyForceLaw::TransferredCharge);
    for (a, f) in [(0.4905, 19.2), (0.981, 19.0), (0.981, 19.6), (1.962, 18.0)] {
        println!("{:?}", s.closed_form(a, f));
    }
}
