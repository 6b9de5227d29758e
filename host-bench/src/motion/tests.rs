use std::f64::consts::TAU;

use super::*;
use crate::method::Options;
use crate::run::run_scene;
use crate::scene_file::{self, Override};

#[test]
fn the_spectrum_of_two_sines_has_their_amplitudes() {
    let rows: Vec<(f64, f64)> = (0..20_000)
        .map(|row| {
            let time = f64::from(row) * 1e-4;
            (time, 5.0 + 3.0 * (TAU * 20.0 * time).sin() + 0.5 * (TAU * 60.0 * time + 1.0).cos())
        })
        .collect();
    let found = series::amplitudes(&rows, [0.0, 2.0], 200.0, None);
    let near = |frequency: f64| {
        let around = found.iter().filter(|(other, _)| (other - frequency).abs() < 0.6);
        around.fold(0.0_f64, |most, (_, amplitude)| most.max(*amplitude))
    };
    assert!((near(20.0) - 3.0).abs() < 0.01, "{}", near(20.0));
    assert!((near(60.0) - 0.5).abs() < 0.01, "{}", near(60.0));
    // The mean is not a line, and nothing is between the lines.
    assert!(near(0.0) < 0.01 && near(40.0) < 1e-3 && near(150.0) < 1e-3);
    assert_eq!(series::amplitudes(&rows[..1], [0.0, 2.0], 200.0, None), []);
}

fn run(name: &str, sets: &[(&str, &str)], every_s: f64) -> (Scene, Series) {
    let sets: Vec<Override> = sets.iter().map(|(key, value)| Override::new(key, value)).collect();
    let scene = scene_file::read(&scene_file::shipped(name), &sets).expect("valid");
    let options = Options { trace_every_s: Some(every_s), ..Options::default() };
    let outcome = run_scene(&scene, &options).expect("it can be run");
    let series = Series::of("run", &scene, &outcome);
    (scene, series)
}

const SHORT: [(&str, &str); 1] = [("run", "{duration_s=1.0, settle_s=0.5}")];

#[test]
fn a_picture_has_its_quantities_with_units_its_impacts_and_its_flow() {
    let (scene, series) = run("contact-separation-passive", &SHORT, 1e-4);
    assert!(!series.impacts_s.is_empty());
    // The mass is at the dielectric where it hits it.
    for impact in &series.impacts_s {
        let gap = series.at("gap_m", *impact).expect("within the rows");
        assert!(gap.abs() < 2e-5, "{gap} m at {impact} s");
    }
    let svg =
        picture(&usual(&scene, "the title", &series, 1e-4), &[series]).and_then(|picture| picture.svg());
    let svg = svg.expect("a picture");
    let texts = "the title,gap [mm],voltage [V],power [µW],impact,phase portrait,velocity [mm/s],frequency [Hz],\
        from the base,into the load";
    for text in texts.split(',') {
        assert!(svg.contains(text), "{text} is not in the picture");
    }
    assert!(!svg.contains("NaN"));
    // Neither diodes nor a law that creates energy: what is 0 J has no row.
    assert!(!svg.contains("diodes") && !svg.contains("created by the force law"));
}

#[test]
fn the_energy_of_the_base_is_that_of_its_parts() {
    for (name, created) in
        [("contact-separation-passive", false), ("contact-separation", true), ("bump-stop", false)]
    {
        let (_, series) = run(name, &SHORT, 1e-3);
        let parts = series.flow.expect("of the core").parts();
        let part = |wanted: &str| parts.iter().find(|(name, _)| *name == wanted).expect("a part").1;
        let base = part("from the base");
        assert!(
            base > 0.0 && part("damping and friction") > 0.0 && part("contact") >= 0.0,
            "{name}: {parts:?}"
        );
        // Only a law that is not derived from the field creates energy.
        let share = part("created by the force law").abs() / base;
        assert_eq!(share > 1e-3, created, "{name}: {parts:?}");
        // What is left is the motion and the field at the end, less those at the start.
        assert!(part("left in motion and field").abs() < 0.5 * base, "{name}: {parts:?}");
    }
}

#[test]
fn several_runs_are_named_and_a_bump_stop_has_a_portrait() {
    let span = [("run", "{duration_s=0.1, settle_s=0.05}")];
    let (scene, mut one) = run("bump-stop", &span, 2e-5);
    one.name = "gap_m = 10 µm".to_owned();
    let (_, mut other) = run("bump-stop", &[span[0], ("stop.gap_m", "30e-6")], 2e-5);
    other.name = "gap_m = 30 µm".to_owned();
    let wanted = usual(&scene, "the title", &one, 2e-5);
    assert!(wanted.quantities.contains(&"contact_force_n".to_owned()));
    let svg = picture(&wanted, &[one, other]).and_then(|picture| picture.svg()).expect("a picture");
    for text in
        ["gap_m = 10 µm", "gap_m = 30 µm", "tip displacement [µm]", "contact force [N]", "velocity [mm/s]"]
    {
        assert!(svg.contains(text), "{text} is not in the picture");
    }
}

