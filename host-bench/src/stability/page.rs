//! The page of the grid: counts, causes of errors, maps and the cases that fail.

use std::fmt::Write;

use super::map::{Axis, Map, STEP};
use super::summary::{causes, classes, statements};
use super::{Case, Row};
use crate::report::html::{document, escaped};

/// The file beside the page that has a row for each case.
pub(crate) const CASES: &str = "cases.csv";

const RESISTANCE: Axis = Axis { title: "load resistance [Ω]", key: "load.resistance_ohm" };
const DENSITY: Axis = Axis { title: "charge density [C/m²]", key: "parameters.charge_density_c_per_m2" };
const FREQUENCY: Axis = Axis { title: "frequency [Hz]", key: "excitation.frequency_hz" };
const FRICTION: Axis = Axis { title: "kinetic friction", key: "parameters.kinetic_friction_active" };
const AMPLITUDE: Axis = Axis { title: "amplitude [m/s²]", key: "excitation.amplitude_m_per_s2" };
const STEP_AXIS: Axis = Axis { title: "step [s]", key: STEP };
const GAP: Axis = Axis { title: "gap [m]", key: "stop.gap_m" };
const BEAM_MODES: Axis = Axis { title: "beam modes", key: "parameters.beam_modes" };
const MODULUS: Axis = Axis { title: "modulus of the rod [Pa]", key: "stop.young_modulus_pa" };

const MAPS: [Map; 8] = [
    Map { scene: "contact-separation", across: RESISTANCE, up: DENSITY },
    Map { scene: "contact-separation", across: RESISTANCE, up: FREQUENCY },
    Map { scene: "sliding", across: RESISTANCE, up: DENSITY },
    Map { scene: "sliding", across: RESISTANCE, up: FREQUENCY },
    Map { scene: "sliding", across: AMPLITUDE, up: FRICTION },
    Map { scene: "bump-stop", across: STEP_AXIS, up: GAP },
    Map { scene: "bump-stop", across: STEP_AXIS, up: MODULUS },
    Map { scene: "bump-stop", across: STEP_AXIS, up: BEAM_MODES },
];

/// The page as HTML. The rows are those of the cases, in their order.
pub(crate) fn page(cases: &[Case], rows: &[Row]) -> String {
    let mut body = String::from("<h1>Stiff and extreme scenes</h1>\n");
    let _ = writeln!(
        body,
        "<p>{} runs, each judged with its accuracy statement by a more accurate run. Each run is a row of \
         <a href=\"{CASES}\">{CASES}</a>, with the arguments that repeat it.</p>",
        rows.len()
    );
    body.push_str(&table(&classes(rows)));
    body.push_str(&table(&statements(rows)));
    let causes = causes(rows);
    if causes.len() > 1 {
        body.push_str("<h2>Named errors by cause</h2>\n");
        body.push_str(&table(&causes));
    }
    for map in MAPS {
        if let Some(svg) = map.svg(cases, rows) {
            let title = format!("{}: {} against {}", map.scene, map.across.title, map.up.title);
            let _ = writeln!(body, "<h2>{}</h2>\n<figure>{}</figure>", escaped(&title), svg.trim_end());
            let note =
                "A cell holds every case with both values; the width of a colour is the share of the class.";
            let _ = writeln!(body, "<p class=\"note\">{note}</p>");
        }
    }
    let failing: Vec<&Row> = rows.iter().filter(|row| row.class.is_failure()).collect();
    if !failing.is_empty() {
        body.push_str("<h2>Wrong and broken</h2>\n");
        for row in failing {
            let (reason, arguments) = (escaped(&row.reason), escaped(&row.arguments));
            let _ = writeln!(body, "<p>{reason}<br><code>{arguments}</code></p>");
        }
    }
    document("Stiff and extreme scenes", &body)
}

/// A table of which the first row has the headings, and the columns but the first are numbers.
fn table(rows: &[Vec<String>]) -> String {
    let Some((heading, rows)) = rows.split_first() else { return String::new() };
    let line = |row: &[String], tag: &str| {
        let class = |index: usize| if index == 0 { "" } else { " class=\"number\"" };
        let cells = row.iter().enumerate();
        let cells = cells.map(|(index, cell)| format!("<{tag}{}>{}</{tag}>", class(index), escaped(cell)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = rows.iter().map(|row| line(row, "td")).collect();
    format!("<div class=\"wide\"><table>\n<thead>{}</thead>\n{rows}</table></div>\n", line(heading, "th"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Precision;
    use crate::stability::{Class, Effort};

    fn sliding(resistance: &str, density: &str, precision: Precision) -> Case {
        Case::of("sliding", &[resistance, density], precision).with("run", "{duration_s=0.1,settle_s=0}")
    }

    /// Two settings in both precisions, with rows of their own classes.
    fn judged() -> (Vec<Case>, Vec<Row>) {
        let settings = [("load.resistance_ohm=1e6", "0e0"), ("load.resistance_ohm=inf", "2e-5")];
        let cases: Vec<Case> = settings
            .iter()
            .flat_map(|(resistance, density)| {
                let density = format!("parameters.charge_density_c_per_m2={density}");
                [Precision::F32, Precision::F64].map(|precision| sliding(resistance, &density, precision))
            })
            .collect();
        // Given up at once: the rows get their classes below.
        let effort = Effort { most_attempts: 1, by_reference: false };
        let mut rows: Vec<Row> =
            cases.iter().enumerate().flat_map(|case| Row::judged(&[case], effort)).collect();
        let classes = [Class::Right, Class::Warned, Class::NamedError, Class::Wrong];
        for (row, class) in rows.iter_mut().zip(classes) {
            row.class = class;
            row.reason = "displacement = 0.02 is outside the model's domain at 1 s: <x>".to_owned();
        }
        (cases, rows)
    }

    #[test]
    fn the_page_has_counts_causes_maps_and_what_fails() {
        let (cases, rows) = judged();
        let page = page(&cases, &rows);
        for part in [
            "4 runs",
            "<td>right</td>",
            "<td>left the overlap of the patches</td>",
            "sliding: load resistance [Ω] against charge density [C/m²]",
            "load resistance [Ω] 10⁶, charge density [C/m²] 0: 1 right",
            "load resistance [Ω] ∞, charge density [C/m²] 2e-5: 1 wrong",
            "model's domain at 1 s: &lt;x&gt;<br><code>run host-bench/scenes/sliding.toml --precision f64",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
        // The other maps have no case.
        assert_eq!(page.matches("<svg").count(), 1);
    }

    #[test]
    fn a_cell_is_in_the_panel_of_its_precision_at_its_values() {
        let (cases, rows) = judged();
        let svg = MAPS[2].svg(&cases, &rows).expect("has cases");
        let right = svg.find("1 right").expect("a cell");
        let warned = svg.find("1 warned").expect("a cell");
        assert!(right < warned, "f32 is drawn before f64: {svg}");
        assert_eq!(svg.matches("<g>").count(), 4);
    }
}
