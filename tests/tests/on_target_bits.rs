//! The firmware's workload, made of compile-time parts, beside the run-time form that the host uses.
//!
//! That the bits on each core are those of the host is checked by `host-bench on-target`, which has
//! the cores; this needs none.

use std::path::Path;

use firmware_example::workload::bump_stop::modal_run::ModalRun;
use firmware_example::workload::hybrid_run::HybridRun;
use firmware_example::workload::{Progress, Workload, bump_stop, contact_separation, sliding};
use host_bench::embedded::{bump_stop_parameters, contact_separation_parameters, sliding_parameters};
use host_bench::scene_file::{self, Model, Scene};
use model_core::integrate::{Adaptive, AnyStepControl, FixedStep, RungeKutta4, TrBdf2};
use model_core::scalar::Polynomial;
use model_core::scene::bump_stop::AnyChoices;

fn states(workload: &mut dyn Workload) -> Vec<Vec<u32>> {
    let mut states = Vec::new();
    while let Progress::Sample { steps, .. } = workload.advance() {
        assert!(steps > 0);
        states.push(workload.state().to_vec());
    }
    states
}

fn shipped(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-bench/scenes");
    scene_file::read(&folder.join(name), &[]).expect("the shipped scene is valid")
}

#[test]
fn parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    let scene = shipped("contact-separation.toml");
    let model = scene.contact_separation().expect("a contact-separation scene");
    let parameters = contact_separation_parameters::<f32, Polynomial>(model, scene.load);
    let control =
        AnyStepControl::Adaptive(Adaptive::new(contact_separation::scenes::TOLERANCE).expect("in bounds"));
    let plan = contact_separation::scenes::IMPACTING;
    let mut any = HybridRun::new(plan, parameters, TrBdf2, control).expect("valid");

    let firmware = states(&mut contact_separation::scenes::bench().expect("valid"));
    assert_eq!(firmware.len(), 12);
    assert_eq!(states(&mut any), firmware);
}

#[test]
fn sliding_parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    let scene = shipped("sliding.toml");
    let Model::Sliding(model) = &scene.model else { panic!("a sliding scene") };
    let parameters = sliding_parameters::<f32>(model, scene.load);
    let step = AnyStepControl::Fixed(FixedStep::of_seconds(sliding::scenes::STEP).expect("in bounds"));
    let adaptive = AnyStepControl::Adaptive(Adaptive::new(sliding::scenes::TOLERANCE).expect("in bounds"));
    let (slide, stick_slip) = (sliding::scenes::SLIDING, sliding::scenes::STICK_SLIP);
    let any = [
        states(&mut HybridRun::new(slide, parameters, RungeKutta4, step).expect("valid")),
        states(&mut HybridRun::new(stick_slip, parameters, RungeKutta4, step).expect("valid")),
        states(&mut HybridRun::new(slide, parameters, TrBdf2, adaptive).expect("valid")),
        states(&mut HybridRun::new(stick_slip, parameters, TrBdf2, adaptive).expect("valid")),
    ];

    let mut firmware = vec![states(&mut sliding::scenes::bench().expect("valid"))];
    sliding::scenes::with_others(|workloads| {
        let workloads = workloads.expect("valid");
        firmware.extend(workloads.iter_mut().take(3).map(|workload| states(*workload)));
    });
    assert_eq!(firmware, any);
    assert!(firmware.iter().all(|states| states.len() == 12));
}

#[test]
fn bump_stop_parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    use bump_stop::scenes::{BEAM_MODES, IMPACTING, ROD_MODES, TOUCHING, bench, with_others};
    let scene = shipped("bump-stop.toml");
    let Model::BumpStop(model) = &scene.model else { panic!("a bump-stop scene") };
    let mut parameters = bump_stop_parameters::<f32>(model, scene.load);
    let mut any = |plan, gap| {
        parameters.choices.stop.gap = gap;
        states(&mut ModalRun::<AnyChoices<f32>, BEAM_MODES, ROD_MODES>::new(plan, parameters).expect("valid"))
    };

    let firmware = states(&mut bench().expect("valid"));
    assert_eq!(firmware.len(), 4);
    assert_eq!(any(IMPACTING, bump_stop::parts::GAP), firmware);
    with_others(|workloads| {
        let touching = &mut workloads.expect("valid")[0];
        assert_eq!(any(TOUCHING, 0.0), states(*touching));
    });
}
