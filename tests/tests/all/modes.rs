//! The modes that the host derives for its reader, the reference and the peers, against those of the core, which has another
//! derivation. The identities of modes are asserted of the core's.

use cross_crate_tests::{assert_close, shipped, sliding};
use host_bench::embedded::bump_stop_parameters;
use host_bench::scene_file::modes::{BumpStopModes, Cantilever};
use host_bench::scene_file::{Bimorph, Model, StopParameters, TipMassParameters};
use model_core::part::beam;

/// Bodies at the tip, none among them, in masses and lengths of the beam; layers; places of the stop.
#[test]
fn the_modes_of_beam_and_rod_are_those_of_the_core() {
    let bodies: [Option<[f64; 3]>; 6] = [
        None,
        Some([0.0; 3]),
        Some([0.01, 0.1, 0.1]),
        Some([1.0, 0.0, 0.0]),
        Some([10.0, 0.3, 0.4]),
        Some([300.0, 0.1, 0.2]),
    ];
    let scene = shipped("bump-stop", &[]);
    let Model::BumpStop(shipped) = &scene.model else { panic!("another scene") };
    for (index, body) in bodies.into_iter().enumerate() {
        for (beam_modes, rod_modes, place) in [(3, 0, 1.0), (6, 2, 0.5), (10, 10, 0.8), (20, 20, 1.0)] {
            let (mut from, mut model) = (shipped.parameters, shipped.clone());
            let (length, beam_mass) = (from.beam_length_m, 3.9125e-3);
            from.beam_modes = beam_modes;
            from.transducer = [None, Some(Bimorph::Series)][index % 2];
            from.tip_mass = body.map(|[mass, gyration, offset]| TipMassParameters {
                mass_kg: mass * beam_mass,
                rotary_inertia_kg_m2: mass * beam_mass * (gyration * length).powi(2),
                offset_m: offset * length,
            });
            let stop = shipped.stop.expect("there is a stop");
            model.stop = Some(StopParameters { rod_modes, position_m: place * length, ..stop });
            model.parameters = from;
            let host = BumpStopModes::new(&from, model.stop.as_ref());
            let core = bump_stop_parameters::<f64>(&model, scene.load);
            let section = core.section();
            assert_close("stiffness", host.bending_stiffness, section.bending_stiffness, 1e-13);
            assert_close("mass", host.beam_mass, section.mass_per_length * length, 1e-13);
            assert_close("capacitance", host.capacitance, section.capacitance_per_length * length, 1e-13);
            assert_eq!(host.beam.len(), beam_modes);
            for (number, mode) in (1..).zip(&host.beam) {
                let own = core.beam_mode(number);
                let [clamp, at_stop, tip] = [0.0, place, 1.0].map(|at| own.shape(at));
                let what = format!("{body:?}, mode {number}");
                assert_close(&what, mode.angular_frequency, own.angular_frequency, 1e-10);
                // The shape of a heavy body's tip is small beside its largest value, that of the curvature at the clamp.
                let largest = clamp.curvature.abs() / own.eigenvalue.powi(2);
                let pairs = [
                    (mode.participation, own.base_coupling, own.base_coupling.abs()),
                    (mode.clamp_curvature * length * length, clamp.curvature, clamp.curvature.abs()),
                    (mode.at_tip, tip.value, largest),
                    (mode.at_stop, at_stop.value, largest),
                    (mode.coupling * length / section.coupling, tip.slope, largest * own.eigenvalue),
                ];
                for (found, expected, scale) in pairs {
                    assert!((found - expected).abs() < 1e-8 * scale, "{what}: {found} instead of {expected}");
                }
            }
            let scene = core.build_first::<20, 20>(beam_modes, rod_modes).expect("in bounds");
            // The host takes the modes from the static compliance, and so loses digits of what is left.
            let left = host.beam_residual + host.rod_residual - scene.contact_stiffness().recip();
            let whole = (place * length).powi(3) / (3.0 * section.bending_stiffness);
            assert!(left.abs() < 1e-9 * whole, "{body:?}: {left:e} of {whole:e} m/N");
            let bending = core.clamp_bending::<20, 20>(beam_modes, rod_modes).expect("in bounds");
            let whole = [place * length, 0.5 * host.beam_mass * length, section.coupling];
            for (index, (residual, whole)) in host.clamp_residual.into_iter().zip(whole).enumerate() {
                let [force, base, voltage] = [0, 1, 2].map(|which| f64::from(u8::from(which == index)));
                let found = -bending.curvature(&[0.0; 40], force, base, voltage);
                let scale = whole / section.bending_stiffness;
                assert!((found - residual).abs() < 1e-6 * scale, "{body:?} {index}: {residual} {found}");
            }
        }
    }
}

#[test]
fn the_mode_of_a_beam_with_a_slider_is_that_of_the_core() {
    for mass in [1e-12, 1e-4, 8e-3, 1.0, 1e3] {
        let scene = sliding(|_, model| model.parameters.slider_mass_kg = mass);
        let from = scene.sliding().expect("a sliding scene").parameters;
        let section = from.beam_width_m * from.beam_thickness_m;
        let beam = beam::Cantilever {
            length: from.beam_length_m,
            bending_stiffness: from.young_modulus_pa * section * from.beam_thickness_m.powi(2) / 12.0,
            mass_per_length: from.density_kg_per_m3 * section,
            tip_mass: mass,
        };
        let (host, core) = (Cantilever::new(&from), beam.mode(1));
        let tip = core.shape(1.0).value;
        assert_close("frequency", host.angular_frequency, core.angular_frequency, 1e-12);
        assert_close("modal mass", host.modal_mass, tip.powi(-2), 1e-11);
        assert_close("participation", host.participation, core.base_coupling * tip, 1e-11);
    }
}

/// Erturk and Inman, J. Vib. Acoust. 130 (2008): 47.8 and 299.6 Hz short-circuit, 48.8 and 301.5 Hz open.
#[test]
fn the_published_unimorph() {
    let scene = shipped(
        "bump-stop-none",
        &[
            ("parameters.beam_length_m", "100e-3"),
            ("parameters.beam_width_m", "20e-3"),
            ("parameters.substrate_thickness_m", "0.5e-3"),
            ("parameters.substrate_young_modulus_pa", "100e9"),
            ("parameters.substrate_density_kg_per_m3", "7165"),
            ("parameters.piezo_thickness_m", "0.4e-3"),
        ],
    );
    let Model::BumpStop(model) = &scene.model else { panic!("another scene") };
    let host = BumpStopModes::new(&model.parameters, None);
    assert_close("capacitance", host.capacitance, 79.65e-9, 1e-12);
    assert_close("bending stiffness", host.bending_stiffness, 0.097_847, 1e-5);
    let core = bump_stop_parameters::<f64>(model, scene.load).build::<10, 0>().expect("in bounds");
    let [short, _] = host.natural_frequencies_hz();
    for (number, published) in [47.8, 299.6].into_iter().enumerate() {
        assert!((short[number] - published).abs() < 0.1, "{} {published}", short[number]);
    }
    for (index, published) in [48.8, 301.5].into_iter().enumerate() {
        let open = core.open_circuit_angular_frequency(index).expect("a mode") / std::f64::consts::TAU;
        assert!((open - published).abs() < 0.1, "{open} {published}");
    }
    for (found, expected) in short.iter().zip([47.809, 299.615, 838.931]) {
        assert_close("natural frequency", *found, expected, 2e-5);
    }
}
