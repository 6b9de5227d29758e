//! Pages in a real browser, Chromium or Chrome without a window: charts are drawn, and zoom, hover and toggles work.

use std::path::Path;
use std::process::Command;

use super::tool::{MEASURED, NODE, PASSIVE, accepted, file, folder, place};

const SHORT: [&str; 2] = ["--set", "run={duration_s=1.0,settle_s=0.5}"];

/// Collects errors from the beginning on.
const WATCH: &str =
    "<script>window.faults=[];window.addEventListener('error',e=>faults.push(e.message));</script>";
/// What a reader does with each chart, and what is then to be seen, as text at the end of the page.
const USE: &str = r#"<script>
window.addEventListener("load", () => setTimeout(() => {
  const told = [];
  for (const root of document.querySelectorAll(".uplot")) {
    const over = root.querySelector(".u-over");
    const frame = over.getBoundingClientRect();
    const at = (type, x, y) => (type === "mouseup" ? document : over).dispatchEvent(new MouseEvent(type, {
      bubbles: true, clientX: frame.left + x * frame.width, clientY: frame.top + y * frame.height, button: 0, movementX: 9,
    }));
    // The cells of a map are at every place between its axes, whether linear or logarithmic.
    const [canvas, parts] = [root.querySelector("canvas"), Array.from({ length: 20 }, (_, at) => (at + 0.5) / 20)];
    const box = canvas.getBoundingClientRect();
    const pixel = (x, y) => [frame.left - box.left + x * frame.width, frame.top - box.top + y * frame.height]
      .map((at) => at * devicePixelRatio);
    const alpha = (x, y) => canvas.getContext("2d").getImageData(...pixel(x, y), 1, 1).data[3];
    const covered = parts.every((x) => parts.every((y) => alpha(x, y) === 255));
    // Hover: the nearest point of the whole chart.
    let tip = "";
    for (let x = 0.02; x < 1 && !tip; x += 0.02)
      for (let y = 0.02; y < 1 && !tip; y += 0.04) {
        at("mousemove", x, y);
        const found = root.querySelector(".tip");
        if (found.style.display === "block") tip = found.textContent;
      }
    // Toggle: Enter on the last name of a curve that is seen hides it, a click shows it. Zoom and return by keys.
    const names = root.querySelectorAll(".u-series:not(.u-off)");
    const last = names[names.length - 1];
    const press = (element, key) => element.dispatchEvent(new KeyboardEvent("keydown", { key }));
    press(last.querySelector("th"), "Enter");
    const hidden = last.classList.contains("u-off");
    last.querySelector("th").click();
    const shown = !last.classList.contains("u-off");
    // Zoom: a drag over the middle.
    const pixels = () => root.querySelector("canvas").toDataURL();
    const before = pixels();
    at("mousemove", 0.4, 0.5); at("mousedown", 0.4, 0.5); at("mousemove", 0.5, 0.5); at("mousemove", 0.6, 0.5);
    at("mouseup", 0.6, 0.5);
    told.push({ tip, covered, hidden, shown, root, pixels, before, press, over });
  }
  // The library ignores a move by nothing, and draws between two frames.
  const later = (each, then) => setTimeout(() => { told.forEach(each); then(); }, 200);
  later((one) => { one.zoomed = one.pixels() !== one.before; one.press(one.over, "Escape"); }, () =>
  later((one) => { one.whole = one.pixels() === one.before; one.press(one.over, "+"); }, () =>
  later((one) => { one.pressed = one.pixels() !== one.before; }, () => {
    const charts = told.map(({ tip, covered, hidden, shown, zoomed, whole, pressed }) =>
      ({ tip, covered, hidden, shown, zoomed, whole, pressed }));
    const place = document.createElement("pre");
    place.id = "found";
    place.textContent = JSON.stringify({ faults, charts });
    document.body.append(place);
  })));
}, 100));
</script>"#;

