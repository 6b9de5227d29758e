//! Of bump-stop scenes.

use std::path::Path;

use host_bench::embedded::bump_stop_parameters;
use host_bench::scene_file::{self, BumpStop, Load, Model, Override, Scene, StopParameters};

use super::around;

type Field = fn(&mut BumpStop) -> &mut f64;

fn stop_of(model: &mut BumpStop) -> &mut StopParameters {
    model.stop.as_mut().expect("the shipped scene has a stop")
}

/// The rod's width and thickness are one cross section in the core, and have bounds of their own only here.
const FIELDS: [(&str, Field, [f64; 2]); 16] = [
    ("parameters.beam_length_m", |m| &mut m.parameters.beam_length_m, [1e-4, 10.0]),
    ("parameters.beam_width_m", |m| &mut m.parameters.beam_width_m, [1e-5, 10.0]),
    ("parameters.substrate_thickness_m", |m| &mut m.parameters.substrate_thickness_m, [1e-7, 1.0]),
    ("parameters.substrate_young_modulus_pa", |m| &mut m.parameters.substrate_young_modulus_pa, [1e5, 1e15]),
    ("parameters.substrate_density_kg_per_m3", |m| &mut m.parameters.substrate_density_kg_per_m3, [1.0, 1e5]),
    ("parameters.piezo_thickness_m", |m| &mut m.parameters.piezo_thickness_m, [1e-7, 1.0]),
    ("parameters.piezo_young_modulus_pa", |m| &mut m.parameters.piezo_young_modulus_pa, [1e5, 1e15]),
    ("parameters.piezo_density_kg_per_m3", |m| &mut m.parameters.piezo_density_kg_per_m3, [1.0, 1e5]),
    (
        "parameters.piezo_permittivity_f_per_m",
        |m| &mut m.parameters.piezo_permittivity_f_per_m,
        [1e-12, 1e-6],
    ),
    ("parameters.damping_ratio", |m| &mut m.parameters.damping_ratio, [0.0, 0.9]),
    ("stop.length_m", |m| &mut stop_of(m).length_m, [1e-4, 10.0]),
    ("stop.young_modulus_pa", |m| &mut stop_of(m).young_modulus_pa, [1e5, 1e15]),
    ("stop.density_kg_per_m3", |m| &mut stop_of(m).density_kg_per_m3, [1.0, 1e5]),
    ("stop.position_m", |m| &mut stop_of(m).position_m, [1e-4, 50e-3]),
    ("stop.gap_m", |m| &mut stop_of(m).gap_m, [0.0, 1.0]),
    ("stop.contact_compliance_m_per_n", |m| &mut stop_of(m).contact_compliance_m_per_n, [0.0, 1.0]),
];

fn read(key: &str, value: f64) -> Result<Scene, scene_file::SceneError> {
    let shipped = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/bump-stop.toml"));
    scene_file::read(shipped, &[Override::new(key, &format!("{value:e}"))])
}

fn bump_stop_of(scene: &Scene) -> BumpStop {
    match &scene.model {
        Model::BumpStop(model) => model.clone(),
        Model::ContactSeparation(_) | Model::Sliding(_) => panic!("the shipped scene is a bump-stop scene"),
    }
}

#[test]
fn parameters_have_the_bounds_of_the_core() {
    let base = read("run.settle_s", 0.0).expect("the shipped scene");
    for (key, field, bounds) in FIELDS {
        for (value, inside) in around(bounds) {
            let mut changed = bump_stop_of(&base);
            *field(&mut changed) = value;
            let core = bump_stop_parameters::<f64>(&changed, base.load).build::<10, 10>();
            let file = read(key, value);
            assert!(inside || core.is_err(), "{key} = {value:e} passes the core");
            assert!(inside || file.is_err(), "{key} = {value:e} passes the file");
            assert!(file.is_err() || core.is_ok(), "{key} = {value:e}: the core refuses: {:?}", core.err());
            // Inside its bounds a value may still give a mode that cannot be stepped, or a stop beyond the
            // beam's end.
            if let (true, Err(error)) = (inside, &file) {
                let error = error.to_string();
                let explained = error.contains("frequency") || key == "parameters.beam_length_m";
                assert!(explained, "{key} = {value:e}: {error}");
            }
        }
    }
}

#[test]
fn loads_have_the_bounds_of_the_core() {
    let base = read("run.settle_s", 0.0).expect("the shipped scene");
    let limits = [(0.0, true), (f64::INFINITY, true), (f64::NAN, false), (-1.0, false)];
    for (value, inside) in around([1e-9, 1e30]).into_iter().chain(limits) {
        let load = Load::Resistor { resistance_ohm: value };
        let core = bump_stop_parameters::<f64>(&bump_stop_of(&base), load).build::<10, 10>();
        let file = read("load.resistance_ohm", value);
        assert_eq!((core.is_ok(), file.is_ok()), (inside, inside), "{value:e}: {:?}", file.err());
    }
}
