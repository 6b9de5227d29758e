//! `plot`, `run --picture`, shell completions and `--quiet`.

use super::tool::{
    BEAM, BUMP_STOP, PASSIVE, accepted, charts, folder, host_bench, json, place, printed, refused,
};

const SHORT: [&str; 2] = ["--set", "run={duration_s=1.0,settle_s=0.5}"];

#[test]
fn a_plot_has_runs_and_traces() {
    let folder = folder("plot");
    let [trace, svg] = ["trace.csv", "plot.svg"].map(|name| place(&folder, name));
    let run = ["run", PASSIVE, "--no-accuracy", "--trace", &trace, "--trace-every", "1e-3"];
    accepted(&[&run[..], &SHORT].concat());
    let plot = ["plot", PASSIVE, &trace, "--compare", "load.resistance_ohm=1e6,1e8", "--output", &svg];
    assert_eq!(accepted(&[&plot[..], &SHORT].concat()).trim(), svg);
    let picture = std::fs::read_to_string(&svg).expect("the picture");
    for text in [
        "contact-separation-passive.toml",
        "1.962 m/s², 20.5 Hz",
        "load resistance = 1 MΩ",
        "load resistance = 100 MΩ",
        "trace.csv",
        "gap [mm]",
        "phase portrait",
        "from the base",
    ] {
        assert!(picture.contains(text), "{text} is not in the picture");
    }
    // One quantity, one view.
    let plot = ["plot", PASSIVE, "--view", "history", "--quantity", "velocity_m_per_s", "--output", &svg];
    accepted(&[&plot[..], &SHORT].concat());
    let picture = std::fs::read_to_string(&svg).expect("the picture");
    assert!(picture.contains("velocity [mm/s]") && !picture.contains("phase portrait"));
}

#[test]
fn a_bad_plot_is_refused_before_it_runs() {
    let with =
        |more: &[&str], parts: &[&str]| refused(&[&["plot", PASSIVE], &SHORT[..], more].concat(), parts);
    with(&["--quantity", "speed"], &["--quantity speed", "gap_m, velocity_m_per_s"]);
    with(&["--from", "2"], &["--from 2", "1 s"]);
    with(&["--from", "0.5", "--to", "0.4"], &["--to 0.4"]);
    with(&["--compare", "load.resistance_ohm"], &["--compare", "KEY=VALUE,VALUE"]);
    with(&["no-such.csv"], &["no-such.csv", "cannot be read"]);
    with(&[PASSIVE], &["must be a trace of run --trace"]);
    with(&["--output", PASSIVE], &["--output", "which this command reads"]);
}

#[test]
fn a_run_has_its_picture_in_a_printed_width() {
    let svg = place(&folder("picture"), "run.svg");
    let outcome = json(&[&["run", PASSIVE, "--picture", &svg, "--width", "85mm"], &SHORT[..]].concat());
    assert!(outcome["accuracy"]["total"].is_number());
    let picture = std::fs::read_to_string(&svg).expect("the picture");
    assert!(picture.contains("phase portrait"));
    // 7 pt of 25.4/72 mm are 14.5 of the units of the view box, as the library writes the size of the text.
    let units = 85.0 / (7.0 * 25.4 / 72.0 / 14.516);
    assert!(picture.starts_with("<svg width=\"85mm\" height=\""), "{}", &picture[..80]);
    assert!(picture.contains(&format!("viewBox=\"0 0 {units:.0} ")));
    let sizes = picture.split("font-size=\"").skip(1).map(|rest| rest.split('"').next()?.parse().ok());
    let sizes: Vec<f64> = sizes.map(|size| size.expect("a size")).collect();
    assert!(!sizes.is_empty() && sizes.iter().all(|size| *size > 14.49), "{sizes:?}");
    for text in ["8mm", "85", "85px"] {
        refused(&["run", PASSIVE, "--width", text], &["--width", text, "80mm to 420mm"]);
    }
    for arguments in
        [&["run", PASSIVE][..], &["keys"], &["sweep", PASSIVE, "--over", "load.resistance_ohm=1k:1M:2"], &[]]
    {
        refused(&[arguments, &["--width", "85mm"]].concat(), &["--width 85mm", "no file of a picture"]);
    }
    for page in [["plot", PASSIVE, "--output", "page.html"], ["run", PASSIVE, "--picture", "page.html"]] {
        refused(&[&page[..], &["--width", "85mm"]].concat(), &["--width 85mm", "page.html is a page"]);
    }
}

#[test]
#[cfg(not(feature = "images"))]
fn a_pdf_needs_another_build() {
    refused(
        &["plot", PASSIVE, "--output", "motion.pdf"],
        &["motion.pdf", ".svg or .html", "--features images"],
    );
}

/// A PDF has its size in points of 1/72 inch, a PNG 300 pixels an inch.
#[test]
#[cfg(feature = "images")]
fn a_pdf_and_a_png_have_the_printed_width() {
    let folder = folder("images");
    let [pdf, png] = ["motion.pdf", "motion.png"].map(|name| {
        let file = place(&folder, name);
        accepted(&[&["plot", PASSIVE, "--width", "85mm", "--output", &file], &SHORT[..]].concat());
        std::fs::read(&file).expect("the picture")
    });
    let box_of_page =
        String::from_utf8_lossy(&pdf).split_once("/MediaBox [0 0 ").map(|(_, rest)| rest.to_owned());
    let wide: f64 = box_of_page.and_then(|rest| rest.split(' ').next()?.parse().ok()).expect("a page");
    assert!((wide - 85.0 * 72.0 / 25.4).abs() < 0.1, "{wide}");
    let wide = u32::from_be_bytes(png[16..20].try_into().expect("a header"));
    assert_eq!(wide, (85.0_f64 / 25.4 * 300.0).floor() as u32);
    // Text is drawn: more than the lines alone are black.
    assert!(pdf.windows(5).any(|word| word == b"/Font"));
}