/// Opens a page and uses it; the number of its charts.
#[track_caller]
fn used(html: impl AsRef<Path>) -> Vec<serde_json::Value> {
    let html = html.as_ref();
    let page = std::fs::read_to_string(html).expect("the page");
    let watched = page.replacen("<head>", &format!("<head>{WATCH}"), 1) + USE;
    let watched = file(html.parent().expect("a folder"), "watched.html", watched);
    let browse = |browser: &&str| {
        let mut command = Command::new(browser);
        command.args(["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1280,1600"]);
        command.args(["--virtual-time-budget=5000", "--dump-dom"]);
        command.arg(format!("file://{watched}")).output().ok()
    };
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let output = browsers.iter().find_map(browse).expect("a browser");
    let dom = String::from_utf8_lossy(&output.stdout);
    let found = dom.split("<pre id=\"found\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let found = found.unwrap_or_else(|| panic!("the page has not come to its end: {dom}"));
    let found = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let found: serde_json::Value = serde_json::from_str(&found).expect("JSON");
    assert_eq!(found["faults"], serde_json::json!([]), "{}", html.display());
    let charts = found["charts"].as_array().expect("a list").clone();
    for chart in &charts {
        for what in ["hidden", "shown", "zoomed", "whole", "pressed"] {
            assert_eq!(chart[what], true, "{what} of {}: {chart}", html.display());
        }
    }
    charts
}

/// Whether these charts, and no others, have cells at every place between their axes.
fn are_maps(charts: &[serde_json::Value], maps: &[bool]) -> bool {
    charts.iter().map(|chart| chart["covered"].as_bool()).eq(maps.iter().map(|is_map| Some(*is_map)))
}

/// Whether the pointer shows all of it at some chart.
fn tells(charts: &[serde_json::Value], parts: &[&str]) -> bool {
    let tips = charts.iter().filter_map(|chart| chart["tip"].as_str());
    tips.into_iter().any(|tip| parts.iter().all(|part| tip.contains(part)))
}

#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_a_plot() {
    let html = place(&folder("page-plot"), "plot.html");
    accepted(&[&["plot", PASSIVE, "--output", &html], &SHORT[..]].concat());
    let charts = used(&html);
    // Gap, power and voltage over time, the spectrum, and the phase portrait.
    assert_eq!(charts.len(), 5);
    assert!(tells(&charts[..1], &["time: ", " s", "gap: ", " mm"]), "{charts:?}");
    assert!(tells(&charts[4..], &["gap: ", " mm", "velocity: ", " mm/s", "time: ", " s"]), "{charts:?}");
}

#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_a_sweep() {
    let folder = folder("page-sweep");
    let path = folder.to_str().expect("a plain path");
    let one = ["--over", "excitation.frequency_hz=19:22:13", "--no-accuracy", "--output", path];
    accepted(&[&["sweep", PASSIVE], &one[..], &SHORT[..]].concat());
    let charts = used(folder.join("sweep.html"));
    assert_eq!(charts.len(), 2);
    assert!(tells(&charts, &["excitation frequency: ", " Hz", "mean power: ", " µW"]), "{charts:?}");
    let two =
        [&["sweep", PASSIVE, "--over", "load.resistance_ohm=1e7:1e9:3:log"], &one[..], &SHORT[..]].concat();
    accepted(&two);
    let charts = used(folder.join("sweep.html"));
    // Curves and maps of mean power and RMS voltage.
    assert!(are_maps(&charts, &[false, false, true, true]), "{charts:?}");
    assert!(tells(&charts[..2], &["load resistance = ", "RMS voltage: ", " V"]), "{charts:?}");
    let cell = ["load resistance: ", " Ω", "excitation frequency: ", " Hz", "mean power: ", " µW"];
    assert!(tells(&charts[2..], &cell), "{charts:?}");
}

#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_an_optimum() {
    let html = place(&folder("page-optimise"), "best.html");
    let one =
        ["--over", "excitation.frequency_hz=18:22", "--grid", "9", "--steady-state", "--picture", &html];
    let command = ["optimise", MEASURED, "--maximise", "mean_power_w"];
    accepted(&[&command[..], &one[..]].concat());
    let charts = used(&html);
    // The curve, and the way of the search.
    assert_eq!(charts.len(), 2);
    assert!(tells(&charts[..1], &["excitation frequency: ", "mean power: "]), "{charts:?}");
    assert!(tells(&charts[1..], &["run: ", "mean power: ", "excitation.frequency_hz = "]), "{charts:?}");
    accepted(&[&command[..], &one, &["--over", "load.resistance_ohm=1e7:1e10:log"]].concat());
    let charts = used(&html);
    assert!(are_maps(&charts, &[true, false]), "{charts:?}");
    let cell = ["excitation frequency: ", "load resistance: ", "mean power: "];
    assert!(tells(&charts[..1], &cell), "{charts:?}");
}

