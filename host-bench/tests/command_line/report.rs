//! `report`: the page on a design.

use std::fs::read_to_string;

use super::tool::{BEAM, BUMP_STOP, NODE, PASSIVE, accepted, folder, place, refused};

const SECTIONS: &str =
    "Resonance,Load curve,Motion,Margins to physical limits,Stress and life,Tolerance,Day of the node,Scene";

/// The page of a scene, and the text of each section.
fn sections(name: &str, arguments: &[&str]) -> (String, Vec<String>) {
    let page = place(&folder(&format!("report-{name}")), "design.html");
    let output = ["--samples", "20", "--output", &page];
    let printed = accepted(&[&["report"], arguments, &output].concat());
    assert!(printed.trim_end().ends_with("design.html"), "{printed}");
    let html = read_to_string(&page).expect("the page");
    let body = html.split("<script>").next().expect("a body").to_owned();
    for word in ["NaN", ">inf<", "undefined"] {
        assert!(!body.contains(word), "{name}: {word}");
    }
    let headings = body.split("<h2>").skip(1).map(|part| part.split("</h2>").next().expect("a heading"));
    assert_eq!(headings.collect::<Vec<_>>().join(","), SECTIONS);
    let texts = body.split("<h2>").skip(1).map(str::to_owned).collect();
    (html, texts)
}

/// The sections that are left out, which say why.
fn absent(texts: &[String]) -> Vec<&str> {
    let all = SECTIONS.split(',').zip(texts).filter(|(_, text)| text.contains("Left out: "));
    all.map(|(name, _)| name).collect()
}

#[test]
fn a_beam_without_and_with_a_stop_has_its_sections() {
    for (name, scene, end) in [
        ("beam", BEAM, "run={duration_s=0.3,settle_s=0.2}"),
        ("stop", BUMP_STOP, "run={duration_s=0.02,settle_s=0.01}"),
    ] {
        let sets = ["--set", end, "--set", "parameters.beam_modes=1", "--precision", "f64"];
        let (html, texts) = sections(name, &[&[scene], &sets[..]].concat());
        assert_eq!(absent(&texts), ["Day of the node"], "{name}");
        for (section, word) in [
            (0, "excitation frequency [Hz]"),
            (1, "load resistance [Ω]"),
            (2, "mean_power_w"),
            (3, "margin"),
            (4, "clamp_stress_equivalent_range_pa"),
            (5, "percentile_5"),
            (7, "parameters.beam_modes=1"),
        ] {
            assert!(texts[section].contains(word), "{name}: {word} in {}", texts[section]);
        }
        // On paper each section of charts is one SVG.
        for section in [0, 1, 2, 5] {
            assert_eq!(texts[section].matches("<figure class=\"still\"><svg").count(), 1, "{name} {section}");
        }
        assert!(html.contains("@media print{.still{display:block"), "{name}");
        assert!(texts[0].contains(" role=\"img\" aria-label=\"mean power ["), "{name}");
        for text in &texts[..2] {
            let best = text.split("largest mean_power_w").nth(1).and_then(|best| best.lines().next());
            let mut numbers =
                best.expect("the best").split(|letter: char| !letter.is_ascii_digit() && letter != '.');
            assert!(numbers.all(|number| number.len() <= 9), "{best:?}");
            // Without a stop both curves are smooth.
            assert!(name == "stop" || text.contains("between two points of the"), "{text}");
        }
    }
}

#[test]
fn a_report_leaves_out_what_a_scene_does_not_have() {
    let short = ["--set", "run={duration_s=1.0,settle_s=0.5}"];
    let (_, texts) = sections("node", &[&[NODE], &short[..]].concat());
    assert_eq!(absent(&texts), ["Stress and life"]);
    assert!(texts[6].contains("hour of the day") && texts[6].contains("verdict"), "{}", texts[6]);
    let open = ["--set", "load.resistance_ohm=inf"];
    let (_, texts) = sections("open", &[&[PASSIVE], &short[..], &open].concat());
    assert_eq!(absent(&texts), ["Load curve", "Stress and life", "Day of the node"]);
    assert!(texts[1].contains("load.resistance_ohm is no positive number in the scene"), "{}", texts[1]);
}

#[test]
fn bad_input_of_a_report_is_refused() {
    refused(&["report", PASSIVE, "--output", "report.svg"], &["--output", "report.svg", "must end in .html"]);
    refused(&["report", PASSIVE, "--vary", "no.key=±1%"], &["no.key"]);
    refused(&["report", PASSIVE, "--samples", "3"], &["--samples", "20"]);
    refused(&["report", PASSIVE, "--set", "load.resistance_ohm=-1"], &["load.resistance_ohm", "-1"]);
    let help = accepted(&["report", "--help"]);
    for word in ["--vary", "--samples", "--output", "report/design.html", "Run time"] {
        assert!(help.contains(word), "{word}: {help}");
    }
}