#[test]
fn shells_complete_commands_and_options() {
    for (shell, part) in [("bash", "--trace-every"), ("zsh", "--trace-every"), ("fish", "trace-every")] {
        let script = accepted(&["completions", shell]);
        assert!(script.contains(part) && script.contains("resonance"), "{shell}");
    }
    refused(&["completions", "csh"], &["csh", "bash"]);
    let script = super::tool::file(&folder("completions"), "script", accepted(&["completions", "bash"]));
    let asked = "source \"$0\"; COMP_WORDS=(host-bench fit --fr); COMP_CWORD=2; \
                 _host__bench host-bench --fr fit; echo \"${COMPREPLY[*]}\"";
    let output = std::process::Command::new("bash").args(["-c", asked]).arg(&script).output();
    let told = output.expect("bash runs").stdout;
    assert_eq!(String::from_utf8_lossy(&told).trim(), "--free");
}

#[test]
fn a_picture_that_is_no_picture_by_its_name_is_refused() {
    for command in ["run", "plot"] {
        let option = if command == "run" { "--picture" } else { "--output" };
        refused(&[command, PASSIVE, option, "motion.png"], &[option, "motion.png", ".svg or .html"]);
    }
}

#[test]
fn a_quiet_command_tells_warnings_only() {
    let file = place(&folder("quiet"), "sliding.toml");
    assert!(host_bench(&["--quiet", "new", "sliding", "--output", &file]).stderr.is_empty());
    let [duration, settle] = ["--set=run.duration_periods=4", "--set=run.settle_periods=1"];
    let [_, told] = printed(&["run", "--quiet", &file, duration, settle]);
    assert!(told.lines().all(|line| line.starts_with("warning: ")), "{told}");
}

#[test]
fn a_warning_of_several_runs_is_told_once() {
    let picture = place(&folder("plot-warnings"), "runs.svg");
    let compare = ["--compare", "excitation.frequency_hz=20,20.2,20.4", "--output", &picture];
    let short = ["--set", "run={duration_s=2,settle_s=1}"];
    let [_, told] = printed(&[&["plot", PASSIVE], &compare[..], &short].concat());
    assert_eq!(told.matches("model: fringing").count(), 1, "{told}");
    assert!(told.contains("3 of 3 runs: model: fringing"), "{told}");
}

/// A beam without a stop has no contact force.
#[test]
fn nothing_that_is_not_there_is_drawn() {
    for name in ["none.svg", "none.html"] {
        let file = place(&folder("plot-none"), name);
        accepted(&["plot", BEAM, "--set", "run={duration_s=0.1,settle_s=0.05}", "--output", &file]);
        let picture = std::fs::read_to_string(&file).expect("the picture");
        assert!(picture.contains("tip displacement") && !picture.contains("contact force"), "{name}");
        assert!(!picture.contains(">NaN<") && !picture.contains("[0,0,0,0,0"), "{name}");
    }
}

/// The voltage repeats with each period of 1/20.5 s: there is nothing between its harmonics but noise.
#[test]
fn a_periodic_motion_has_no_subharmonics() {
    let page = place(&folder("plot-spectrum"), "spectrum.html");
    accepted(&["plot", PASSIVE, "--set", "load.resistance_ohm=10M", "--view", "spectrum", "--output", &page]);
    let html = std::fs::read_to_string(&page).expect("the page");
    let charts = charts(&html);
    let numbers = |key: &str| -> Vec<f64> {
        let all = charts[0]["curves"][0][key].as_array().expect("a list");
        all.iter().map(|value| value.as_f64().expect("a number")).collect()
    };
    let (frequencies, lines) = (numbers("x"), numbers("y"));
    let largest = lines.iter().copied().fold(0.0, f64::max);
    let part = |frequency: f64| (frequency / 20.5 - (frequency / 20.5).round()).abs();
    let between = frequencies.iter().zip(&lines).filter(|(frequency, _)| part(**frequency) > 0.2);
    let noise = between.map(|(_, line)| *line).fold(0.0, f64::max);
    assert!(noise < 2e-5 * largest, "{noise} beside {largest}");
    assert!(html.contains("noise floor of a line"), "the noise floor is marked");
    // So it is of a beam that hits its stop, in the unit of its time history.
    let views = ["--view", "history", "--view", "spectrum", "--quantity", "voltage_v", "--output", &page];
    accepted(
        &[&["plot", BUMP_STOP, "--set", "run={duration_periods=20,settle_periods=4}"], &views[..]].concat(),
    );
    let html = std::fs::read_to_string(&page).expect("the page");
    let charts = self::charts(&html);
    assert!([0, 1].iter().all(|chart| charts[*chart]["up"] == "voltage [V]"), "{charts}");
    assert!(html.contains("noise floor of a line"), "the noise floor is marked");
}

#[test]
fn a_scene_comes_from_standard_input_and_a_picture_goes_to_standard_output() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_host-bench"))
        .args(["plot", "-", "--view", "history", "--output", "-", SHORT[0], SHORT[1]])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let text = std::fs::read(PASSIVE).expect("the scene");
    child.stdin.take().expect("a pipe").write_all(&text).expect("written");
    let output = child.wait_with_output().expect("it ends");
    let picture = String::from_utf8(output.stdout).expect("text");
    assert!(
        output.status.success() && picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"),
        "{picture}"
    );
    refused(
        &["run", PASSIVE, "--picture", "-", "--trace", "-", "--trace-every", "1e-3"],
        &["another output"],
    );
}