#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_a_map() {
    let html = place(&folder("page-map"), "map.html");
    let range = ["--amplitude", "0.5:3", "--frequency", "18:23", "--places", "30", "--picture", &html];
    let text = accepted(&[&["map", PASSIVE], &range[..]].concat());
    assert!(text.contains("largest_income_w ") && !text.contains("largest_income_a"), "{text}");
    let charts = used(&html);
    assert!(are_maps(&charts, &[true]), "{charts:?}");
    let cell =
        ["frequency: ", " Hz", "detuning: ", "amplitude: ", "mean power: ", " µW", "at most: ", "motion"];
    assert!(tells(&charts, &cell), "{charts:?}");
}

#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_a_fit() {
    let html = place(&folder("page-fit"), "fit.html");
    accepted(&["fit", MEASURED, "--picture", &html]);
    let charts = used(&html);
    // Voltage and gap, each with its residuals.
    assert_eq!(charts.len(), 4);
    assert!(
        tells(&charts, &["measured", "frequency: ", " Hz", "mV"]) || tells(&charts, &["model", " mV"]),
        "{charts:?}"
    );
}

#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_the_day_of_a_node_and_the_report() {
    let folder = folder("page-report");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-bench"));
        assert!(command.current_dir(&folder).args(arguments).output().expect("it starts").status.success());
    };
    run(&["budget", NODE]);
    let charts = used(folder.join("report/budget.html"));
    assert!(
        charts.len() >= 3 && tells(&charts, &["hour of the day: ", "stored energy: ", " mJ"]),
        "{charts:?}"
    );
    run(&[]);
    let charts = used(folder.join("report/index.html"));
    assert!(charts.len() >= 2, "{charts:?}");
    let parts =
        ["relative error of mean power: ", "host time per simulated second: ", " µs", "step or tolerance: "];
    assert!(tells(&charts, &parts), "{charts:?}");
}

/// A formula, quotes, a line break, an escape sequence and markup, for a file and for an action; what of it runs is a fault.
const HOSTILE: &str = "=1+1\"'`&\n\u{1b}[31m<!--<script><img src=x onerror=faults.push(1)>";

#[cfg(unix)]
#[test]
#[ignore = "nightly: needs Chromium"]
fn a_browser_draws_the_pages_of_hostile_names() {
    let folder = folder("page-hostile");
    let shipped = |scene: &str| std::fs::read_to_string(scene).expect("a shipped scene");
    let named = |ending: &str, content: String| file(&folder, &format!("{HOSTILE}.{ending}"), content);
    let scene = named("toml", shipped(PASSIVE));
    let data = named("data.csv", shipped(&MEASURED.replace(".toml", ".csv")));
    let measured = named("fit.toml", shipped(MEASURED));
    let action = serde_json::to_string(&format!("{HOSTILE}</script>")).expect("a text");
    let node = named("node.toml", shipped(NODE).replacen("\"measure\"", &action, 1));
    let trace = format!("{scene}.csv");
    let run = |arguments: &[&str], is_short: bool, page: &str, charts: usize| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-bench"));
        command.current_dir(&folder).args(arguments).args(SHORT.iter().filter(|_| is_short));
        let output = command.output().expect("it starts");
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {told}");
        assert!(!told.contains('\u{1b}') && !output.stdout.contains(&0x1b), "{arguments:?}: {told}");
        let found = used(folder.join(page));
        assert_eq!(found.len(), charts, "{arguments:?}: {found:?}");
    };
    let frequency = ["--over", "excitation.frequency_hz=18:22"];
    run(
        &["run", &scene, "--trace", &trace, "--trace-every", "1e-3", "--picture", "run.html"],
        true,
        "run.html",
        5,
    );
    run(&["plot", &scene, &trace, "--output", "plot.html"], true, "plot.html", 5);
    let sweep = ["sweep", &scene, "--over", "excitation.frequency_hz=19:22:4", "--no-accuracy"];
    run(&[&sweep[..], &["--output", "sweep"]].concat(), true, "sweep/sweep.html", 2);
    let optimise = ["optimise", &measured, "--maximise", "mean_power_w", "--grid", "5", "--steady-state"];
    run(&[&optimise[..], &frequency, &["--picture", "best.html"]].concat(), false, "best.html", 2);
    let range = ["--amplitude", "0.5:1", "--frequency", "19:20", "--places", "30", "--picture", "map.html"];
    run(&[&["map", &scene], &range[..]].concat(), false, "map.html", 1);
    run(&["attractors", &scene, "--starts", "16", "--picture", "starts.html"], true, "starts.html", 1);
    run(&["fit", &measured, "--data", &data, "--picture", "fit.html"], false, "fit.html", 4);
    run(&["budget", &node], false, "report/budget.html", 4);
}
