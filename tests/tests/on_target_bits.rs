//! The firmware's workload, made of compile-time parts, beside the run-time form that the host uses.
//!
//! That the bits on each core are those of the host is checked by `host-bench on-target`, which has
//! the cores; this needs none.

use std::path::Path;

use firmware_example::node::{FlashTrace, Node};
use firmware_example::workload::contact_separation::ContactSeparationRun;
use firmware_example::workload::{Progress, Workload, scenes};
use host_bench::embedded::contact_separation_parameters;
use host_bench::scene_file;
use model_core::integrate::{Adaptive, AnyStepControl, TrBdf2};
use model_core::scalar::Polynomial;

fn states(mut workload: impl Workload) -> Vec<Vec<u32>> {
    let mut states = Vec::new();
    while let Progress::Sample { steps, .. } = workload.advance() {
        assert!(steps > 0);
        states.push(workload.state().to_vec());
    }
    states
}

#[test]
fn parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-bench/scenes/contact-separation.toml");
    let scene = scene_file::read(&file, &[]).expect("the shipped scene is valid");
    let model = scene.contact_separation().expect("a contact-separation scene");
    let parameters = contact_separation_parameters::<f32, Polynomial>(model, scene.load);
    let control = AnyStepControl::Adaptive(Adaptive::new(scenes::TOLERANCE));
    let any = ContactSeparationRun::new(scenes::IMPACTING, parameters, TrBdf2, control).expect("valid");

    let firmware = states(scenes::bench().expect("valid"));
    assert_eq!(firmware.len(), 12);
    assert_eq!(states(any), firmware);
}

#[test]
fn the_node_reports_each_second_until_its_samples_end() {
    let mut node = Node::new(FlashTrace::default()).expect("valid");
    for second in 1..=FlashTrace::SECONDS {
        let report = node.second().expect("there are samples");
        assert_eq!(report.second, second);
        assert!(report.mean_power > 1e-6 && report.mean_power < 1e-4, "{report:?}");
    }
    assert!(node.second().is_err());
}
