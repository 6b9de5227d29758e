//! What a scene file may say and what the core accepts must be the same.

use std::path::Path;

use host_bench::embedded::contact_separation_parameters;
use host_bench::scene_file::{self, ContactSeparationParameters, Load, Override, Restitution};
use model_core::scalar::Polynomial;

type Field = fn(&mut ContactSeparationParameters) -> &mut f64;

fn restitution(parameters: &mut ContactSeparationParameters) -> [&mut f64; 3] {
    match &mut parameters.restitution {
        Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => {
            [at_rest, at_speed, reference_speed_m_per_s]
        }
        Restitution::Constant { .. } => panic!("the shipped scene has a velocity-dependent restitution"),
    }
}

const FIELDS: [(&str, Field, [f64; 2]); 12] = [
    ("mass_kg", |p| &mut p.mass_kg, [1e-12, 1e3]),
    ("stiffness_n_per_m", |p| &mut p.stiffness_n_per_m, [1e-9, 1e9]),
    ("damping_ratio", |p| &mut p.damping_ratio, [0.0, 10.0]),
    ("initial_gap_m", |p| &mut p.initial_gap_m, [1e-9, 1.0]),
    ("electrode_area_m2", |p| &mut p.electrode_area_m2, [1e-12, 10.0]),
    ("dielectric_thickness_m", |p| &mut p.dielectric_thickness_m, [1e-9, 0.1]),
    ("relative_permittivity", |p| &mut p.relative_permittivity, [1.0, 1e5]),
    ("charge_density_c_per_m2", |p| &mut p.charge_density_c_per_m2, [0.0, 1e-2]),
    ("parasitic_capacitance_f", |p| &mut p.parasitic_capacitance_f, [0.0, 1e-3]),
    ("restitution.at_rest", |p| restitution(p).into_iter().next().expect("three"), [0.0, 1.0]),
    ("restitution.at_speed", |p| restitution(p).into_iter().nth(1).expect("three"), [0.0, 1.0]),
    (
        "restitution.reference_speed_m_per_s",
        |p| restitution(p).into_iter().nth(2).expect("three"),
        [1e-9, 1e3],
    ),
];

fn read(key: &str, value: f64) -> Result<scene_file::Scene, scene_file::SceneError> {
    let shipped = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/contact-separation.toml"));
    scene_file::read(shipped, &[Override::new(key, &format!("{value:e}"))])
}

/// Just inside and just outside of both ends, and the ends themselves.
fn around([lowest, highest]: [f64; 2]) -> [(f64, bool); 6] {
    let below = if lowest == 0.0 { -1e-300 } else { lowest * (1.0 - 1e-9) };
    let above_lowest = if lowest == 0.0 { 1e-30 } else { lowest * (1.0 + 1e-9) };
    [
        (below, false),
        (lowest, true),
        (above_lowest, true),
        (highest * (1.0 - 1e-9), true),
        (highest, true),
        (highest * (1.0 + 1e-9), false),
    ]
}

#[test]
fn parameters_have_the_bounds_of_the_core() {
    let base = read("run.settle_s", 0.0).expect("the shipped scene");
    let model = base.contact_separation().expect("the shipped scene");
    for (key, field, bounds) in FIELDS {
        for (value, inside) in around(bounds) {
            let mut changed = model.clone();
            *field(&mut changed.parameters) = value;
            let core = contact_separation_parameters::<f64, Polynomial>(&changed, base.load).build();
            let file = read(&format!("parameters.{key}"), value);
            assert_eq!(core.is_ok(), file.is_ok(), "{key} = {value:e}: {:?} {:?}", core.err(), file.err());
            // Inside its bounds a value may still give no frequency: mass and stiffness far apart.
            assert!(inside || core.is_err(), "{key} = {value:e}");
        }
    }
}

#[test]
fn loads_have_the_bounds_of_the_core() {
    let base = read("run.settle_s", 0.0).expect("the shipped scene");
    let model = base.contact_separation().expect("the shipped scene");
    let limits = [(0.0, true), (f64::INFINITY, true), (f64::NAN, false), (-1.0, false)];
    for (value, inside) in around([1e-9, 1e30]).into_iter().chain(limits) {
        let load = Load::Resistor { resistance_ohm: value };
        let core = contact_separation_parameters::<f64, Polynomial>(model, load).build();
        let file = read("load.resistance_ohm", value);
        assert_eq!(
            (core.is_ok(), file.is_ok()),
            (inside, inside),
            "{value:e}: {:?} {:?}",
            core.err(),
            file.err()
        );
    }
}
