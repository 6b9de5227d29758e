//! More than a year of both tiers: each quarter is known as the first.

use host_bench::simulated_node::{Storage, years};

use super::capacitor;

#[test]
fn each_quarter_of_four_hundred_days_is_inside_its_bounds() {
    let supercapacitor =
        Storage { name: "supercapacitor", leakage: 40e6, of_capacitance: 0.2, ..Storage::capacitor(0.2) };
    let quarters = years(400, &[capacitor(10e-3, 0.0), supercapacitor]).expect("steps");
    // Two tiers, two storages, still and noisy nights, six stresses, four quarters.
    assert_eq!(quarters.len(), 2 * 2 * 2 * 6 * 4);
    for (index, quarter) in quarters.iter().enumerate() {
        assert_eq!(quarter.quarter as usize, 1 + index % 4);
        assert!(quarter.hours > 1500 && quarter.inside >= 0.95, "{quarter:?}");
        assert!(quarter.bound_over_first <= 1.2 && quarter.resolved_over_first <= 1.2, "{quarter:?}");
        let off = (quarter.sum_estimated_j - quarter.sum_true_j).abs();
        assert!(quarter.sum_true_j > 10.0 && off <= quarter.sum_bound_j, "{quarter:?}");
        assert!(quarter.share > 1e-4 && quarter.share <= 0.01, "{quarter:?}");
        let faults = [quarter.refused_images, quarter.frozen_hours, quarter.not_a_number];
        assert_eq!(faults, [0; 3], "{quarter:?}");
    }
    let text = format!("{:?}", quarters[0]);
    let keys = "tier storage capacitance_f still_nights stress quarter hours inside bound_over_first \
                resolved_over_first silent sum_estimated_j sum_bound_j sum_true_j share refused_images \
                frozen_hours not_a_number";
    let keys: Vec<_> = keys.split(' ').collect();
    let places: Vec<_> = keys.iter().map(|key| text.find(&format!(" {key}: ")).expect(key)).collect();
    assert!(places.is_sorted() && text.matches(": ").count() == keys.len(), "{text}");
}
