//! A whole map of a linear harvester against its closed form, and what is refused.

use super::axes::level_of;
use super::*;
use crate::closed_form::estimate;
use crate::method::Precision;
use crate::scene_file::{Excitation, Tone, read_shipped};
use model_core::energy::Response;

fn scene(name: &str, changes: &[(&str, &str)]) -> Scene {
    read_shipped(name, changes).expect("a shipped scene")
}

fn request(amplitudes: [f64; 2], frequencies: [f64; 2]) -> Request {
    Request { amplitudes, frequencies, voltages: Vec::new(), error: 0.5, places: 30, seed: 1 }
}

/// Power of the closed form in W at amplitude and frequency in m/s² and Hz.
fn closed_form(scene: &Scene, amplitude_m_per_s2: f64, frequency_hz: f64) -> f64 {
    let tone = Tone { amplitude_m_per_s2, frequency_hz, phase_rad: 0.0 };
    let scene = Scene { excitation: Excitation::Sine(tone), ..scene.clone() };
    estimate(&scene, Precision::F64).expect("a closed form").mean_power_w
}

#[test]
fn axes_place_columns_over_the_whole_range_and_find_them_again() {
    let scene = scene("contact-separation", &[]);
    for range in [[17.0, 23.0], [20.0, 20.3], [20.5, 26.0], [5.0, 60.0]] {
        let axes = Axes::new(&scene, &request([0.1, 4.0], range), &Options::default()).expect("in bounds");
        assert_eq!(axes.frequencies.len(), 33);
        for (end, found) in range.into_iter().zip([axes.frequencies[0], axes.frequencies[32]]) {
            // A unit of the detuning, far from the resonance.
            assert!((found - end).abs() < 0.02 * axes.half_bandwidth_hz, "{end} {found}");
        }
        for (index, &frequency) in axes.frequencies.iter().enumerate() {
            let (below, part) = axes.column(frequency);
            assert!((below as f64 + part - index as f64).abs() < 0.03, "{index} {below} {part}");
        }
    }
    // 20.13 Hz, softened by the charge, and the damping ratio of 0.005.
    let axes = Axes::new(&scene, &request([0.1, 4.0], [17.0, 23.0]), &Options::default()).expect("in bounds");
    assert!((axes.centre_hz - 20.13).abs() < 1.0, "{}", axes.centre_hz);
    assert!((0.08..0.3).contains(&axes.half_bandwidth_hz), "{}", axes.half_bandwidth_hz);
}

#[test]
fn a_linear_harvester_has_the_power_of_its_closed_form_all_over_its_map() {
    let changes = [("parameters.beam_modes", "2")];
    let scene = scene("bump-stop-none", &changes);
    let options = Options { step_s: Some(1e-4), long_step_s: Some(1e-4), ..Options::default() };
    let request = request([1.0, 2.0], [225.0, 255.0]);
    let axes = Axes::new(&scene, &request, &Options::default()).expect("in bounds");
    let columns: Vec<Column> = axes
        .frequencies
        .iter()
        .map(|&frequency| {
            with_continuation(&scene, frequency, &options, |continuation| {
                column::column(continuation, frequency, request.amplitudes)
            })
            .expect("a steady motion")
        })
        .collect();
    let unbounded: Vec<SliceBounds> = vec![Default::default()];
    let slices = [columns];
    let content = Content {
        axes: &axes,
        fingerprint: 7,
        voltages: &[0.0],
        is_current: false,
        slices: &slices,
        margin: 30.0,
        bounds: &unbounded,
    };
    let image = content.image().expect("an image");
    let map = image.map().expect("a map");
    for (index, &frequency) in axes.frequencies.iter().enumerate() {
        for amplitude in [1.0, 1.3, 2.0] {
            let exact = closed_form(&scene, amplitude, frequency);
            // The ends are within a unit of the frequency.
            let inner = frequency
                + if index == 0 {
                    0.01
                } else if index == 32 {
                    -0.01
                } else {
                    0.0
                };
            let Response::One { income, .. } = map.at(amplitude as f32, inner as f32) else {
                panic!("{frequency} is inside")
            };
            let error = f64::from(income.value) / exact - 1.0;
            assert!(error.abs() < 6e-3, "{frequency} {amplitude}: {error}");
        }
    }
    assert!(matches!(map.at(0.9, 240.0), Response::Outside(_)));

    // The page tells the same of its cells.
    let agreement = Agreement {
        places: 0,
        median: 0.0,
        percentile_90: 0.0,
        largest: 0.0,
        bounds_hold: 1.0,
        regime_right: 1.0,
        far_places: 0,
        median_bounds_ratio: 1.0,
    };
    let map = Map {
        image,
        slices: slices.to_vec(),
        checked: Vec::new(),
        agreement,
        margin: 0.0,
        broadband: None,
        periods: 0.0,
        axes,
        statements: Statements::default(),
    };
    let picture = super::picture(&map, "a linear beam").and_then(|picture| picture.svg()).expect("a picture");
    // A resistor has no voltage of a slice; this map has neither boundaries nor places that check it.
    assert!(
        picture.contains("a linear beam")
            && !picture.contains("storage at")
            && !picture.contains("motion ends")
    );
    let page = super::picture(&map, "a linear beam").and_then(|picture| picture.page()).expect("a page");
    let charts =
        page.split("const charts = ").nth(1).and_then(|rest| rest.split(";\n").next()).expect("charts");
    let charts: serde_json::Value = serde_json::from_str(charts).expect("JSON");
    let readout = |title: &str, index: usize| {
        let readouts = charts[0]["field"]["readouts"].as_array().expect("a list");
        let found = readouts
            .iter()
            .find(|readout| readout["title"].as_str().is_some_and(|text| text.contains(title)));
        found
            .and_then(|readout| readout["values"][index].as_f64())
            .unwrap_or_else(|| panic!("{title} of cell {index}"))
    };
    let across = charts[0]["field"]["x"].as_array().expect("edges").len() - 1;
    for index in [0, across / 2, 20 * across + 3, 40 * across + across / 2] {
        let (amplitude, frequency) =
            (readout("amplitude [", index / across), readout("frequency [", index % across));
        let error = readout("mean power [", index) * 1e-6 / closed_form(&scene, amplitude, frequency) - 1.0;
        assert!(error.abs() < 0.05 && page.contains("mean power [µW]"), "cell {index}: {error}");
    }
}

