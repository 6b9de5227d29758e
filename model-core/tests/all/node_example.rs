//! The example of a node.

#[allow(dead_code, reason = "the example's own output")]
#[path = "../../examples/node.rs"]
mod node;

#[test]
fn the_node_of_the_example_tells_its_day_within_its_bound_for_about_a_hundredth_of_it() {
    let day = node::day().expect("a day");
    let error = (day.told - day.truth).abs();
    assert!(error <= day.bound && day.bound < 0.15 * day.truth, "{error} {} {}", day.bound, day.truth);
    assert!(day.hours >= 20 && day.inside + 2 >= day.hours, "{} of {}", day.inside, day.hours);
    assert!(day.share > 0.0 && day.share < 0.02, "{}", day.share);
}