#[test]
fn a_column_is_words_and_a_unit() {
    assert_eq!(number_and_unit("base_acceleration_m_per_s2"), ("base acceleration".to_owned(), "m/s²"));
    assert_eq!(number_and_unit("gap_m"), ("gap".to_owned(), "m"));
    assert_eq!(number_and_unit("stuck"), ("stuck".to_owned(), ""));
}

/// The charts of a page.
fn charts(page: &str) -> serde_json::Value {
    let data = page.split("const charts = ").nth(1).expect("the data").split(";\n").next().expect("an end");
    serde_json::from_str(&data.replace("<\\/", "</")).expect("JSON")
}

#[test]
fn a_page_has_its_data_and_needs_no_network() {
    let (scene, mut one) = run("contact-separation-passive", &SHORT, 1e-4);
    one.name = "</script>".to_owned();
    let mut other = one.clone();
    other.name = "other".to_owned();
    let wanted = usual(&scene, "a < b", &one, 1e-4);
    let gap = one.over_time("gap_m");
    let page = picture(&wanted, &[one, other]).and_then(|picture| picture.page()).expect("a page");
    // The signs of the legend are drawn by data URLs of the script.
    let page = page.replace("url(\"data:image/svg+xml,", "");
    for outside in ["<link", "src=", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert_eq!(page.matches("</script>").count(), 2, "no text ends a script");
    assert!(page.contains("a &lt; b") && page.contains("from the base"));
    let charts = charts(&page);
    let all = charts.as_array().expect("charts");
    assert_eq!(all.len(), wanted.quantities.len() + 2);
    assert_eq!((&all[0]["up"], &all[0]["curves"][0]["name"]), (&"gap [mm]".into(), &"</script>".into()));
    let shown: Vec<&(f64, f64)> =
        gap.iter().filter(|(time, _)| (wanted.span_s[0]..=wanted.span_s[1]).contains(time)).collect();
    let values = all[0]["curves"][0]["y"].as_array().expect("values");
    assert_eq!(values.len(), shown.len());
    for (value, (_, gap)) in values.iter().zip(shown) {
        assert!((value.as_f64().expect("a number") - 1e3 * gap).abs() < 1e-5);
    }
    assert_eq!(all[wanted.quantities.len()]["logarithmic"], serde_json::json!([false, true]));
    // The portrait goes round: its points are in the order of the time, which the pointer shows.
    let portrait = &all[wanted.quantities.len() + 1];
    let x: Vec<f64> =
        portrait["curves"][1]["x"].as_array().expect("values").iter().filter_map(|x| x.as_f64()).collect();
    assert!(portrait["orbits"] == true && x.windows(2).any(|pair| pair[0] > pair[1]));
    assert_eq!(portrait["curves"][1]["notes"].as_array().map(Vec::len), Some(x.len()));
    assert!(
        page.contains("<title>into the load: ") && page.contains(" % of what comes from the base</title>")
    );
}

#[test]
fn rows_of_a_long_span_resolve_the_excitation_and_its_harmonics() {
    let read = |sets: &[(&str, &str)]| {
        let sets: Vec<Override> = sets.iter().map(|(key, value)| Override::new(key, value)).collect();
        scene_file::read(&scene_file::shipped("contact-separation"), &sets).expect("valid")
    };
    let scene = read(&[("run", "{duration_s=60.0, settle_s=10.0}"), ("excitation.frequency_hz", "20.5")]);
    for span in [[0.0, 60.0], [59.9, 60.0], span_s(&scene)] {
        let every = every_s(&scene, span);
        // Of a short span 3000, as far as a run of a million has them.
        let most = ((span[1] - span[0]) / 3000.0).clamp(60.0 / 1e6, 1.0 / (80.0 * 20.5));
        assert!((every / most - 1.0).abs() < 1e-9, "{every} {most}");
        assert!((highest_hz(&scene, every) / (20.0 * 20.5) - 1.0).abs() < 1e-9, "{span:?}");
        assert_eq!(unresolved(&scene, every), None);
    }
    // A million rows are too few for a day.
    let day = read(&[("run", "{duration_s=86400.0, settle_s=10.0}"), ("excitation.frequency_hz", "20.5")]);
    let text = unresolved(&day, every_s(&day, [0.0, 86_400.0])).expect("told");
    assert!(text.starts_with("0.6 rows in a period of 20.5 Hz"), "{text}");
}

#[test]
fn a_long_time_history_keeps_its_extremes() {
    let points: Vec<(f64, f64)> =
        (0..100_000).map(|row| (f64::from(row), (0.37 * f64::from(row)).sin())).collect();
    let mut spiked = points.clone();
    spiked[54_321].1 = 7.0;
    spiked[77_777].1 = -9.0;
    let drawn = thinned(spiked);
    assert!(drawn.len() <= 8000 && drawn.is_sorted_by(|one, other| one.0 <= other.0));
    assert!(drawn.contains(&(54_321.0, 7.0)) && drawn.contains(&(77_777.0, -9.0)));
    assert_eq!(thinned(points[..8000].to_vec()), points[..8000]);
}
