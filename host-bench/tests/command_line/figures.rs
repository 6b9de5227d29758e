//! The figures that the documentation shows.

use std::path::Path;

use super::tool::{accepted, folder};

/// Name in the documentation, and the file that the command makes. The picture of run times is that of one machine.
const SHOWN: [(&str, &str); 4] = [
    ("bump-stop-figure-7.svg", "bump-stop/figure-7.svg"),
    ("figure-8b.svg", "contact-separation/figure-8b.svg"),
    ("figure-10.svg", "contact-separation/figure-10.svg"),
    ("sliding-figure-6a.svg", "sliding/figure-6a.svg"),
];

#[test]
#[ignore = "nightly: half a minute of two cores"]
fn the_figures_of_the_documentation_are_those_that_the_command_makes() {
    let made = folder("figures");
    accepted(&["figures", "--output", made.to_str().expect("a plain path")]);
    let page = std::fs::read_to_string(made.join("contact-separation/index.html")).expect("a page");
    assert!(page.contains("50 µC/m², 100 MΩ, 1.962 m/s², 20.2 Hz: attractors: the start decides"));
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    for (name, file) in SHOWN {
        let text = |path: &Path| std::fs::read_to_string(path).expect("a figure");
        assert!(text(&shipped.join(name)) == text(&made.join(file)), "cp {file} host-bench/figures/{name}");
    }
}
