//! The firmware's workload, made of compile-time parts, beside the run-time form that the host uses.
//!
//! That the bits on each core are those of the host is checked by `host-bench on-target`, which has
//! the cores; this needs none.

use cross_crate_tests::shipped;
use firmware_example::workload::{Progress, Visit, Workload, bump_stop, contact_separation, sliding};
use host_bench::embedded::{bump_stop_parameters, contact_separation_parameters, sliding_parameters};
use host_bench::method::{Method, Options};
use host_bench::run::run_scene;
use host_bench::scene_file::Model;
use model_core::integrate::{Adaptive, AnyStepControl, ExponentialRadau, FixedStep, RungeKutta4};
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

/// The states of each workload of a variant.
fn states_of(workloads: fn(Visit<'_>) -> Option<()>) -> Vec<Vec<Vec<u32>>> {
    let mut all = Vec::new();
    workloads(&mut |workload| all.push(states(workload))).expect("valid");
    all
}

#[test]
fn parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    let scene = shipped("contact-separation", &[]);
    let model = scene.contact_separation().expect("a contact-separation scene");
    let parameters = contact_separation_parameters::<f32, Polynomial>(model, scene.load);
    let control = AnyStepControl::Adaptive(Adaptive::new(contact_separation::TOLERANCE).expect("in bounds"));
    let plan = contact_separation::IMPACTING;
    let mut any = contact_separation::run(plan, parameters, ExponentialRadau, control).expect("valid");

    let firmware = states_of(contact_separation::bench);
    assert_eq!(firmware[0].len(), 12);
    assert_eq!([states(&mut any)], firmware[..]);
}

#[test]
fn sliding_parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    let scene = shipped("sliding", &[]);
    let model = scene.sliding().expect("a sliding scene");
    let parameters = sliding_parameters::<f32>(model, scene.load);
    let step = AnyStepControl::Fixed(FixedStep::of_seconds(sliding::STEP).expect("in bounds"));
    let adaptive = AnyStepControl::Adaptive(Adaptive::new(sliding::TOLERANCE).expect("in bounds"));
    let (slide, stick_slip) = (sliding::SLIDING, sliding::STICK_SLIP);
    let any = [
        states(&mut sliding::run(slide, parameters, ExponentialRadau, adaptive).expect("valid")),
        states(&mut sliding::run(stick_slip, parameters, ExponentialRadau, adaptive).expect("valid")),
        states(&mut sliding::run(stick_slip, parameters, RungeKutta4, step).expect("valid")),
    ];

    let mut firmware = states_of(sliding::bench);
    firmware.extend(states_of(sliding::others).into_iter().take(2));
    assert_eq!(firmware, any);
    assert!(firmware.iter().all(|states| states.len() == 12));
}

#[test]
fn bump_stop_parts_chosen_at_run_time_give_the_bits_of_the_firmware() {
    use bump_stop::{BEAM_MODES, IMPACTING, LONG, ROD_MODES, SHORT, TOUCHING, TOUCHING_STEPS, bench, others};
    let scene = shipped("bump-stop", &[]);
    let Model::BumpStop(model) = &scene.model else { panic!("a bump-stop scene") };
    let mut parameters = bump_stop_parameters::<f32>(model, scene.load);
    let mut any = |plan, gap, steps| {
        parameters.choices.stop.gap = gap;
        let run = bump_stop::run::<AnyChoices<f32>, BEAM_MODES, ROD_MODES>(plan, parameters, steps);
        states(&mut run.expect("valid"))
    };

    let firmware = states_of(bench);
    assert_eq!(firmware[0].len(), 4);
    assert_eq!([any(IMPACTING, bump_stop::GAP, [SHORT, LONG])], firmware[..]);
    assert_eq!(any(TOUCHING, 0.0, TOUCHING_STEPS), states_of(others)[0]);
}

#[test]
fn the_emitted_scene_holds_the_mean_power_of_the_shipped_one() {
    use firmware_example::workload::emitted::{self, scene};

    let states = states_of(emitted::bench);
    let [_, window] = &states[0][..] else { panic!("two stretches") };
    let shipped = shipped("contact-separation-passive", &[]);
    let power = f64::from(f32::from_bits(window[0])) / shipped.run.window_s();
    let change = |exact: f64| (power / exact - 1.0).abs();
    assert!(change(f64::from(scene::MEAN_POWER)) <= f64::from(scene::ACCURACY));
    let options = Options { method: Method::Reference, ..Options::default() };
    let reference = run_scene(&shipped, &options).expect("runs").mean_power_w.expect("a window");
    assert!(change(reference) <= f64::from(scene::ACCURACY), "{power} {reference}");
}
