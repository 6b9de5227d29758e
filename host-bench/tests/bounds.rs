//! What a scene file may say and what the core accepts must be the same.

#[path = "bounds/bump_stop.rs"]
mod bump_stop;

use std::path::Path;

use host_bench::embedded::{contact_separation_parameters, sliding_parameters};
use host_bench::scene_file::{
    self, ContactSeparationParameters, Load, Model, Override, Restitution, Sliding, SlidingParameters,
};
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

type SlidingField = fn(&mut SlidingParameters) -> &mut f64;

const SLIDING_FIELDS: [(&str, SlidingField, [f64; 2]); 15] = [
    ("beam_length_m", |p| &mut p.beam_length_m, [1e-4, 10.0]),
    ("beam_width_m", |p| &mut p.beam_width_m, [1e-5, 10.0]),
    ("beam_thickness_m", |p| &mut p.beam_thickness_m, [1e-7, 1.0]),
    ("young_modulus_pa", |p| &mut p.young_modulus_pa, [1e5, 1e13]),
    ("density_kg_per_m3", |p| &mut p.density_kg_per_m3, [1.0, 1e5]),
    ("damping_ratio", |p| &mut p.damping_ratio, [0.0, 10.0]),
    ("slider_mass_kg", |p| &mut p.slider_mass_kg, [1e-12, 1e3]),
    ("patch_radius_m", |p| &mut p.patch_radius_m, [1e-6, 1.0]),
    // Not below the kinetic ones of the shipped scene, and those not above the static ones.
    ("static_friction_active", |p| &mut p.static_friction_active, [0.3, 10.0]),
    ("static_friction_inert", |p| &mut p.static_friction_inert, [0.2, 10.0]),
    ("kinetic_friction_active", |p| &mut p.kinetic_friction_active, [0.0, 0.35]),
    ("kinetic_friction_inert", |p| &mut p.kinetic_friction_inert, [0.0, 0.25]),
    ("dielectric_thickness_m", |p| &mut p.dielectric_thickness_m, [1e-9, 0.1]),
    ("relative_permittivity", |p| &mut p.relative_permittivity, [1.0, 1e5]),
    ("charge_density_c_per_m2", |p| &mut p.charge_density_c_per_m2, [0.0, 1e-2]),
];

fn read(key: &str, value: f64) -> Result<scene_file::Scene, scene_file::SceneError> {
    let shipped = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/contact-separation.toml"));
    scene_file::read(shipped, &[Override::new(key, &format!("{value:e}"))])
}

fn read_sliding(key: &str, value: f64) -> Result<scene_file::Scene, scene_file::SceneError> {
    let shipped = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/sliding.toml"));
    scene_file::read(shipped, &[Override::new(key, &format!("{value:e}"))])
}

/// The shipped sliding scene.
fn shipped_sliding() -> (Sliding, Load) {
    let scene = read_sliding("excitation.phase_rad", 0.0).expect("the shipped scene");
    let Model::Sliding(model) = scene.model else { panic!("a sliding scene") };
    (model, scene.load)
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

#[test]
fn sliding_parameters_have_the_bounds_of_the_core() {
    let (model, load) = shipped_sliding();
    for (key, field, bounds) in SLIDING_FIELDS {
        for (value, inside) in around(bounds) {
            let mut changed = model.clone();
            *field(&mut changed.parameters) = value;
            let core = sliding_parameters::<f64>(&changed, load).build();
            let file = read_sliding(&format!("parameters.{key}"), value);
            assert_eq!(core.is_ok(), file.is_ok(), "{key} = {value:e}: {:?} {:?}", core.err(), file.err());
            // Inside its bounds a value may still give no frequency: a long beam, or a heavy slider.
            assert!(inside || core.is_err(), "{key} = {value:e}");
        }
    }
}

/// What the shipped scene's frequency hides: a micromachined beam takes the least of each size, a
/// bridge of steel the most, and single precision holds the coefficients of both.
#[test]
fn the_smallest_and_the_largest_sliding_harvester_can_be_built_in_single_precision() {
    let (model, load) = shipped_sliding();
    // Length, width, thickness, Young's modulus, density, slider, radius, dielectric, permittivity, charge.
    for sizes in [
        [1e-3, 1e-5, 1e-7, 1e11, 1.0, 1e-12, 1e-6, 1e-9, 1.0, 1e-2],
        [1e-3, 1e-5, 1e-7, 1e5, 1.0, 1e-12, 1e-6, 0.1, 1e5, 0.0],
        [10.0, 10.0, 1.0, 1e13, 1e5, 1e3, 1.0, 1e-9, 1e5, 1e-2],
        [10.0, 10.0, 1.0, 1e13, 1.0, 1e-12, 1.0, 0.1, 1.0, 1e-2],
    ] {
        let mut changed = model.clone();
        let parameters = &mut changed.parameters;
        for ((_, field, _), size) in
            [0, 1, 2, 3, 4, 6, 7, 12, 13, 14].map(|index| SLIDING_FIELDS[index]).into_iter().zip(sizes)
        {
            *field(parameters) = size;
        }
        let single = sliding_parameters::<f32>(&changed, load).build().expect("builds in f32");
        let double = sliding_parameters::<f64>(&changed, load).build().expect("builds in f64");
        let (single, double) = (f64::from(single.modal_mass()), double.modal_mass());
        assert!((single / double - 1.0).abs() < 1e-4, "{sizes:?}: {single:e} kg, {double:e} kg");
    }
}
