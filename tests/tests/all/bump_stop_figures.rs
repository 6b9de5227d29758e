//! What the bump-stop figures are made of.

use cross_crate_tests::{assert_close, fixed, shipped};
use host_bench::embedded::deflected_shapes;
use host_bench::figures::bump_stop::{CONTACT_FORCE, Motion, TIP};
use host_bench::method::Options;
use host_bench::run::run_scene;
use host_bench::scene_file::{RunSpan, Scene};

fn over(name: &str, duration_s: f64) -> Scene {
    Scene { run: RunSpan { duration_s, settle_s: 0.0 }, ..shipped(name, &[]) }
}

/// The sum of the mode shapes ends where the trace, which sums values of its own at the tip, says, and is
/// level and at rest at the clamp.
#[test]
fn a_deflected_shape_ends_at_the_tip_of_the_trace() {
    let scene = over("bump-stop-mid-span", 0.02);
    let step = 2e-6;
    let instants = [4e-3, 9e-3, 15e-3];
    let shapes = deflected_shapes(&scene, &fixed(step), &instants, 200).expect("it can be run");
    let traced = Options { trace_every_s: Some(step), ..fixed(step) };
    let trace = run_scene(&scene, &traced).expect("it can be run").trace.expect("a trace was asked for");
    assert_eq!(shapes.len(), instants.len());
    for (shape, instant) in shapes.iter().zip(instants) {
        assert!((shape.time_s - instant).abs() <= step, "{} s for {instant} s", shape.time_s);
        let row = &trace.rows[(shape.time_s / step).round() as usize];
        let [first, second, .., last] = shape.points[..] else { panic!("stations") };
        let ([clamp, near], tip) = ([first, second].map(|point| point.displacement_m), last.displacement_m);
        assert_close("tip", tip, row[TIP], 1e-4);
        assert!(first.distance_m == 0.0 && clamp.abs() < 1e-9 * tip.abs(), "{first:?}");
        assert!(first.slope.abs() < 1e-9 * last.slope.abs(), "{first:?}");
        // Slope and curvature are those of the displacements, by differences.
        let most = shape.points.iter().map(|point| point.curvature_per_m.abs()).fold(0.0, f64::max);
        for three in shape.points.windows(3) {
            let [before, here, after] = [0, 1, 2].map(|index| three[index].displacement_m);
            let distance = three[1].distance_m - three[0].distance_m;
            let slope = 0.5 * (after - before) / distance;
            let curvature = (before - 2.0 * here + after) / (distance * distance);
            assert!((slope - three[1].slope).abs() < 0.02 * most * distance, "{three:?}");
            assert!((curvature - three[1].curvature_per_m).abs() < 0.02 * most, "{three:?}");
        }
        // Clamped: displacement grows with the square of the distance, curvature at most ten times the mean.
        assert!(near.abs() < 10.0 * tip.abs() / 200.0_f64.powi(2) * 10.0, "{second:?} and {last:?}");
    }
}

#[test]
fn the_longest_cluster_is_found_between_pauses() {
    let force = |from: f64, to: f64, time: f64| f64::from(u8::from((from..to).contains(&time)));
    let rows = (0..4000).map(|index| {
        let time = 1e-6 * f64::from(index);
        // Two contacts 100 µs apart are of one cluster; one a millisecond later is of another.
        let push = force(1e-3, 1.01e-3, time) + force(1.11e-3, 1.12e-3, time) + force(2.2e-3, 2.25e-3, time);
        let mut row = vec![time, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        row[CONTACT_FORCE] = push;
        row
    });
    let motion = Motion { frequency: 220.0, rows: rows.collect() };
    let [first, last] = motion.longest_cluster().expect("contacts");
    assert!((first - 1e-3).abs() < 1.5e-6 && (last - 1.119e-3).abs() < 1.5e-6, "{first} to {last} s");
    let [first, last] = motion.longest_contact([0.0, 4e-3]).expect("contacts");
    assert!((first - 2.2e-3).abs() < 1.5e-6 && (last - 2.249e-3).abs() < 1.5e-6, "{first} to {last} s");
    let still = Motion { frequency: 220.0, rows: motion.rows[..900].to_vec() };
    assert_eq!(still.longest_cluster(), None);
}
