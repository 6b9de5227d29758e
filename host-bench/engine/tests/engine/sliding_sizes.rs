//! The smallest and the largest sliding harvester.

use harvester_engine::embedded::sliding_parameters;
use harvester_scene::scene_file::{self, Load, Sliding, SlidingParameters};

/// A micromachined beam takes the least of each size, a bridge of steel the most, and single precision holds the
/// coefficients of both.
#[test]
fn the_smallest_and_the_largest_sliding_harvester_can_be_built_in_single_precision() {
    let scene = scene_file::read_shipped("sliding", &[]).expect("the shipped scene");
    let shipped = scene.sliding().expect("a sliding scene");
    let load = Load::Resistor { resistance_ohm: 1e8 };
    // Length, width, thickness, Young's modulus, density, slider, radius, dielectric, permittivity, charge.
    for sizes in [
        [1e-3, 1e-5, 1e-7, 1e11, 1.0, 1e-12, 1e-6, 1e-9, 1.0, 1e-2],
        [1e-3, 1e-5, 1e-7, 1e5, 1.0, 1e-12, 1e-6, 0.1, 1e5, 0.0],
        [10.0, 10.0, 1.0, 1e13, 1e5, 1e3, 1.0, 1e-9, 1e5, 1e-2],
        [10.0, 10.0, 1.0, 1e13, 1.0, 1e-12, 1.0, 0.1, 1.0, 1e-2],
    ] {
        let parameters = SlidingParameters {
            beam_length_m: sizes[0],
            beam_width_m: sizes[1],
            beam_thickness_m: sizes[2],
            young_modulus_pa: sizes[3],
            density_kg_per_m3: sizes[4],
            slider_mass_kg: sizes[5],
            patch_radius_m: sizes[6],
            dielectric_thickness_m: sizes[7],
            relative_permittivity: sizes[8],
            charge_density_c_per_m2: sizes[9],
            ..shipped.parameters
        };
        let model = Sliding { parameters, ..shipped.clone() };
        let single = sliding_parameters::<f32>(&model, load).build().expect("builds in f32");
        let double = sliding_parameters::<f64>(&model, load).build().expect("builds in f64");
        let (single, double) = (f64::from(single.modal_mass()), double.modal_mass());
        assert!((single / double - 1.0).abs() < 1e-4, "{sizes:?}: {single:e} kg, {double:e} kg");
    }
}