/// A map behind a bridge, of which a boundary was found and a place is wrong, in words.
#[test]
fn a_picture_says_what_its_lines_and_dots_are_and_its_voltage() {
    let scene = scene("contact-separation", &[]);
    let axes = Axes::new(&scene, &request([0.5, 2.0], [19.0, 21.0]), &Options::default()).expect("in bounds");
    let column = |&frequency_hz: &f64| Column {
        frequency_hz,
        rising: level_of(1.5),
        falling: level_of(0.8),
        found: true,
        lower: vec![(level_of(0.4), 1e-6), (level_of(1.5), 2e-6)],
        upper: vec![(level_of(0.8), 3e-6), (level_of(2.5), 4e-6)],
    };
    let slices = [axes.frequencies.iter().map(column).collect::<Vec<Column>>()];
    let unbounded: Vec<SliceBounds> = vec![Default::default()];
    let content = Content {
        axes: &axes,
        fingerprint: 7,
        voltages: &[3.0],
        is_current: true,
        slices: &slices,
        margin: 30.0,
        bounds: &unbounded,
    };
    let image = content.image().expect("an image");
    let place = OperatingPoint { slice: 0, frequency_hz: 20.0, amplitude: 1.0 };
    let truth = Truth { lower: Some(9e-6), upper: None };
    let readout = image.map().expect("a map").in_slice_at(0, 1.0, 20.0);
    let checked = vec![judge(readout, [level_of(1.5), level_of(0.8)], place, truth)];
    let agreement = Agreement::of(&checked).expect("an error");
    let slices = slices.to_vec();
    let statements = Statements::default();
    let map = Map {
        image,
        axes,
        slices,
        checked,
        agreement,
        margin: 0.0,
        broadband: None,
        periods: 0.0,
        statements,
    };
    let picture =
        super::picture(&map, "rectified.toml").and_then(|picture| picture.svg()).expect("a picture");
    for words in [
        "Response map of rectified.toml",
        "storage at 3.00 V",
        "the lower motion ends as the amplitude rises",
        "the upper motion ends as the amplitude falls",
    ] {
        assert!(picture.contains(words), "{words} is not in the picture");
    }
    // A page has the places that check the map, after a click.
    assert!(!picture.contains("checked:"), "marks of checks in the picture");
    let page = super::picture(&map, "").and_then(|picture| picture.page()).expect("a page");
    assert!(page.matches("\"hidden\":true").count() == 1 && page.contains("checked: the bounds do not hold"));
}

#[test]
fn a_motion_with_contact_now_and_then_is_the_upper_one() {
    // Beyond the boundary the motion is not periodic here, and has windows of a time constant without contact.
    let scene = scene("node", &[]);
    let request = request([0.1, 4.0], [17.0, 24.0]);
    let axes = Axes::new(&scene, &request, &Options::default()).expect("in bounds");
    for frequency in [axes.frequencies[8], axes.frequencies[9]] {
        let column = with_continuation(&scene, frequency, &Options::default(), |continuation| {
            column::column(continuation, frequency, request.amplitudes)
        })
        .expect("steady motions");
        let Column { rising, falling, found, lower, upper, .. } = &column;
        assert!(*found && falling <= rising, "{column:?}");
        // The upper motion is followed from the boundary to above the map, and the lower one up to the boundary.
        let ends = [upper.first(), upper.last(), lower.last()].map(|end| end.map_or(f64::NAN, |end| end.0));
        assert!(ends[0] < rising + 10.0 && ends[1] >= axes::level_of(4.0), "{column:?}");
        assert!((ends[2] - rising).abs() < 1e-6, "{column:?}");
        for points in [lower, upper] {
            assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0), "{column:?}");
        }
    }
}

#[test]
fn a_map_needs_power_or_a_voltage() {
    let amplitudes = request([0.1, 4.0], [17.0, 23.0]);
    let refused = |scene: &Scene, request: &Request| scenes(scene, request).is_err();
    for load in ["0", "inf"] {
        assert!(refused(&scene("contact-separation", &[("load.resistance_ohm", load)]), &amplitudes));
    }
    assert!(refused(&scene("rectified", &[]), &amplitudes));
    let voltages = Request { voltages: vec![2.0, 3.0], ..amplitudes };
    assert!(refused(&scene("contact-separation", &[]), &voltages));
    assert_eq!(scenes(&scene("rectified", &[]), &voltages).expect("a bridge").len(), 2);
}
